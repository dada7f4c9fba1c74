//! Eight boxes, or eight triangles, against one ray, in `f32`.
//!
//! In two vectors of four, which are SSE2, NEON or simd128 where the crate is compiled for them, and four
//! numbers elsewhere; `avx2` has the same operations in the same order in one of eight, for AVX-512 too. Nothing
//! here decides a hit; margins keep whatever is in doubt.
//!
//! # Which rays
//! `t_min >= 0`, coordinates of the origin and of the scene at most 2^28, and components of the direction
//! 0 or between 2^-40 and 2^40; others take the `f64` way. So nothing overflows: a volume is below
//! `6 * 2^29 * 2^29 * 2^40 < 2^101`.
//!
//! # Boxes
//! With `u = 2^-24`: `(o - plane) * factor` has four roundings: the difference, the inverse of the direction,
//! its scaling, the product; so it is off by less than `(1 + u)^4`, and by 2^-149 where it underflows. The
//! factors of entries are scaled by `1 - 2^-21` and those of exits by `1 + 2^-21`, so a positive entry is never
//! late and a positive exit never early; 2^-120 is added to the exit for the underflows and for hits that round
//! up to 0. A negative entry counts as `t_min`, a negative exit means that the box lies behind. A hit that
//! rounds to `t_min` or to the last `t` lies within half an ulp of it, which the factors cover too. A ray
//! in a plane gives 0 * inf = NaN, which the comparisons ignore.
//!
//! # Triangles
//! The `f32` filter of `geometry::kernel`, with the same bounds; and, where `t` times `det` is surely
//! beyond the last `t` times `det`, or surely before `t_min`, that too. The error of `det * t` is at
//! most `56 u S E^2`; that of `last * det` is `48 u last D E^2`, and as `det` is at most `6 D E^2`, `6 u
//! last D E^2` for each of: the product, the sum with the margin, the rounding of the reported `t`. 80
//! covers either, and `ROUNDED` the rounding of the smallest. Beyond the same margins on the other side, a triangle
//! is surely hit.

use core::ops::{Add, ControlFlow, Mul, Neg, Sub};

use glam::Vec4;

use super::walk::decide_each;
use super::{LANES, Leaf, Node, Row};
use crate::geometry::kernel::Verdict;
use crate::geometry::{Ray, Triangle};
use crate::query::{Query, TriangleId};

/// A ray prepared for lanes. Three components and a fourth, which is 0 in the first two, because four are read
/// and written at once.
#[derive(Clone, Copy)]
pub(in crate::indices) struct LaneRay {
    pub origin: [f32; 4],
    pub direction: [f32; 4],
    /// The inverse of the direction with the sign changed, and a little less or more: what turns the
    /// distance from a plane to the origin into where the ray enters and leaves.
    pub enter: [f32; 4],
    pub leave: [f32; 4],
    /// Where the direction is negative, twos, else zeros: as the order of the bytes of a word, which has the lower
    /// side of a box in its lower half, what brings there the side by which the ray enters.
    #[cfg(target_arch = "x86_64")]
    pub swap: [u32; 4],
    /// The largest component of the direction.
    pub reach: f32,
    pub t_min: f32,
}

const MOST_COORDINATE: f32 = 268_435_456.0; // 2^28
/// How much later or earlier than computed a plane may be crossed, relatively.
const EARLIER: f32 = 1.0 - 4.768_371_6e-7; // 1 - 2^-21
const LATER: f32 = 1.0 + 4.768_371_6e-7; // 1 + 2^-21
const LEAST_DIRECTION: f32 = 9.094_947e-13; // 2^-40
const MOST_DIRECTION: f32 = 1.099_511_6e12; // 2^40
pub(super) const UNDERFLOW: f32 = 7.523_164e-37; // 2^-120

/// Half an ulp of 1.
const R: f32 = f32::EPSILON / 2.0;
pub(super) const SUM: f32 = 64.0 * R;
pub(super) const DISTANCE: f32 = 80.0 * R;
/// How far before `t_min` or behind the last `t` another may lie and be rounded to it, where they are so small that
/// the relative bounds do not cover that. 2^-150 would be enough, and slow: it is no normal number.
pub(super) const ROUNDED: f32 = 8.271_806e-25; // 2^-80

