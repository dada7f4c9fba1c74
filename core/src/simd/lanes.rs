//! Lanes: the trait of tests of eight boxes or eight triangles against one ray, in `f32`.
//!
//! - [`Portable`](super::Portable) has two vectors of four.
//! - [`Avx2`](super::Avx2) has the same operations in the same order, without FMA, in one vector of eight; for AVX-512
//!   too.
//!
//! Nothing here decides a hit. The margins are those of `geometry`: of planes in `lane_ray`, of triangles in
//! `lane_filter`.

// Forced, because what a traversal calls must be compiled for the instructions of its lanes, in one function with it.
#![allow(clippy::inline_always)]

use crate::geometry::kernel::Verdict;
use crate::geometry::{Candidates, LaneRay, Ray, Triangle};
use crate::query::Query;

/// Width of SIMD: boxes of a node, or triangles that are tested at once.
pub(crate) const LANES: usize = 8;

/// Row of a node or of a leaf: a word for each lane.
pub(crate) type Row = [u32; LANES];

/// Node: eight boxes, each axis' lower sides and upper sides, and two rows for what they hold.
pub(crate) type Node = [Row; NODE_ROWS as usize];

/// Eight triangles: the coordinates of their corners a, b and c, and a row for their ids.
pub(crate) type LeafRows = [Row; LEAF_ROWS as usize];

pub(crate) const NODE_ROWS: u32 = 8;
pub(crate) const LEAF_ROWS: u32 = 10;

/// Arithmetic that the traversal of a ray takes.
pub(crate) enum Arithmetic {
    /// Lanes of `f32`, for which the ray is prepared.
    Lanes,
    /// Single boxes and triangles in `f64`, because the bounds of lanes do not hold.
    F64,
    /// No traversal: the ray hits nothing of the tree.
    Missed,
}

impl Arithmetic {
    /// Chooses the arithmetic of a ray in a scene whose largest coordinate is given, and prepares the ray for lanes.
    /// `may_hit` is called only for a ray with a component that is 0.
    #[inline(always)]
    pub fn of(
        ray: &Ray,
        largest_coordinate: f32,
        may_hit: impl FnOnce() -> bool,
        prepared: &mut LaneRay,
    ) -> Self {
        match LaneRay::of(ray, largest_coordinate) {
            None => Self::F64,
            Some((_, true)) if !may_hit() => Self::Missed,
            Some((lanes, _)) => {
                *prepared = lanes;
                Self::Lanes
            }
        }
    }
}

/// The sides of a node's boxes: for each axis the lower, then the upper.
#[inline(always)]
pub(crate) fn sides_of(node: &Node) -> &[[Row; 2]; 4] {
    bytemuck::must_cast_ref(node)
}

/// SIMD operations on eight boxes, or on eight triangles.
pub(crate) trait Lanes {
    /// Vector of eight keys of 16 bits.
    type Keys: Copy;
    /// Vector of eight `f32`.
    type Numbers: Copy;

    /// Chooses the arithmetic of a ray, and prepares the ray; see [`Arithmetic::of`].
    #[inline(always)]
    fn prepare(
        ray: &Ray,
        largest_coordinate: f32,
        may_hit: impl FnOnce() -> bool,
        prepared: &mut LaneRay,
    ) -> Arithmetic {
        Arithmetic::of(ray, largest_coordinate, may_hit, prepared)
    }

    /// Splats a number to all lanes.
    fn all(number: f32) -> Self::Numbers;

    /// Tests eight boxes. For each, the key of a lower bound on the parameter at which the ray enters; `FAR` for a box
    /// that the ray does not meet up to `last`.
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys;

    /// Prefetches `lines` cache lines of 64 bytes from an item on, which a walk needs in its next turn.
    #[inline(always)]
    fn prefetch<T>(_: &[T], _first: usize, _lines: usize) {}

    /// The lowest key, and the first lane that has it.
    fn nearest(keys: Self::Keys) -> (u16, usize);

    /// Tells whether there is a key other than `FAR`.
    fn any(keys: Self::Keys) -> bool;

    /// Replaces the key in one lane by `FAR`.
    fn without(keys: Self::Keys, lane: usize) -> Self::Keys;

    /// The largest component of each triangle's edges at corner a.
    fn edges(leaf: &LeafRows) -> Self::Numbers;

    /// Tests eight triangles for hits in `t_min..=last`. The bits of unused lanes are arbitrary. No component of an
    /// edge at corner a is larger than `edges`.
    fn meet_triangles<Q: Query>(
        leaf: &LeafRows,
        ray: &LaneRay,
        edges: Self::Numbers,
        last: f32,
    ) -> Candidates;

    /// Filters one triangle before the kernel decides.
    #[inline(always)]
    fn judge(&Triangle { a, b, c }: &Triangle, _: &LaneRay, _: f32) -> Verdict {
        // Three equal corners: all `f32` volumes are 0, so only a comparison rejects such a triangle.
        if a == b && b == c { Verdict::Missed } else { Verdict::InDoubt }
    }
}

/// Key of a box that is not met, behind all others.
pub(crate) const FAR: u16 = u16::MAX;

/// Makes a key of a distance, at least 0: its upper 16 bits, rounded down and in the same order.
#[inline(always)]
pub(crate) fn key(distance: f32) -> u16 {
    (distance.to_bits() >> 16) as u16
}
