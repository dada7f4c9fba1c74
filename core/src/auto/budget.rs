//! How much trying candidates may cost, before it outweighs what a better index saves.
//!
//! ```text
//! steps of a build * nanoseconds a step + clusters   = what a build takes
//! that + rays to come * nanoseconds a ray            = what an index takes in all
//! trying all candidates                             <= a few builds of the best, or a share of its rays
//! ```
//! Steps are counted, not timed, so the choice is the same on every machine.

use crate::{IndexKind, Scene};

/// What building an index takes, in the unit of [`Weights`](super::Weights).
#[derive(Clone, Copy)]
pub(super) struct BuildCost {
    kind: IndexKind,
    /// Nanoseconds a step.
    step: f64,
    /// The fewest steps of a build, in `n log2 n` of its `n` triangles, of those seen.
    least_steps: f64,
}

/// In the order in which candidates are tried: those that are cheap to build and to ask first.
///
/// Measured as the weights were, on the built-in scenes: nanoseconds a step scatter by a factor of two.
const TABLE: &[BuildCost] = &[
    line(IndexKind::Linear, 1.0, 0.0),
    line(IndexKind::WideOctree, 8.0, 0.75),
    line(IndexKind::CompactOctree, 10.0, 0.75),
    line(IndexKind::LeanOctree, 10.0, 0.75),
    line(IndexKind::WideOctreeHierarchy, 8.0, 0.75),
    line(IndexKind::CompactOctreeHierarchy, 10.0, 0.75),
    line(IndexKind::LeanOctreeHierarchy, 10.0, 0.75),
    line(IndexKind::Bvh, 220.0, 0.8),
    line(IndexKind::BvhHierarchy, 220.0, 0.4),
    line(IndexKind::KdTree, 35.0, 5.0),
    line(IndexKind::KdTreeHierarchy, 35.0, 5.0),
    line(IndexKind::OctreeHierarchy, 100.0, 0.5),
    line(IndexKind::Octree, 100.0, 0.5),
    line(IndexKind::GridHierarchy, 130.0, 6.0),
    line(IndexKind::UniformGrid, 130.0, 3.0),
    line(IndexKind::BspTreeHierarchy, 70.0, 2.5),
    line(IndexKind::BspTree, 70.0, 7.0),
    line(IndexKind::OctreeRHierarchy, 30.0, 6.0),
    line(IndexKind::OctreeR, 30.0, 6.0),
];

const fn line(kind: IndexKind, step: f64, least_steps: f64) -> BuildCost {
    BuildCost { kind, step, least_steps }
}

/// Finding clusters and joining them, nanoseconds a triangle.
const CLUSTERS: f64 = 500.0;

impl BuildCost {
    /// What building a kind takes; for one that was never measured, such that it is tried last.
    pub fn of(kind: IndexKind) -> Self {
        let known = TABLE.iter().find(|line| line.kind == kind);
        known.copied().unwrap_or(line(kind, 100.0, 1.0))
    }

    /// The turn of a kind: lower is earlier.
    pub fn turn(kind: IndexKind) -> usize {
        TABLE.iter().position(|line| line.kind == kind).unwrap_or(TABLE.len())
    }

    /// Nanoseconds of a build of `steps` for `triangle_count` triangles.
    pub fn nanoseconds(&self, triangle_count: usize, steps: f64) -> f64 {
        self.step * steps + self.clusters(triangle_count)
    }

    /// Nanoseconds that no build for `triangle_count` triangles is below.
    pub fn least_nanoseconds(&self, triangle_count: usize) -> f64 {
        let levels = f64::from((triangle_count.max(1)).ilog2());
        self.nanoseconds(triangle_count, self.least_steps * triangle_count as f64 * levels)
    }

    /// The steps for which `nanoseconds` are enough.
    pub fn steps_within(&self, triangle_count: usize, nanoseconds: f64) -> u64 {
        // The cast saturates, and takes what is below 0 to 0.
        ((nanoseconds - self.clusters(triangle_count)) / self.step) as u64
    }

    fn clusters(&self, triangle_count: usize) -> f64 {
        if self.kind.is_clustered() { CLUSTERS * triangle_count as f64 } else { 0.0 }
    }
}

/// Trying may cost this many builds of the best candidate ...
const BUILDS: f64 = 3.0;
/// ... or this share of what its rays take: an index that halves their time pays for the search ...
const SHARE_OF_RAYS: f64 = 0.5;
/// ... or what nobody waits for: 4 ms. All candidates for some hundred triangles.
const LEAST: f64 = 4e6;
/// Rays for each triangle where nobody says how many are to come.
const RAYS_A_TRIANGLE: f64 = 16.0;

/// What may be spent on trying.
pub(super) struct Budget {
    /// Rays to come, for the size of the budget.
    rays: f64,
    /// Rays to come, for weighing builds against them: none where nobody says.
    known_rays: Option<f64>,
    spent: f64,
}

impl Budget {
    pub fn new(scene: &Scene<'_>) -> Self {
        let count = scene.triangles().len() as f64;
        let known_rays = scene.expected_rays.map(|rays| rays as f64);
        Self { rays: known_rays.unwrap_or(RAYS_A_TRIANGLE * count), known_rays, spent: 0.0 }
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
        let whole = [BUILDS * build, SHARE_OF_RAYS * self.rays * ray, LEAST];
        whole.into_iter().fold(0.0, |a, b| if b > a { b } else { a }) - self.spent
    }

    pub fn spend(&mut self, nanoseconds: f64) {
        self.spent += nanoseconds;
    }
}