impl LaneRay {
    /// No ray yet.
    pub const IDLE: Self = {
        let zero = [0.0; 4];
        Self {
            origin: zero,
            direction: zero,
            enter: zero,
            leave: zero,
            #[cfg(target_arch = "x86_64")]
            swap: [0; 4],
            reach: 0.0,
            t_min: 0.0,
        }
    };

    /// `None` for a ray that has to take the `f64` way, in a scene whose largest coordinate is given.
    #[inline(always)]
    pub fn new(ray: &Ray, largest_coordinate: f32) -> Option<Self> {
        let (origin, direction) = (ray.origin().extend(0.0), ray.direction().extend(0.0));
        let sizes = direction.abs();
        let large_enough = sizes.cmpge(Vec4::splat(LEAST_DIRECTION)) | sizes.cmpeq(Vec4::ZERO);
        let small_enough = sizes.cmple(Vec4::splat(MOST_DIRECTION))
            & origin.abs().cmple(Vec4::splat(MOST_COORDINATE));
        let tame = (large_enough & small_enough).all()
            && largest_coordinate <= MOST_COORDINATE
            && ray.t_min() >= 0.0;
        if !tame {
            return None;
        }
        let inverse = Vec4::NEG_ONE / direction;
        Some(Self {
            origin: origin.to_array(),
            direction: direction.to_array(),
            enter: (inverse * EARLIER).to_array(),
            leave: (inverse * LATER).to_array(),
            #[cfg(target_arch = "x86_64")]
            swap: bytemuck::must_cast(Vec4::select(
                inverse.cmpgt(Vec4::ZERO),
                Vec4::splat(f32::from_bits(0x0202_0202)),
                Vec4::ZERO,
            )),
            reach: sizes.max_element(),
            t_min: ray.t_min(),
        })
    }

    /// Which side of a box the ray enters it by, 0 for the lower, 1 for the upper, and which it leaves it by.
    #[inline(always)]
    pub fn sides(&self, axis: usize) -> [usize; 2] {
        let near = (self.direction[axis % 4].to_bits() >> 31) as usize;
        [near, 1 - near]
    }

    /// The most that underflows can cost `det` less the other volumes.
    #[inline(always)]
    pub fn underflow(&self) -> f32 {
        4.0 * UNDERFLOW * (self.reach + 1.0)
    }
}

/// Of a node's boxes, by axis, the lower sides and the upper.
#[inline(always)]
pub(super) fn sides_of(node: &Node) -> &[[Row; 2]; 4] {
    bytemuck::must_cast_ref(node)
}

/// What is known of up to eight triangles, one bit each.
#[derive(Clone, Copy)]
pub(in crate::indices) struct Candidates {
    /// Those that may be hit.
    pub any: u32,
    /// Those of them that surely are, for a query to which [any](Query::ANY) is enough.
    pub sure: u32,
}

impl Candidates {
    /// Nothing is known.
    pub const ALL: Self = Self { any: u32::MAX, sure: 0 };

    /// Tells a query of what is sure of the first lanes, and returns which of them are to be decided about.
    #[inline(always)]
    pub fn of<Q: Query>(self, count: usize, query: &mut Q) -> ControlFlow<(), u32> {
        let used = (1 << count) - 1;
        if Q::ANY && self.sure & used != 0 {
            query.surely_hit()?;
        }
        ControlFlow::Continue(self.any & used)
    }
}

/// Eight boxes, or eight triangles, at once.
pub(in crate::indices) trait Lanes {
    /// Eight numbers of 16 bits.
    type Keys: Copy;
    /// Eight numbers.
    type Numbers: Copy;

    /// The same number in all lanes.
    fn all(number: f32) -> Self::Numbers;

    /// For each box, where the ray enters it, at the earliest, as a key; `FAR` for one that the ray does not
    /// meet up to `last`.
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys;

    /// Asks the memory for the first rows of a node or of a leaf, of which a walk has need in its next turn.
    #[inline(always)]
    fn prefetch(_: &[Row], _: u32) {}

    /// The lowest key, and the first lane that has it.
    fn nearest(keys: Self::Keys) -> (u16, usize);

    /// Whether there is a key other than `FAR`.
    fn any(keys: Self::Keys) -> bool;

    /// The keys with `FAR` in one lane.
    fn without(keys: Self::Keys, lane: usize) -> Self::Keys;

