//! The indices: a folder for each family, and the linear scan, with which all agree to the bit.
//!
//! Each kind is a feature of this crate, so that one can be had without the code of the others; the linear scan is
//! always there.
//!
//! To add an index, implement [`LocalIndex`](crate::custom::LocalIndex) in a file of its own behind a feature, and add
//! a line for each of its two kinds to `registry.rs` and its family to the tables of `opening.rs` and
//! `select/weights.rs`, where tests miss it.
//! The command line, the tests, the benches and the fuzz targets then run it, alone and clustered.

#[cfg(feature = "bvh")]
pub(crate) mod bvh;
#[cfg(any(feature = "octree", feature = "octree-r", feature = "kd-tree", feature = "bsp-tree"))]
pub(crate) mod cells;
mod clustered;
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
