//! Hierarchies of cells: octree, octree-R, kd-tree and BSP tree.
//!
//! ```text
//! cells of up to eight octants:  octant_tree <- octree (midpoints), octree_r (least cost)
//! cells that a plane divides:    plane_tree  <- kd_tree (least cost), bsp_tree (midpoints)
//! ```
//! An index is a tree with a policy, which chooses the planes. `filing` files triangles in cells, and
//! finds the level.

#[cfg(feature = "bsp-tree")]
mod bsp_tree;
mod filing;
#[cfg(feature = "kd-tree")]
mod kd_tree;
#[cfg(any(feature = "octree", feature = "octree-r"))]
pub(crate) mod octant_tree;
#[cfg(feature = "octree")]
mod octree;
#[cfg(feature = "octree-r")]
mod octree_r;
#[cfg(any(feature = "kd-tree", feature = "bsp-tree"))]
pub(crate) mod plane_tree;
#[cfg(any(feature = "octree-r", feature = "kd-tree"))]
mod split_cost;

#[cfg(feature = "bsp-tree")]
pub use bsp_tree::BspTree;
#[cfg(feature = "kd-tree")]
pub use kd_tree::KdTree;
#[cfg(feature = "octree")]
pub use octree::Octree;
#[cfg(feature = "octree-r")]
pub use octree_r::OctreeR;
