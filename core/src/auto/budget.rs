//! How much trying candidates may cost, before it outweighs what a better index saves.
//!
//! ```text
//! steps of a build * nanoseconds a step + clusters   = what a build takes
//! that + rays to come * nanoseconds a ray            = what an index takes in all
//! trying all candidates                             <= a few builds of the best, or a share of its rays
//! ```
//! Steps are counted, not timed, so the choice is the same on every machine.

use crate::{Float64, IndexKind, Scene};

/// What building an index takes, in the unit of [`Weights`](super::Weights).
#[derive(Clone, Copy)]
pub(super) struct BuildCost {
    /// Nanoseconds a step.
    step: f64,
    /// The fewest steps of a build, in `n log2 n` of its `n` triangles, of those seen.
    least_steps: f64,
    /// Nanoseconds a triangle for finding clusters and joining them.
    clusters: f64,
}

/// Nanoseconds a step, and the fewest steps alone and in a hierarchy, by family; in the order in which families are
/// tried: those that are cheap to build and to ask first.
///
/// Measured as the weights were, on the built-in scenes; nanoseconds a step scatter by a factor of two.
const TABLE: [(&str, f64, [f64; 2]); 10] = [
    ("linear", 1.0, [0.0, 0.0]),
    ("wide-octree", 8.0, [0.75, 0.75]),
    ("compact-octree", 10.0, [0.75, 0.75]),
    ("lean-octree", 10.0, [0.75, 0.75]),
    ("bvh", 220.0, [0.8, 0.4]),
    ("kd-tree", 35.0, [5.0, 5.0]),
    ("octree", 100.0, [0.5, 0.5]),
    ("uniform-grid", 130.0, [3.0, 6.0]),
    ("bsp-tree", 70.0, [7.0, 2.5]),
    ("octree-r", 30.0, [6.0, 6.0]),
];
/// For an index that was never measured.
const UNKNOWN: (f64, [f64; 2]) = (100.0, [1.0, 1.0]);

/// Finding clusters and joining them, nanoseconds a triangle.
const CLUSTERS: f64 = 500.0;

/// How many times as long everything takes where `f64` is calculated in software: a Cortex-M4, roughly.
fn slowness(float64: Float64) -> f64 {
    match float64 {
        Float64::Hardware => 1.0,
        Float64::Software => 300.0,
    }
}

impl BuildCost {
    /// What building a kind takes.
    pub fn of(kind: IndexKind, float64: Float64) -> Self {
        let known = TABLE.iter().find(|line| line.0 == kind.family());
        let (step, [alone, clustered]) = known.map_or(UNKNOWN, |line| (line.1, line.2));
        let slowness = slowness(float64);
        let (least_steps, clusters) =
            if kind.is_clustered() { (clustered, CLUSTERS) } else { (alone, 0.0) };
        Self { step: step * slowness, least_steps, clusters: clusters * slowness }
    }

    /// The turn of a kind: lower is earlier, those never measured come last.
    pub fn turn(kind: IndexKind) -> usize {
        let place = TABLE.iter().position(|line| line.0 == kind.family());
        2 * place.unwrap_or(TABLE.len()) + usize::from(kind.is_clustered())
    }

    /// One past the last turn.
    pub const TURNS: usize = 2 * TABLE.len() + 2;

    /// Nanoseconds of a build of `steps` for `triangle_count` triangles.
    pub fn nanoseconds(&self, triangle_count: usize, steps: f64) -> f64 {
        self.step * steps + self.clusters * triangle_count as f64
    }

    /// Nanoseconds that no build for `triangle_count` triangles is below.
    pub fn least_nanoseconds(&self, triangle_count: usize) -> f64 {
        let levels = f64::from((triangle_count.max(1)).ilog2());
        self.nanoseconds(triangle_count, self.least_steps * triangle_count as f64 * levels)
    }

    /// The steps for which `nanoseconds` are enough.
    pub fn steps_within(&self, triangle_count: usize, nanoseconds: f64) -> u64 {
        // The cast saturates, and takes what is below 0 to 0.
        ((nanoseconds - self.clusters * triangle_count as f64) / self.step) as u64
    }
}

/// Trying may cost this many builds of the best candidate ...
const BUILDS: f64 = 3.0;
/// ... or this share of what its rays take: an index that halves their time pays for the search ...
const SHARE_OF_RAYS: f64 = 0.5;
/// ... or what nobody waits for, 4 ms: all candidates for some hundred triangles.
const LEAST: f64 = 4e6;
/// Rays for each triangle where nobody says how many are to come.
const RAYS_A_TRIANGLE: f64 = 16.0;

/// What may be spent on trying.
pub(super) struct Budget {
    /// Rays to come, for the size of the budget.
    rays: f64,
    /// Rays to come, for weighing builds against them: none where nobody says.
    known_rays: Option<f64>,
    /// What may be spent in any case.
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

    /// What an index takes in all: its rays, and its build where it is known how many there are.
    pub fn whole(&self, build: f64, ray: f64) -> f64 {
        match self.known_rays {
            Some(rays) => build + rays * ray,
            None => ray,
        }
    }

    /// Whether a build that takes so long is worth trying, whatever its rays take, beside the best so far.
    pub fn may_win(&self, build: f64, best: f64) -> bool {
        self.whole(build, 0.0) < best
    }

    /// What is left, where the best so far takes so long to build and a ray.
    pub fn left(&self, build: f64, ray: f64) -> f64 {
        let whole = [BUILDS * build, SHARE_OF_RAYS * self.rays * ray, self.least];
        whole.into_iter().fold(0.0, |a, b| if b > a { b } else { a }) - self.spent
    }

    pub fn spend(&mut self, nanoseconds: f64) {
        self.spent += nanoseconds;
    }
}
