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
/// hierarchy together, and behind each line how far the measured times lie from it. Renew all lines together,
/// on one quiet machine.
///
/// AMD EPYC, with AVX2, rustc 1.95. By hand: the linear scan's one node is that of a
/// kd-tree, because over thousands of tests it cannot be measured; and the nodes and tests of the compact and of
/// the lean octree are those of the wide octree and 15% and 55% more, as they take so many more instructions for
/// the same ones.
const TABLE: &[(IndexKind, Weights)] = &[
    (IndexKind::Linear, Weights { ray: 36.1, node: 34.1, test: 16.7 }), // +-11%
    (IndexKind::Octree, Weights { ray: 35.7, node: 54.1, test: 25.5 }), // +-19%
    (IndexKind::OctreeHierarchy, Weights { ray: 35.7, node: 54.1, test: 25.5 }), // +-19%
    (IndexKind::OctreeR, Weights { ray: 34.9, node: 53.3, test: 29.3 }), // +-16%
    (IndexKind::OctreeRHierarchy, Weights { ray: 34.9, node: 53.3, test: 29.3 }), // +-16%
    (IndexKind::UniformGrid, Weights { ray: 36.5, node: 57.0, test: 42.2 }), // +-16%
    (IndexKind::GridHierarchy, Weights { ray: 36.5, node: 57.0, test: 42.2 }), // +-16%
    (IndexKind::KdTree, Weights { ray: 35.9, node: 34.1, test: 16.8 }), // +-13%
    (IndexKind::KdTreeHierarchy, Weights { ray: 35.9, node: 34.1, test: 16.8 }), // +-13%
    (IndexKind::BspTree, Weights { ray: 35.1, node: 25.9, test: 21.5 }), // +-19%
    (IndexKind::BspTreeHierarchy, Weights { ray: 35.1, node: 25.9, test: 21.5 }), // +-19%
    (IndexKind::Bvh, Weights { ray: 35.1, node: 58.1, test: 20.0 }),    // +-11%
    (IndexKind::BvhHierarchy, Weights { ray: 35.1, node: 58.1, test: 20.0 }), // +-11%
    (IndexKind::WideOctree, Weights { ray: 11.5, node: 22.3, test: 8.7 }), // +-14%
    (IndexKind::WideOctreeHierarchy, Weights { ray: 11.5, node: 22.3, test: 8.7 }), // +-14%
    (IndexKind::CompactOctree, Weights { ray: 11.5, node: 25.6, test: 10.0 }), // by hand
    (IndexKind::CompactOctreeHierarchy, Weights { ray: 11.5, node: 25.6, test: 10.0 }), // by hand
    (IndexKind::LeanOctree, Weights { ray: 11.5, node: 34.6, test: 13.5 }), // by hand
    (IndexKind::LeanOctreeHierarchy, Weights { ray: 11.5, node: 34.6, test: 13.5 }), // by hand
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
