//! Lanes: the trait of tests of eight boxes or eight triangles against one ray, in `f32`, and their margins.
//!
//! - [`Portable`](super::Portable) has two vectors of four.
//! - [`Avx2`](super::Avx2) has the same operations in the same order, without FMA, in one vector of eight; for AVX-512
//!   too.
//!
//! Nothing here decides a hit; the margins keep whatever is in doubt.
//!
//! # Which rays
//! `t_min >= 0`, coordinates of the origin and of the scene at most 2^28, and components of the direction 0 or between
//! 2^-40 and 2^40. All other rays are traversed in `f64`. So nothing overflows: a volume is below
//! `6 * 2^29 * 2^29 * 2^40 < 2^101`.
//!
//! # Boxes
//! Let `u = 2^-24`.
//! 1. `(o - plane) * factor` has four roundings: the difference, the inverse of the direction, its scaling, the
//!    product. So it is off by less than `(1 + u)^4`, and by 2^-149 where it underflows.
//! 2. The factors of entries are scaled by `1 - 2^-21` and those of exits by `1 + 2^-21`. So a positive entry is never
//!    late and a positive exit never early.
//! 3. 2^-120 is added to the exit, for the underflows and for hits that round up to 0.
//! 4. A negative entry counts as `t_min`. A negative exit means that the box lies behind.
//! 5. A hit that rounds to `t_min` or to the last `t` lies within half an ulp of it, which the factors cover too.
//! 6. A ray in a plane gives 0 * inf = NaN, which the comparisons ignore.
//!
//! # Triangles
//! They are tested by the `f32` filter of `geometry::kernel`, with the same bounds. A triangle is also rejected if `t`
//! times `det` is surely beyond the last `t` times `det`, or surely before `t_min` times `det`.
//!
//! The error of `det * t` is at most `56 u S E^2`. That of `last * det` is `48 u last D E^2`, and, as `det` is at most
//! `6 D E^2`, `6 u last D E^2` for each of: the product, the sum with the margin, the rounding of the reported `t`. 80
//! covers either, and `ROUNDED` the rounding of the smallest. Beyond the same margins on the other side, a triangle is
//! surely hit.

use core::ops::ControlFlow;

use glam::Vec4;

use crate::geometry::kernel::Verdict;
use crate::geometry::{Ray, Triangle};
use crate::indices::wide::rows::{LeafRows, Node, Row};
use crate::query::Query;

/// Ray prepared for lanes. Vectors have three components and a fourth, which is 0 in the first two vectors, because
/// four are read and written at once.
#[derive(Clone, Copy)]
pub(crate) struct LaneRay {
    pub origin: [f32; 4],
    pub direction: [f32; 4],
    /// The negated inverse of the direction, a little less: it turns the distance from a plane to the origin into the
    /// parameter at which the ray enters.
    pub enter: [f32; 4],
    /// The negated inverse of the direction, a little more: it turns the distance from a plane to the origin into the
    /// parameter at which the ray leaves.
    pub leave: [f32; 4],
    /// Byte order that swaps the sides of a box where the direction is negative: twos there, else zeros.
    ///
    /// A word of the lean BVH has a box's lower side in its lower half. XORed to the order of the word's bytes, this
    /// brings the side by which the ray enters into the lower half.
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    pub swap: [u32; 4],
    /// The largest absolute value of the direction's components.
    pub reach: f32,
    pub t_min: f32,
}

/// Largest absolute value of a coordinate.
const MOST_COORDINATE: f32 = 268_435_456.0; // 2^28
/// Factor that makes an entry early; see "Boxes".
const EARLIER: f32 = 1.0 - 4.768_371_6e-7; // 1 - 2^-21
/// Factor that makes an exit late; see "Boxes".
const LATER: f32 = 1.0 + 4.768_371_6e-7; // 1 + 2^-21
/// Least absolute value of a component of the direction that is not 0.
const LEAST_DIRECTION: f32 = 9.094_947e-13; // 2^-40
/// Largest absolute value of a component of the direction.
const MOST_DIRECTION: f32 = 1.099_511_6e12; // 2^40
/// Slack for underflows.
pub(crate) const UNDERFLOW: f32 = 7.523_164e-37; // 2^-120

/// Half an ulp of 1.
const R: f32 = f32::EPSILON / 2.0;
/// Factor of the margin of `w`, and of `u` and `v` with it; see `geometry::kernel`.
pub(crate) const SUM: f32 = 64.0 * R;
/// Factor of the margins of `t` and `det`; see "Triangles".
pub(crate) const DISTANCE: f32 = 80.0 * R;
/// Absolute slack for `t_min` and the last `t` near zero, where the relative bounds do not hold: another `t` may be
/// rounded to one of them. 2^-150 would be enough, and slow: it is no normal number.
pub(crate) const ROUNDED: f32 = 8.271_806e-25; // 2^-80

