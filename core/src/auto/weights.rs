//! What a query takes, by index: measured, so that counters of different indices can be compared.

use crate::IndexKind;
use crate::query::Counters;

/// Nanoseconds on the machine that the table was measured on; only their proportions matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// For each ray.
    pub ray: f64,
    /// For each node visited.
    pub node: f64,
    /// For each triangle tested.
    pub test: f64,
}

/// One line for each family, as `cargo run --release -p arboleda-host -- compare --calibrate` prints them: least
/// squares of the relative errors over the built-in scenes in several settings, for a simple index and its
/// hierarchy together, and behind each line how far the measured times lie from it. Renew all lines together,
/// on one quiet machine.
///
/// AMD EPYC, with AVX2, rustc 1.95. By hand: the linear scan's one node is that of a
/// kd-tree, because over thousands of tests it cannot be measured.
const TABLE: [(&str, Weights); 10] = [
    ("linear", Weights { ray: 20.4, node: 30.0, test: 15.9 }), // +-8%
    ("octree", Weights { ray: 23.4, node: 69.6, test: 23.6 }), // +-19%
    ("octree-r", Weights { ray: 24.4, node: 64.0, test: 22.6 }), // +-21%
    ("uniform-grid", Weights { ray: 27.0, node: 71.1, test: 27.5 }), // +-20%
    ("kd-tree", Weights { ray: 27.4, node: 30.0, test: 19.7 }), // +-20%
    ("bsp-tree", Weights { ray: 26.8, node: 27.6, test: 20.8 }), // +-24%
    ("bvh", Weights { ray: 25.5, node: 76.8, test: 20.7 }),    // +-15%
    ("wide-octree", Weights { ray: 4.1, node: 26.9, test: 0.5 }), // +-14%
    ("compact-octree", Weights { ray: 17.4, node: 19.7, test: 8.1 }), // +-14%
    ("lean-octree", Weights { ray: 21.0, node: 19.2, test: 12.4 }), // +-8%
];

/// For an index that was never measured: such that it is not preferred for that.
const UNKNOWN: Weights = Weights { ray: 100.0, node: 80.0, test: 30.0 };

impl Weights {
    /// Those of an index.
    pub fn of(kind: IndexKind) -> Self {
        TABLE
            .iter()
            .find(|(known, _)| *known == kind.family())
            .map_or(UNKNOWN, |(_, weights)| *weights)
    }

    /// How long so many rays take that need so much, in nanoseconds.
    pub fn nanoseconds(&self, rays: u64, counters: &Counters) -> f64 {
        self.ray * rays as f64
            + self.node * counters.nodes_visited as f64
            + self.test * counters.triangle_tests as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_index_was_measured() {
        for kind in IndexKind::ALL {
            assert!(TABLE.iter().any(|(known, _)| *known == kind.family()), "{}", kind.name());
        }
    }
}
