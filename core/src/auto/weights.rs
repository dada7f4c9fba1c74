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

/// One line for each index, as `cargo run --release -p arboleda-host -- compare --calibrate` prints them: least
/// squares of the relative errors over the built-in scenes in several settings, and behind each line how far
/// the measured times lie from it. Renew all lines together, on one quiet machine.
///
/// AMD EPYC (Zen 5), with AVX2, rustc 1.95.
const TABLE: &[(IndexKind, Weights)] = &[
    (IndexKind::Linear, Weights { ray: 30.0, node: 0.0, test: 17.7 }), // +-10%
    (IndexKind::Octree, Weights { ray: 0.0, node: 73.3, test: 25.2 }), // +-15%
    (IndexKind::OctreeHierarchy, Weights { ray: 0.0, node: 58.8, test: 24.4 }), // +-14%
    (IndexKind::OctreeR, Weights { ray: 0.0, node: 82.9, test: 27.3 }), // +-15%
    (IndexKind::OctreeRHierarchy, Weights { ray: 25.9, node: 57.1, test: 28.8 }), // +-19%
    (IndexKind::UniformGrid, Weights { ray: 211.4, node: 66.3, test: 25.6 }), // +-19%
    (IndexKind::GridHierarchy, Weights { ray: 0.0, node: 63.2, test: 56.9 }), // +-22%
    (IndexKind::KdTree, Weights { ray: 0.0, node: 27.4, test: 21.9 }), // +-18%
    (IndexKind::KdTreeHierarchy, Weights { ray: 43.7, node: 35.2, test: 19.1 }), // +-10%
    (IndexKind::BspTree, Weights { ray: 11.9, node: 26.9, test: 21.1 }), // +-14%
    (IndexKind::BspTreeHierarchy, Weights { ray: 0.0, node: 49.0, test: 17.1 }), // +-10%
    (IndexKind::Bvh, Weights { ray: 0.0, node: 75.5, test: 21.7 }),    // +-9%
    (IndexKind::BvhHierarchy, Weights { ray: 33.2, node: 60.1, test: 26.1 }), // +-8%
    (IndexKind::WideOctree, Weights { ray: 30.5, node: 39.8, test: 7.1 }), // +-11%
    (IndexKind::WideOctreeHierarchy, Weights { ray: 17.0, node: 50.2, test: 0.0 }), // +-14%
];

/// For an index that was never measured: such that it is not preferred for that.
const UNKNOWN: Weights = Weights { ray: 100.0, node: 80.0, test: 30.0 };

impl Weights {
    /// Those of an index.
    pub fn of(kind: IndexKind) -> Self {
        TABLE.iter().find(|(known, _)| *known == kind).map_or(UNKNOWN, |(_, weights)| *weights)
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
            assert!(TABLE.iter().any(|(known, _)| known == kind), "{}", kind.name());
        }
    }
}
