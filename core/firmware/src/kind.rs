//! Kind of index that the features choose. Two kinds at once are an error of the compiler.

#[cfg(feature = "bsp-tree")]
use arboleda::kinds::BspTree as Chosen;
#[cfg(feature = "bvh")]
use arboleda::kinds::Bvh as Chosen;
#[cfg(feature = "compact-bvh")]
use arboleda::kinds::CompactBvh as Chosen;
#[cfg(feature = "kd-tree")]
use arboleda::kinds::KdTree as Chosen;
#[cfg(feature = "lean-bvh")]
use arboleda::kinds::LeanBvh as Chosen;
#[cfg(not(any(
    feature = "octree",
    feature = "octree-r",
    feature = "uniform-grid",
    feature = "kd-tree",
    feature = "bsp-tree",
    feature = "bvh",
    feature = "wide-bvh",
    feature = "compact-bvh",
    feature = "lean-bvh"
)))]
use arboleda::kinds::Linear as Chosen;
#[cfg(feature = "octree")]
use arboleda::kinds::Octree as Chosen;
#[cfg(feature = "octree-r")]
use arboleda::kinds::OctreeR as Chosen;
#[cfg(feature = "uniform-grid")]
use arboleda::kinds::UniformGrid as Chosen;
#[cfg(feature = "wide-bvh")]
use arboleda::kinds::WideBvh as Chosen;

/// The kind.
#[cfg(not(feature = "hierarchy"))]
pub type Kind = Chosen;
/// The kind, over clusters.
#[cfg(feature = "hierarchy")]
pub type Kind = arboleda::kinds::Clustered<Chosen>;
