//! The indices: a folder for each family, and the linear scan, with which all agree bit for bit.
//!
//! Each family is a feature of this crate, so that one can be compiled without the others. The linear scan is always
//! there.
//!
//! To add an index: see *Adding an index* in `ARCHITECTURE.md`.

#[cfg(feature = "bvh")]
pub(crate) mod bvh;
#[cfg(any(feature = "octree", feature = "octree-r", feature = "kd-tree", feature = "bsp-tree"))]
pub(crate) mod cells;
mod clustered;
pub(crate) mod cost;
mod depth_first;
#[cfg(feature = "uniform-grid")]
pub(crate) mod grid;
pub(crate) mod linear;
mod ordered_traversal;
#[cfg(any(feature = "wide-bvh", feature = "compact-bvh", feature = "lean-bvh"))]
pub(crate) mod wide;

#[cfg(feature = "bvh")]
pub use bvh::Bvh;
#[cfg(feature = "bsp-tree")]
pub use cells::BspTree;
#[cfg(feature = "kd-tree")]
pub use cells::KdTree;
#[cfg(feature = "octree")]
pub use cells::Octree;
#[cfg(feature = "octree-r")]
pub use cells::OctreeR;
pub use clustered::Clustered;
#[cfg(feature = "uniform-grid")]
pub use grid::UniformGrid;
pub use linear::Linear;
#[cfg(feature = "compact-bvh")]
pub use wide::CompactBvh;
#[cfg(feature = "lean-bvh")]
pub use wide::LeanBvh;
#[cfg(feature = "wide-bvh")]
pub use wide::WideBvh;
