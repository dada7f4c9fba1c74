//! What is right, computed another way than the core computes it, and without its shortcuts.
//!
//! ```text
//! hit           plane, point, projected areas, in exact integers       against geometry::kernel
//! rounding      exact quotients to the nearest f32
//! clusters      all pairs, breadth first                               against cluster::find
//! cluster_tree  all pairs sorted, once a round                         against the cluster tree
//! polygon       all sides with all sides, in whole numbers             against the host's division of polygons
//! ```

pub mod cluster_tree;
pub mod clusters;
pub mod hit;
pub mod polygon;
pub mod rounding;
