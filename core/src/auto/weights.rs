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
/// squares of the relative errors over the built-in scenes in several settings, for a simple index and its
/// hierarchy together, and behind each line how far the measured times lie from it. Renew all lines together, on one quiet machine.
///
/// AMD EPYC (Zen 5), with AVX2, rustc 1.95, on a busy machine. By hand: the linear scan's one node is that of a
/// kd-tree, because over thousands of tests it cannot be measured.
const TABLE: &[(IndexKind, Weights)] = &[
    (IndexKind::Linear, Weights { ray: 39.4, node: 30.6, test: 18.9 }), // +-10%
    (IndexKind::Octree, Weights { ray: 42.0, node: 57.7, test: 29.0 }), // +-15%
    (IndexKind::OctreeHierarchy, Weights { ray: 42.0, node: 57.7, test: 29.0 }), // +-15%
    (IndexKind::OctreeR, Weights { ray: 43.2, node: 43.5, test: 33.4 }), // +-13%
    (IndexKind::OctreeRHierarchy, Weights { ray: 43.2, node: 43.5, test: 33.4 }), // +-13%
    (IndexKind::UniformGrid, Weights { ray: 44.2, node: 59.3, test: 32.8 }), // +-21%
    (IndexKind::GridHierarchy, Weights { ray: 44.2, node: 59.3, test: 32.8 }), // +-21%
    (IndexKind::KdTree, Weights { ray: 40.8, node: 30.6, test: 20.8 }), // +-21%
    (IndexKind::KdTreeHierarchy, Weights { ray: 40.8, node: 30.6, test: 20.8 }), // +-21%
    (IndexKind::BspTree, Weights { ray: 41.8, node: 27.4, test: 22.2 }), // +-23%
    (IndexKind::BspTreeHierarchy, Weights { ray: 41.8, node: 27.4, test: 22.2 }), // +-23%
    (IndexKind::Bvh, Weights { ray: 39.9, node: 58.4, test: 21.8 }),    // +-15%
    (IndexKind::BvhHierarchy, Weights { ray: 39.9, node: 58.4, test: 21.8 }), // +-15%
    (IndexKind::WideOctree, Weights { ray: 44.5, node: 34.0, test: 8.5 }), // +-17%
    (IndexKind::WideOctreeHierarchy, Weights { ray: 44.5, node: 34.0, test: 8.5 }), // +-17%
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
