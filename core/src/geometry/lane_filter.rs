//! The `f32` filter of several triangles at once, one in each lane.
//!
//! # Bounds
//! Triangles are tested by the `f32` filter of `kernel`, with the same bounds. A triangle is also rejected if `t`
//! times `det` is surely beyond the last `t` times `det`, or surely before `t_min` times `det`.
//!
//! The error of `det * t` is at most `56 u S E^2`, where `u = 2^-24`. That of `last * det` is `48 u last D E^2`, and, as
//! `det` is at most `6 D E^2`, `6 u last D E^2` for each of: the product, the sum with the margin, the rounding of the
//! reported `t`. 80 covers either, and `ROUNDED` the rounding of the smallest. Beyond the same margins on the other
//! side, a triangle is surely hit.

// Forced, because the traversal of the wide BVH is compiled for the instructions of its lanes, with all that it calls.
#![allow(clippy::inline_always)]

use core::ops::{Add, Mul, Neg, Sub};

use glam::Vec4;

use super::lane_ray::LaneRay;

/// Half an ulp of 1.
const R: f32 = f32::EPSILON / 2.0;
/// Factor of the margin of `w`, and of `u` and `v` with it; see `kernel`.
pub(crate) const SUM: f32 = 64.0 * R;
/// Factor of the margins of `t` and `det`; see "Bounds".
pub(crate) const DISTANCE: f32 = 80.0 * R;
/// Absolute slack for `t_min` and the last `t` near zero, where the relative bounds do not hold: another `t` may be
/// rounded to one of them. 2^-150 would be enough, and slow: it is no normal number.
pub(crate) const ROUNDED: f32 = 8.271_806e-25; // 2^-80

/// Vector of `f32`, one for each lane.
pub(crate) trait Numbers:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// Splats a number to all lanes.
    fn all(number: f32) -> Self;
    /// The absolute values.
    fn abs(self) -> Self;
    /// The larger number of each lane; of a NaN and a number, the second operand.
    fn larger(self, other: Self) -> Self;
    /// The smaller number of each lane; of a NaN and a number, the second operand.
    fn smaller(self, other: Self) -> Self;
    /// Compares: one bit for each lane in which `self` is less.
    fn below(self, other: Self) -> u32;
    /// The numbers, negated where `other` is negative.
    fn negated_by(self, other: Self) -> Self;
    /// Compares: one bit for each lane in which `self` is greater.
    #[inline(always)]
    fn above(self, other: Self) -> u32 {
        other.below(self)
    }
}

/// The bit of the sign.
const SIGN: u32 = 1 << 31;

impl Numbers for Vec4 {
    #[inline(always)]
    fn all(number: f32) -> Self {
        Self::splat(number)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // Of a NaN and a number, the SSE2 instruction gives the second operand; those of other targets give a NaN.
        if cfg!(target_feature = "sse2") {
            self.max(other)
        } else {
            Self::select(self.cmpgt(other), self, other)
        }
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        if cfg!(target_feature = "sse2") {
            self.min(other)
        } else {
            Self::select(self.cmplt(other), self, other)
        }
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        self.cmplt(other).bitmask()
    }

    #[inline(always)]
    fn negated_by(self, other: Self) -> Self {
        let (bits, other): ([u32; 4], [u32; 4]) =
            (bytemuck::must_cast(self), bytemuck::must_cast(other));
        bytemuck::must_cast(core::array::from_fn::<u32, 4, _>(|lane| {
            bits[lane] ^ other[lane] & SIGN
        }))
    }
}

/// Points, one for each lane.
pub(crate) type Points<N> = [N; 3];

#[inline(always)]
fn minus<N: Numbers>(a: Points<N>, b: Points<N>) -> Points<N> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<N: Numbers>(a: Points<N>, b: Points<N>) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<N: Numbers>(a: Points<N>, b: Points<N>) -> Points<N> {
    let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// Result of a test of several triangles, one bit each.
#[derive(Clone, Copy)]
pub(crate) struct Candidates {
    /// The triangles that may be hit.
    pub any: u32,
    /// The triangles that are surely hit; only if asked for.
    pub sure: u32,
}

// For the wavefront, which other targets have not.
#[cfg_attr(not(all(target_arch = "x86_64", target_feature = "sse2")), allow(dead_code))]
impl Candidates {
    /// The same result, restricted to the triangles in `lanes`.
    #[inline(always)]
    pub fn within(self, lanes: u32) -> Self {
        Self { any: self.any & lanes, sure: self.sure & lanes }
    }
}

/// The largest component of each triangle's edges at corner a.
#[inline(always)]
pub(crate) fn longest_edges<N: Numbers>([a, b, c]: [Points<N>; 3]) -> N {
    let (e1, e2) = (minus(b, a).map(N::abs), minus(c, a).map(N::abs));
    let largest = |e: Points<N>| e[0].larger(e[1]).larger(e[2]);
    largest(e1).larger(largest(e2))
}

/// Tests triangles, given by their corners a, b and c, for hits in `t_min..=last`. No component of an edge at corner a
/// is larger than `edges`. `ask_sure` asks for those that are surely hit. Bits of the masks beyond the lanes are
/// arbitrary.
#[inline(always)]
pub(crate) fn meet_triangles<N: Numbers>(
    [p, b, c]: [Points<N>; 3],
    ray: &LaneRay,
    edges: N,
    last: f32,
    ask_sure: bool,
) -> Candidates {
    let all = N::all;
    // 1. Volumes: n = e1 x e2, q = d x a; det u = d . (e2 x a) = -e2 . q, det v = d . (a x e1) = e1 . q.
    let d = [0, 1, 2].map(|axis| all(ray.direction[axis]));
    let a = minus(p, [0, 1, 2].map(|axis| all(ray.origin[axis])));
    let e1 = minus(b, p);
    let e2 = minus(c, p);
    let n = cross(e1, e2);
    let q = cross(d, a);
    let det = dot(d, n);
    let t = dot(a, n);
    let u = -dot(e2, q);
    let v = dot(e1, q);
    let w = det - u - v;

    // 2. Weights of opposite signs, beyond the margin.
    let a = a[0].abs().larger(a[1].abs().larger(a[2].abs()));
    let underflow = all(ray.underflow());
    let sum = all(SUM * ray.reach) * edges;
    let margin = sum * (edges + (a + a)) + underflow;
    let (lowest, highest) = (u.smaller(v).smaller(w), u.larger(v).larger(w));
    let mixed = lowest.below(-margin) & highest.above(margin);

    // 3. The quotient t / det against the interval, without a division: both sides times |det|.
    let size = det.abs();
    let along = t.negated_by(det);
    let doubt = all(DISTANCE) * edges * edges;
    let wider = doubt * all(ray.reach);
    let slack = doubt * a + underflow;
    let (most, least) = (along + slack, along - slack);
    let (largest, smallest) = (size + wider, size - wider);
    let late = least.above(all(last + ROUNDED) * largest);
    let early = most.below(all(ray.t_min - ROUNDED) * smallest);
    // The sign of `along` is that of t only if the sign of det is certain.
    let certain = size.above(wider + underflow);
    // 4. For an any-hit query: beyond the same margins on the other side, a triangle is surely hit.
    let mut sure = 0;
    if ask_sure {
        let alike = lowest.above(margin) | highest.below(-margin);
        let before_last = most.below(all(last) * smallest);
        let behind_first = least.above(all(ray.t_min) * largest);
        sure = alike & certain & before_last & behind_first;
    }
    Candidates { any: !(mixed | certain & (late | early)), sure }
}