    /// The largest component of each triangle's edges at corner a.
    fn edges(leaf: &Leaf) -> Self::Numbers;

    /// The triangles that the ray may hit at `t_min..=last`; of unused lanes, anything. No edge at corner a is
    /// longer along an axis than `edges` has it.
    fn meet_triangles<Q: Query>(
        leaf: &Leaf,
        ray: &LaneRay,
        edges: Self::Numbers,
        last: f32,
    ) -> Candidates;

    /// What can be said of one triangle before the kernel is asked.
    #[inline(always)]
    fn judge(_: &Triangle, _: &LaneRay, _: f32) -> Verdict {
        Verdict::InDoubt
    }

    /// As [`decide_each`].
    #[inline(always)]
    fn decide_each<Q: Query>(
        candidates: u32,
        query: &mut Q,
        triangle: impl Fn(usize) -> (TriangleId, Triangle),
        judge: impl Fn(&Triangle, f32) -> Verdict,
    ) -> ControlFlow<()> {
        decide_each(candidates, query, triangle, judge)
    }
}

/// The key of a box that is not met, behind all others.
pub(in crate::indices) const FAR: u16 = u16::MAX;

/// A distance, at least 0, as a number of 16 bits: rounded down, and in the same order.
#[inline(always)]
pub(in crate::indices) fn key(distance: f32) -> u16 {
    (distance.to_bits() >> 16) as u16
}

/// Lanes for every target.
pub(in crate::indices) enum Portable {}

/// Eight numbers.
#[derive(Clone, Copy)]
pub(in crate::indices) struct Eight([Vec4; 2]);

impl Eight {
    #[inline(always)]
    pub fn all(x: f32) -> Self {
        Self([Vec4::splat(x); 2])
    }

    /// The numbers with these bits.
    #[inline(always)]
    pub fn of(row: &Row) -> Self {
        Self(bytemuck::must_cast(*row))
    }

    #[inline(always)]
    fn each(self, f: impl Fn(Vec4) -> Vec4) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(Vec4, Vec4) -> Vec4) -> Self {
        let ([a, b], [c, d]) = (self.0, other.0);
        Self([f(a, c), f(b, d)])
    }

    /// Where this is the smaller one, one bit each.
    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        let ([a, b], [c, d]) = (self.0, other.0);
        a.cmplt(c).bitmask() | b.cmplt(d).bitmask() << 4
    }

    /// Where this is the larger one, one bit each.
    #[inline(always)]
    fn above(self, other: Self) -> u32 {
        other.below(self)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        self.each(Vec4::abs)
    }

    /// The larger one; of a NaN and a number, the second.
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        self.with(other, |a, b| {
            // There, of a NaN and a number, the instruction gives the second; elsewhere, a NaN.
            if cfg!(target_feature = "sse2") { a.max(b) } else { Vec4::select(a.cmpgt(b), a, b) }
        })
    }

    /// The smaller one; of a NaN and a number, the second.
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.with(other, |a, b| {
            if cfg!(target_feature = "sse2") { a.min(b) } else { Vec4::select(a.cmplt(b), a, b) }
        })
    }
}

impl Add for Eight {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, Vec4::add)
    }
}

impl Sub for Eight {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, Vec4::sub)
    }
}

impl Mul for Eight {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, Vec4::mul)
    }
}

impl Neg for Eight {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(Vec4::neg)
    }
}

type Points = [Eight; 3];

