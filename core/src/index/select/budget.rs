//! Budget for trying candidates: trying must not cost more than what a better index saves.
//!
//! ```text
//! steps of a build * nanoseconds a step + clusters   = cost of the build
//! cost of the build + rays to come * cost of a ray   = whole cost of an index
//! cost of trying all candidates                     <= three builds of the best, half the cost of its rays, or 4 ms
//! ```
//! Steps are counted, not timed, so the choice is the same on every machine.

use crate::index::IndexKind;
use crate::input::{Float64, Scene};

/// Cost of building an index, in the unit of [`Weights`](crate::custom::Weights).
#[derive(Clone, Copy)]
pub(super) struct BuildCost {
    /// Nanoseconds a step.
    step: f64,
    /// The least number of steps of any build measured, in units of `n log2 n` for `n` triangles.
    least_steps: f64,
    /// Nanoseconds a triangle for finding clusters and joining them; 0 for a kind without clusters.
    clusters: f64,
}

/// Costs of builds by family: nanoseconds a step, and the least steps of the simple index and of its hierarchy.
///
/// Families are tried in the order of the lines: those that are cheap to build and to query come first.
///
/// # Measured
/// - As [`Weights`](crate::custom::Weights), on the built-in scenes. Nanoseconds a step scatter by a factor of two.
const TABLE: [(&str, f64, [f64; 2]); 10] = [
    ("linear", 1.0, [0.0, 0.0]),
    ("wide-bvh", 8.0, [0.75, 0.75]),
    ("compact-bvh", 10.0, [0.75, 0.75]),
    ("lean-bvh", 10.0, [0.75, 0.75]),
    ("bvh", 220.0, [0.8, 0.4]),
    ("kd-tree", 35.0, [5.0, 5.0]),
    ("octree", 40.0, [1.5, 0.4]),
    ("uniform-grid", 130.0, [3.0, 6.0]),
    ("bsp-tree", 40.0, [4.5, 1.2]),
    ("octree-r", 30.0, [4.5, 3.0]),
];
/// Costs assumed of a family that was never measured.
const UNKNOWN: (f64, [f64; 2]) = (100.0, [1.0, 1.0]);

/// Nanoseconds a triangle for finding clusters and joining them: 30 in a mesh, 70 on figure 4(b), 210 in a city, 340 in a
/// district.
const CLUSTERS: f64 = 300.0;

/// The factor by which builds take longer on a processor that calculates `f64` in software: roughly that of a
/// Cortex-M4.
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

    /// The turn in which a kind is tried. Lower turns come first, and kinds never measured come last.
    pub fn turn(kind: IndexKind) -> usize {
        let line = TABLE.iter().position(|line| line.0 == kind.family());
        2 * line.unwrap_or(TABLE.len()) + usize::from(kind.is_clustered())
    }

    /// Number of turns.
    pub const TURNS: usize = 2 * TABLE.len() + 2;

    /// The nanoseconds of a build of `steps` steps for `triangle_count` triangles.
    pub fn nanoseconds(&self, triangle_count: usize, steps: f64) -> f64 {
        self.step * steps + self.clusters * triangle_count as f64
    }

    /// A lower bound on the nanoseconds of a build for `triangle_count` triangles.
    pub fn least_nanoseconds(&self, triangle_count: usize) -> f64 {
        let levels = f64::from((triangle_count.max(1)).ilog2());
        self.nanoseconds(triangle_count, self.least_steps * triangle_count as f64 * levels)
    }

    /// The number of steps of a build for which `nanoseconds` are enough.
    pub fn steps_within(&self, triangle_count: usize, nanoseconds: f64) -> u64 {
        // The cast saturates: a negative quotient becomes 0.
        ((nanoseconds - self.clusters * triangle_count as f64) / self.step) as u64
    }
}

/// Multiple of the best candidate's build that trying may cost.
const BUILDS: f64 = 3.0;
/// Share of the time of the best candidate's rays that trying may cost: an index that halves this time pays for the
/// search.
const SHARE_OF_RAYS: f64 = 0.5;
/// Nanoseconds that trying may cost in any case: 4 ms, enough for all candidates on some hundred triangles.
const LEAST: f64 = 4e6;
/// Rays assumed for each triangle without [`Scene::expecting`].
const RAYS_A_TRIANGLE: f64 = 16.0;

/// Budget of nanoseconds for trying candidates: the largest of [`BUILDS`], [`SHARE_OF_RAYS`] and [`LEAST`].
pub(super) struct Budget {
    /// The number of rays to come, known or assumed, for the size of the budget.
    rays: f64,
    /// The number of rays to come if known, for weighing builds against rays.
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

    /// The whole cost of an index: the build and all rays if their number is known, else a single ray.
    pub fn whole(&self, build: f64, ray: f64) -> f64 {
        match self.known_rays {
            Some(rays) => build + rays * ray,
            None => ray,
        }
    }

    /// Tells whether an index whose build takes `build` could have a lower whole cost than `best`, even if its rays
    /// took no time.
    pub fn may_win(&self, build: f64, best: f64) -> bool {
        self.whole(build, 0.0) < best
    }

    /// The nanoseconds that are left, if the best index so far takes `build` to build and `ray` for a ray.
    pub fn left(&self, build: f64, ray: f64) -> f64 {
        let whole = [BUILDS * build, SHARE_OF_RAYS * self.rays * ray, self.least];
        whole.into_iter().fold(0.0, |a, b| if b > a { b } else { a }) - self.spent
    }

    pub fn spend(&mut self, nanoseconds: f64) {
        self.spent += nanoseconds;
    }
}
