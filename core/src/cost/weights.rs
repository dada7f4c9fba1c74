//! What a query takes, by index: measured, so that counters of different indices can be compared.

use crate::query::Counters;

/// Costs of a query. Only their proportions matter.
///
/// Each index states them in [`Described`](crate::custom::Described), for two kinds of processor, and behind each line
/// how far the measured times lie from it. Renew all lines together, on one quiet machine.
///
/// # Measured
/// - `WEIGHTS`: nanoseconds, as `cargo run --release -p arboleda-host -- compare calibrate` prints them: least squares of
///   the relative errors over the built-in scenes in several settings, for a simple index and its hierarchy together.
///   AMD EPYC, with AVX2, rustc 1.95. By hand: the linear scan's one node is that of a kd-tree, because over thousands
///   of tests it cannot be measured.
/// - `SOFTWARE_WEIGHTS`: for processors that calculate `f64` in software, 10 ns an instruction on a Cortex-M4, with
///   `f32` in hardware. Fitted in the same way to the lines that `thumb_cost` of `tests/targets/bare_metal` prints in an
///   emulator, for 24 to 456 triangles. By hand: all but the wide family have the test of the linear scan, because they
///   call the same function. Most of the cost of a ray and of a node is boxes in `f64`, and the hit, if there is one;
///   the wide family calculates with `f32`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// For each ray.
    pub ray: f64,
    /// For each node visited.
    pub node: f64,
    /// For each triangle tested.
    pub test: f64,
}

impl Weights {
    /// Those of an index that was never measured: such that it is not preferred for that.
    pub const UNKNOWN: Self = Self { ray: 100.0, node: 80.0, test: 30.0 };

    /// Weighs the counters of some rays: nanoseconds.
    pub fn nanoseconds(&self, rays: u64, counters: &Counters) -> f64 {
        self.ray * rays as f64
            + self.node * counters.nodes_visited as f64
            + self.test * counters.triangle_tests as f64
    }
}