#[inline(always)]
fn minus(a: Points, b: Points) -> Points {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: Points, b: Points) -> Eight {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: Points, b: Points) -> Points {
    let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// As [`Lanes::meet_boxes`], where `planes` gives the sides across an axis: those by which the ray enters, and
/// the others.
#[inline(always)]
pub(in crate::indices) fn meet_planes(
    ray: &LaneRay,
    last: f32,
    planes: impl Fn(usize) -> [Eight; 2],
) -> [u16; LANES] {
    let mut entry = Eight::all(ray.t_min);
    let mut exit = Eight::all(last);
    for axis in 0..3 {
        let origin = Eight::all(ray.origin[axis]);
        let [near, far] = planes(axis);
        entry = ((origin - near) * Eight::all(ray.enter[axis])).larger(entry);
        exit = ((origin - far) * Eight::all(ray.leave[axis])).smaller(exit);
    }
    let exit = exit + Eight::all(UNDERFLOW);
    let missed = entry.above(exit);
    let bits: [u32; LANES] = bytemuck::must_cast(entry.0);
    let key = |lane: usize| if missed >> lane & 1 == 0 { (bits[lane] >> 16) as u16 } else { FAR };
    core::array::from_fn(key)
}

impl Lanes for Portable {
    type Keys = [u16; LANES];
    type Numbers = Eight;

    #[inline(always)]
    fn all(number: f32) -> Eight {
        Eight::all(number)
    }

    #[inline(always)]
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys {
        meet_planes(ray, last, |axis| {
            ray.sides(axis).map(|side| Eight::of(&sides_of(node)[axis][side]))
        })
    }

    #[inline(always)]
    fn nearest(keys: Self::Keys) -> (u16, usize) {
        // Key and lane in one number: the least is the first of the nearest.
        let of = |lane: usize| u32::from(keys[lane]) << 3 | lane as u32;
        let least = (0..LANES).map(of).fold(u32::MAX, u32::min);
        ((least >> 3) as u16, (least & 7) as usize)
    }

    #[inline(always)]
    fn any(keys: Self::Keys) -> bool {
        keys != [FAR; LANES]
    }

    #[inline(always)]
    fn without(mut keys: Self::Keys, lane: usize) -> Self::Keys {
        keys[lane % LANES] = FAR;
        keys
    }

    #[inline(always)]
    fn edges(leaf: &Leaf) -> Eight {
        let length = |at: usize| (Eight::of(&leaf[at]) - Eight::of(&leaf[at % 3])).abs();
        (4..9).fold(length(3), |longest, at| longest.larger(length(at)))
    }

    #[inline(always)]
    fn meet_triangles<Q: Query>(leaf: &Leaf, ray: &LaneRay, edges: Eight, last: f32) -> Candidates {
        let all = Eight::all;
        let corner = |row: usize| [0, 1, 2].map(|axis| Eight::of(&leaf[row + axis]));

        // n = e1 x e2, q = d x a: det u = d . (e2 x a) = -e2 . q, det v = d . (a x e1) = e1 . q.
        let p = corner(0);
        let d = [0, 1, 2].map(|axis| all(ray.direction[axis]));
        let a = minus(p, [0, 1, 2].map(|axis| all(ray.origin[axis])));
        let e1 = minus(corner(3), p);
        let e2 = minus(corner(6), p);
        let n = cross(e1, e2);
        let q = cross(d, a);
        let det = dot(d, n);
        let t = dot(a, n);
        let u = -dot(e2, q);
        let v = dot(e1, q);
        let w = det - u - v;

        let a = a[0].abs().larger(a[1].abs().larger(a[2].abs()));
        let underflow = all(ray.underflow());
        let sum = all(SUM * ray.reach) * edges;
        let margin = sum * (edges + (a + a)) + underflow;
        let (lowest, highest) = (u.smaller(v).smaller(w), u.larger(v).larger(w));
        let mixed = lowest.below(-margin) & highest.above(margin);
        let alike = lowest.above(margin) | highest.below(-margin);

        // The quotient t / det against the interval, without dividing: both times |det|.
        let size = det.abs();
        let sign_of = |t: Vec4, det: Vec4| {
            let (t, det): ([u32; 4], [u32; 4]) = (bytemuck::must_cast(t), bytemuck::must_cast(det));
            bytemuck::must_cast(core::array::from_fn::<u32, 4, _>(|lane| {
                t[lane] ^ det[lane] & SIGN
            }))
        };
        let along = t.with(det, sign_of);
        let doubt = all(DISTANCE) * edges * edges;
        let wider = doubt * all(ray.reach);
        let slack = doubt * a + underflow;
        let (most, least) = (along + slack, along - slack);
        let (largest, smallest) = (size + wider, size - wider);
        let late = least.above(all(last + ROUNDED) * largest);
        let early = most.below(all(ray.t_min - ROUNDED) * smallest);
        // Only where the sign of det is certain is `along` what it says.
        let certain = size.above(wider + underflow);
        let before_last = most.below(all(last) * smallest);
        let behind_first = least.above(all(ray.t_min) * largest);
        Candidates {
            any: !(mixed | certain & (late | early)),
            sure: alike & certain & before_last & behind_first,
        }
    }
}

/// The bit of the sign.
const SIGN: u32 = 1 << 31;
