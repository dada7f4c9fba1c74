//! Oracles: right answers, computed in other ways than the core's and without its shortcuts.
//!
//! ```text
//! hit           plane, point, projected areas, in exact integers       checks geometry::kernel
//! rounding      exact quotients, rounded to the nearest f32
//! clusters      all pairs, breadth first                               checks clusters::find
//! cluster_tree  all pairs sorted, once a round                         checks the cluster tree
//! polygon       all pairs of sides, in whole numbers                   checks the host's division of polygons
//! ```

pub mod cluster_tree;
pub mod clusters;
pub mod hit;
pub mod polygon;
pub mod rounding;
