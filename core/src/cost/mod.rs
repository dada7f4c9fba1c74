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
mod weights;

pub(crate) use best_level::{best_level, search_steps};
pub(crate) use probe::{Probe, ProbeRay, ray_count};
pub(crate) use sample::for_each_ray;
pub use weights::Weights;

use crate::input::CostModel;

/// Estimate of a tree's cost: that of a ray which meets the root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    model: CostModel,
    total: f64,
}

impl Estimate {
    pub fn new(model: &CostModel) -> Self {
        Self { model: *model, total: 0.0 }
    }

    /// Adds a node that a ray enters with this probability.
    pub fn add_node(&mut self, probability: f64) {
        self.total += self.model.traversal * probability;
    }

    /// Adds `count` triangle tests, which a ray takes with this probability.
    pub fn add_tests(&mut self, probability: f64, count: usize) {
        self.total += self.model.intersection * probability * count as f64;
    }

    pub fn total(&self) -> f64 {
        self.total
    }
}

/// Half the surface area of a box whose sides have these lengths.
pub(crate) fn half_area([x, y, z]: [f64; 3]) -> f64 {
    x * y + y * z + z * x
}
