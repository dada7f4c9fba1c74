//! Weights that turn a query's counters into nanoseconds. They are measured for each index, so that counters of
//! different indices can be compared.

use crate::query::Counters;

/// Costs of a ray, of a node and of a test in one index. Only their proportions matter.
///
/// Each index states them in [`Described`](crate::custom::Described), for two kinds of processor. The percentage beside
/// each is how far the measured times lie from the estimate. Renew those of all indices together, on one quiet machine.
///
/// # Measured
/// `WEIGHTS`, for processors with `f64` in hardware:
/// - Nanoseconds, as `cargo run --release -p arboleda-host -- compare calibrate` prints them.
/// - Least squares of the relative errors over the built-in scenes in several settings, for a simple index and its
///   hierarchy together.
/// - AMD EPYC, with AVX2, rustc 1.95.
/// - By hand: the linear scan's one node has the weight of a kd-tree's, because over thousands of tests it cannot be
///   measured.
///
/// `SOFTWARE_WEIGHTS`, for processors with `f32` in hardware that calculate `f64` in software:
/// - 10 ns an instruction on a Cortex-M4.
/// - Fitted as `WEIGHTS` to the lines that `thumb_cost` of `tests/targets/bare_metal` prints in an emulator, for 24 to
///   456 triangles.
/// - By hand: all indices have the test of the linear scan, because nearly all triangles are missed in `f32`.
/// - A hit is decided in `f64`, for 95,000 ns in every index; the fit is best with that number. Of 64 rays 44 hit, so
///   65,300 ns of the cost of a ray are its hit. That is all of it in wide BVHs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Cost of each ray.
    pub ray: f64,
    /// Cost of each node visited.
    pub node: f64,
    /// Cost of each triangle tested.
    pub test: f64,
}

impl Weights {
    /// The weights of an index that was never measured. They are so high that it is not preferred for lack of a
    /// measurement.
    pub const UNKNOWN: Self = Self { ray: 100.0, node: 80.0, test: 30.0 };
    /// As [`UNKNOWN`](Self::UNKNOWN), for a processor that calculates `f64` in software.
    pub const UNKNOWN_IN_SOFTWARE: Self = Self { ray: 80_000.0, node: 25_000.0, test: 4_000.0 };

    /// Estimates the nanoseconds that `rays` rays take, from the counters of all of them.
    pub fn nanoseconds(&self, rays: u64, counters: &Counters) -> f64 {
        self.ray * rays as f64
            + self.node * counters.nodes_visited as f64
            + self.test * counters.triangle_tests as f64
    }
}
