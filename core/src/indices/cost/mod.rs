//! Cost model: estimates for choosing a level, a resolution and an index.
//!
//! # Source
//! - J. D. MacDonald, K. S. Booth 1990, the surface-area heuristic (SAH): the probability that a ray through a cell
//!   enters a part of the cell is the ratio of their surface areas.
//! - K. R. Subramanian, D. S. Fussell, *Automatic Termination Criteria for Ray Tracing Hierarchies*, 1991: go on
//!   dividing as long as the estimated cost of the whole hierarchy falls.

mod best_level;
mod probe;
mod sample;

pub(crate) use best_level::{BestLevel, level_search_steps, resolution_search_steps};
pub(crate) use probe::{Probe, ProbeRay, ray_count};
pub(crate) use sample::for_each_ray;

/// Half the surface area of a box whose sides have these lengths.
pub(crate) fn half_area([x, y, z]: [f64; 3]) -> f64 {
    x * y + y * z + z * x
}
