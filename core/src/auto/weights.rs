//! What a query takes, by index: measured, so that counters of different indices can be compared.

use crate::query::Counters;
use crate::{Float64, IndexKind};

/// Nanoseconds on the machine that a table was measured on; only their proportions matter.
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
    ("wide-bvh", Weights { ray: 4.1, node: 26.9, test: 0.5 }), // +-14%
    ("compact-bvh", Weights { ray: 17.4, node: 19.7, test: 8.1 }), // +-14%
    ("lean-bvh", Weights { ray: 21.0, node: 19.2, test: 12.4 }), // +-8%
];

/// The same table for processors that calculate `f64` in software: 10 ns an instruction on a Cortex-M4, with `f32` in
/// hardware. Fitted in the same way to the lines that `thumb_cost` of `tests/targets/bare_metal` prints in an emulator,
/// for 24 to 456 triangles; behind each line how far the counted instructions lie from it.
///
/// By hand: all but the wide BVHs have the test of the linear scan, because they call the same function. Most of the
/// cost of a ray and of a node is boxes in `f64`, and the hit, if there is one; the wide BVHs calculate with `f32`.
const SOFTWARE_TABLE: [(&str, Weights); 10] = [
    ("linear", Weights { ray: 36_390.0, node: 103_812.0, test: 1_934.0 }), // +-0%
    ("octree", Weights { ray: 37_692.0, node: 44_729.0, test: 1_934.0 }),  // +-7%
    ("octree-r", Weights { ray: 36_948.0, node: 42_411.0, test: 1_934.0 }), // +-8%
    ("uniform-grid", Weights { ray: 55_044.0, node: 90_339.0, test: 1_934.0 }), // +-10%
    ("kd-tree", Weights { ray: 38_784.0, node: 22_736.0, test: 1_934.0 }), // +-16%
    ("bsp-tree", Weights { ray: 48_775.0, node: 21_006.0, test: 1_934.0 }), // +-21%
    ("bvh", Weights { ray: 35_373.0, node: 57_647.0, test: 1_934.0 }),     // +-1%
    ("wide-bvh", Weights { ray: 776.0, node: 7_370.0, test: 13_838.0 }),   // +-1%
    ("compact-bvh", Weights { ray: 100.0, node: 11_218.0, test: 13_859.0 }), // +-1%
    ("lean-bvh", Weights { ray: 51.0, node: 12_396.0, test: 14_518.0 }),   // +-1%
];

/// For an index that was never measured: such that it is not preferred for that.
const UNKNOWN: Weights = Weights { ray: 100.0, node: 80.0, test: 30.0 };

impl Weights {
    /// Finds the weights of an index, for processors with `f64` in hardware or in software.
    pub fn of(kind: IndexKind, float64: Float64) -> Self {
        let table = match float64 {
            Float64::Hardware => &TABLE,
            Float64::Software => &SOFTWARE_TABLE,
        };
        table
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
            for table in [&TABLE, &SOFTWARE_TABLE] {
                let measured = table.iter().any(|(known, _)| *known == kind.family());
                assert!(measured, "{}", kind.name());
            }
        }
    }
}