/// Ray, prepared with the arithmetic that its traversal takes.
pub(crate) enum PreparedRay {
    /// Lanes of `f32`.
    Lanes(LaneRay),
    /// Single boxes and triangles in `f64`, because the bounds of lanes do not hold.
    F64,
    /// No traversal: the ray hits nothing of the tree.
    Missed,
}

impl PreparedRay {
    /// Prepares a ray for a scene whose largest coordinate is given. `may_hit` is called only for a ray with a
    /// component that is 0.
    #[inline(always)]
    pub fn of(ray: &Ray, largest_coordinate: f32, may_hit: impl FnOnce() -> bool) -> Self {
        const COMPONENTS: u32 = 0b0111;
        let (origin, direction) = (ray.origin().extend(0.0), ray.direction().extend(0.0));
        let sizes = direction.abs();
        let large_enough = sizes.cmpge(Vec4::splat(LEAST_DIRECTION)).bitmask();
        let small_enough = sizes.cmple(Vec4::splat(MOST_DIRECTION))
            & origin.abs().cmple(Vec4::splat(MOST_COORDINATE));
        let tame =
            small_enough.all() && largest_coordinate <= MOST_COORDINATE && ray.t_min() >= 0.0;
        if !tame {
            return Self::F64;
        }
        if large_enough != COMPONENTS {
            let zero = sizes.cmpeq(Vec4::ZERO).bitmask();
            if (large_enough | zero) & COMPONENTS != COMPONENTS {
                return Self::F64;
            }
            if !may_hit() {
                return Self::Missed;
            }
        }
        let inverse = Vec4::NEG_ONE / direction;
        Self::Lanes(LaneRay {
            origin: origin.to_array(),
            direction: direction.to_array(),
            enter: (inverse * EARLIER).to_array(),
            leave: (inverse * LATER).to_array(),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            swap: bytemuck::must_cast(Vec4::select(
                inverse.cmpgt(Vec4::ZERO),
                Vec4::splat(f32::from_bits(0x0202_0202)),
                Vec4::ZERO,
            )),
            reach: sizes.max_element(),
            t_min: ray.t_min(),
        })
    }
}

impl LaneRay {
    /// The ray of a walk that has none.
    pub const IDLE: Self = {
        let zero = [0.0; 4];
        Self {
            origin: zero,
            direction: zero,
            enter: zero,
            leave: zero,
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            swap: [0; 4],
            reach: 0.0,
            t_min: 0.0,
        }
    };

    /// The side of a box by which the ray enters, 0 for the lower or 1 for the upper, and the side by which it leaves.
    #[inline(always)]
    pub fn sides(&self, axis: usize) -> [usize; 2] {
        let near = (self.direction[axis % 4].to_bits() >> 31) as usize;
        [near, 1 - near]
    }

    /// Bounds what underflows can cost `det` minus the other volumes.
    #[inline(always)]
    pub fn underflow(&self) -> f32 {
        4.0 * UNDERFLOW * (self.reach + 1.0)
    }
}

/// The sides of a node's boxes: for each axis the lower, then the upper.
#[inline(always)]
pub(crate) fn sides_of(node: &Node) -> &[[Row; 2]; 4] {
    bytemuck::must_cast_ref(node)
}

/// Result of a test of up to eight triangles, one bit each.
#[derive(Clone, Copy)]
pub(crate) struct Candidates {
    /// The triangles that may be hit.
    pub any: u32,
    /// The triangles that are surely hit; only for [any-hit queries](Query::ANY).
    pub sure: u32,
}

impl Candidates {
    /// Tells the query if a triangle in `lanes` is surely hit. Returns the triangles in `lanes` that it has to judge.
    #[inline(always)]
    pub fn of<Q: Query>(self, lanes: u32, query: &mut Q) -> ControlFlow<(), u32> {
        if self.sure & lanes != 0 {
            query.surely_hit()?;
        }
        ControlFlow::Continue(self.any & lanes)
    }
}

/// SIMD operations on eight boxes, or on eight triangles.
pub(crate) trait Lanes {
    /// Vector of eight keys of 16 bits.
    type Keys: Copy;
    /// Vector of eight `f32`.
    type Numbers: Copy;

    /// Splats a number to all lanes.
    fn all(number: f32) -> Self::Numbers;

    /// Tests eight boxes. For each, the key of a lower bound on the parameter at which the ray enters; `FAR` for a box
    /// that the ray does not meet up to `last`.
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys;

    /// Prefetches the first rows of a node or of a leaf, which the walk needs in its next turn.
    #[inline(always)]
    fn prefetch(_: &[Row], _: u32) {}

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
