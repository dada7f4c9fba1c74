//! Deciding by estimated cost: how deep, and which index.
//!
//! # Source
//! J. D. MacDonald, K. S. Booth 1990: the chance that a ray through a cell enters a part of it is the
//! ratio of their surfaces. K. R. Subramanian, D. S. Fussell, *Automatic Termination Criteria for Ray
//! Tracing Hierarchies*, 1991: go on dividing as long as the estimated cost of the whole hierarchy
//! falls.

mod sample;
mod selection;
mod trial;
mod weights;

pub use selection::{Candidate, Cost, Expectation, Selection, USUAL, select};
pub(crate) use trial::{Trial, Tried, ray_count};
pub use weights::Weights;

/// What a step and a test cost, in any unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostModel {
    /// Entering a node.
    pub traversal: f64,
    /// Testing a triangle.
    pub intersection: f64,
}

impl CostModel {
    /// A node costs so many triangle tests.
    pub const fn tests_per_node(tests: f64) -> Self {
        Self { traversal: tests, intersection: 1.0 }
    }
}

impl Default for CostModel {
    /// A node costs as much as a test.
    fn default() -> Self {
        Self::tests_per_node(1.0)
    }
}

/// The expected cost of a ray that meets the root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    model: CostModel,
    total: f64,
}

impl Estimate {
    pub fn new(model: &CostModel) -> Self {
        Self { model: *model, total: 0.0 }
    }

    /// A node that is entered with this probability.
    pub fn add_node(&mut self, probability: f64) {
        self.total += self.model.traversal * probability;
    }

    /// Tests of so many triangles with this probability.
    pub fn add_tests(&mut self, probability: f64, count: usize) {
        self.total += self.model.intersection * probability * count as f64;
    }

    pub fn total(&self) -> f64 {
        self.total
    }
}

/// Half the surface of a box with these sides.
pub(crate) fn surface([x, y, z]: [f64; 3]) -> f64 {
    x * y + y * z + z * x
}

/// The level of `0..=most` at which the cost stops falling.
///
/// Levels are tried from 0 upwards, so the work is dominated by the last ones: the search ends at the
/// second level in a row that is no better, or where the next would make the same tree.
pub(crate) fn best_level<E>(
    most: u32,
    mut cost_at: impl FnMut(u32) -> Result<f64, E>,
) -> Result<u32, E> {
    let mut best = (f64::INFINITY, 0);
    let mut last = f64::INFINITY;
    for level in 0..=most {
        let cost = cost_at(level)?;
        if cost == last {
            break;
        }
        last = cost;
        if cost < best.0 * LEAST_FALL {
            best = (cost, level);
        } else if level > best.1 + 1 {
            break;
        }
    }
    Ok(best.1)
}

/// A level that saves less than this is not worth its memory. It is small because the cost of a tree
/// around far clusters is mostly that of reaching them.
const LEAST_FALL: f64 = 0.9995;
