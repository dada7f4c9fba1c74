//! Budget for trying candidates: trying must not outweigh what a better index saves.
//!
//! ```text
//! steps of a build * nanoseconds a step + clusters   = what a build takes
//! that + rays to come * nanoseconds a ray            = what an index takes in all
//! trying all candidates                             <= a few builds of the best, or a share of its rays
//! ```
//! Steps are counted, not timed, so the choice is the same on every machine.

use crate::index::IndexKind;
use crate::input::{Float64, Scene};

/// Cost of building an index, in the unit of [`Weights`](super::Weights).
#[derive(Clone, Copy)]
pub(super) struct BuildCost {
    /// Nanoseconds a step.
    step: f64,
    /// The fewest steps of any build measured, in units of `n log2 n` for `n` triangles.
    least_steps: f64,
    /// Nanoseconds a triangle for finding clusters and joining them.
    clusters: f64,
}

/// Nanoseconds a step, and the fewest steps alone and in a hierarchy, by family. Families are tried in the order of the
/// lines: first those that are cheap to build and to query.
///
/// Measured as the weights were, on the built-in scenes; nanoseconds a step scatter by a factor of two.
const TABLE: [(&str, f64, [f64; 2]); 10] = [
    ("linear", 1.0, [0.0, 0.0]),
    ("wide-bvh", 8.0, [0.75, 0.75]),
    ("compact-bvh", 10.0, [0.75, 0.75]),
    ("lean-bvh", 10.0, [0.75, 0.75]),
    ("bvh", 220.0, [0.8, 0.4]),
    ("kd-tree", 35.0, [5.0, 5.0]),
    ("octree", 100.0, [0.5, 0.5]),
    ("uniform-grid", 130.0, [3.0, 6.0]),
    ("bsp-tree", 70.0, [7.0, 2.5]),
    ("octree-r", 30.0, [6.0, 6.0]),
];
/// Assumed of an index that was never measured.
const UNKNOWN: (f64, [f64; 2]) = (100.0, [1.0, 1.0]);

/// Finding clusters and joining them, nanoseconds a triangle.
const CLUSTERS: f64 = 500.0;

/// Factor by which everything takes longer where `f64` is calculated in software: roughly that of a Cortex-M4.
fn slowness(float64: Float64) -> f64 {
    match float64 {
        Float64::Hardware => 1.0,
        Float64::Software => 300.0,
    }
}

impl BuildCost {
    /// The cost of building a kind.
    pub fn of(kind: IndexKind, float64: Float64) -> Self {
        let known = TABLE.iter().find(|line| line.0 == kind.family());
        let (step, [alone, clustered]) = known.map_or(UNKNOWN, |line| (line.1, line.2));
        let slowness = slowness(float64);
        let (least_steps, clusters) =
            if kind.is_clustered() { (clustered, CLUSTERS) } else { (alone, 0.0) };
        Self { step: step * slowness, least_steps, clusters: clusters * slowness }
    }

    /// The turn in which a kind is tried: lower is earlier, and kinds never measured come last.
    pub fn turn(kind: IndexKind) -> usize {
        let line = TABLE.iter().position(|line| line.0 == kind.family());
        2 * line.unwrap_or(TABLE.len()) + usize::from(kind.is_clustered())
    }

    /// One past the last turn.
    pub const TURNS: usize = 2 * TABLE.len() + 2;

    /// Nanoseconds of a build of `steps` for `triangle_count` triangles.
    pub fn nanoseconds(&self, triangle_count: usize, steps: f64) -> f64 {
        self.step * steps + self.clusters * triangle_count as f64
    }

    /// A lower bound on the nanoseconds of a build for `triangle_count` triangles.
    pub fn least_nanoseconds(&self, triangle_count: usize) -> f64 {
        let levels = f64::from((triangle_count.max(1)).ilog2());
        self.nanoseconds(triangle_count, self.least_steps * triangle_count as f64 * levels)
    }

    /// The steps of a build for which `nanoseconds` are enough.
    pub fn steps_within(&self, triangle_count: usize, nanoseconds: f64) -> u64 {
        // The cast saturates: a negative quotient becomes 0.
        ((nanoseconds - self.clusters * triangle_count as f64) / self.step) as u64
    }
}

/// Trying may cost this many builds of the best candidate ...
const BUILDS: f64 = 3.0;
/// ... or this share of the time of its rays: an index that halves their time pays for the search ...
const SHARE_OF_RAYS: f64 = 0.5;
/// ... or 4 ms, which nobody notices: enough for all candidates on some hundred triangles.
const LEAST: f64 = 4e6;
/// Rays assumed for each triangle without [`Scene::expecting`].
const RAYS_A_TRIANGLE: f64 = 16.0;

/// Nanoseconds that may be spent on trying.
pub(super) struct Budget {
    /// Rays to come, known or assumed, for the size of the budget.
    rays: f64,
    /// Rays to come if that is known, for weighing builds against rays.
    known_rays: Option<f64>,
    /// Nanoseconds that may be spent in any case.
    least: f64,
    spent: f64,
}

impl Budget {
    pub fn new(scene: &Scene<'_>, float64: Float64) -> Self {
        let count = scene.triangles().len() as f64;
        let known_rays = scene.expected_rays.map(|rays| rays as f64);
        let rays = known_rays.unwrap_or(RAYS_A_TRIANGLE * count);
        Self { rays, known_rays, least: LEAST * slowness(float64), spent: 0.0 }
    }

    /// The whole cost of an index: a ray, or, where the number of rays is known, the build and all rays.
    pub fn whole(&self, build: f64, ray: f64) -> f64 {
        match self.known_rays {
            Some(rays) => build + rays * ray,
            None => ray,
        }
    }

    /// Tells whether an index whose build takes `build` could have a lower whole cost than `best`, if its rays took
    /// no time.
    pub fn may_win(&self, build: f64, best: f64) -> bool {
        self.whole(build, 0.0) < best
    }

    /// The nanoseconds left, where the best index so far takes `build` to build and `ray` for a ray.
    pub fn left(&self, build: f64, ray: f64) -> f64 {
        let whole = [BUILDS * build, SHARE_OF_RAYS * self.rays * ray, self.least];
        whole.into_iter().fold(0.0, |a, b| if b > a { b } else { a }) - self.spent
    }

    pub fn spend(&mut self, nanoseconds: f64) {
        self.spent += nanoseconds;
    }
}
