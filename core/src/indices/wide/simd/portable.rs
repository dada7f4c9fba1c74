//! Lanes of every target: two vectors of four. They are SSE2, NEON or simd128 where the crate is compiled for them, and
//! four numbers elsewhere.

use core::ops::{Add, Mul, Neg, Sub};

use glam::Vec4;

use super::lanes::{Candidates, DISTANCE, FAR, LaneRay, Lanes, ROUNDED, SUM, UNDERFLOW, sides_of};
use crate::indices::wide::rows::{LANES, LeafRows, Node, Row};
use crate::query::Query;

/// Lanes for every target.
pub(crate) enum Portable {}

/// Vector of eight `f32`.
#[derive(Clone, Copy)]
pub(crate) struct Eight([Vec4; 2]);

impl Eight {
    #[inline(always)]
    pub fn all(x: f32) -> Self {
        Self([Vec4::splat(x); 2])
    }

    /// The numbers whose bits are those of a row.
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

    /// Compares: one bit for each lane in which `self` is less.
    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        let ([a, b], [c, d]) = (self.0, other.0);
        a.cmplt(c).bitmask() | b.cmplt(d).bitmask() << 4
    }

    /// Compares: one bit for each lane in which `self` is greater.
    #[inline(always)]
    fn above(self, other: Self) -> u32 {
        other.below(self)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        self.each(Vec4::abs)
    }

    /// The larger number of each lane; of a NaN and a number, the second operand.
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        self.with(other, |a, b| {
            // Of a NaN and a number, the SSE2 instruction gives the second operand; those of other targets give a NaN.
            if cfg!(target_feature = "sse2") { a.max(b) } else { Vec4::select(a.cmpgt(b), a, b) }
        })
    }

    /// The smaller number of each lane; of a NaN and a number, the second operand.
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

type EightPoints = [Eight; 3];

#[inline(always)]
fn minus(a: EightPoints, b: EightPoints) -> EightPoints {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: EightPoints, b: EightPoints) -> Eight {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: EightPoints, b: EightPoints) -> EightPoints {
    let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// Tests eight boxes, as [`Lanes::meet_boxes`] does. For each axis, `planes` gives the sides by which the ray enters,
/// and the sides by which it leaves.
#[inline(always)]
pub(crate) fn meet_planes(
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
        // Key and lane in one number: the least is the first lane of the least key.
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
    fn edges(leaf: &LeafRows) -> Eight {
        let length = |at: usize| (Eight::of(&leaf[at]) - Eight::of(&leaf[at % 3])).abs();
        (4..9).fold(length(3), |longest, at| longest.larger(length(at)))
    }

    #[inline(always)]
    fn meet_triangles<Q: Query>(
        leaf: &LeafRows,
        ray: &LaneRay,
        edges: Eight,
        last: f32,
    ) -> Candidates {
        let all = Eight::all;
        let corner = |row: usize| [0, 1, 2].map(|axis| Eight::of(&leaf[row + axis]));

        // 1. Volumes: n = e1 x e2, q = d x a; det u = d . (e2 x a) = -e2 . q, det v = d . (a x e1) = e1 . q.
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

        // 2. Weights of opposite signs, beyond the margin.
        let a = a[0].abs().larger(a[1].abs().larger(a[2].abs()));
        let underflow = all(ray.underflow());
        let sum = all(SUM * ray.reach) * edges;
        let margin = sum * (edges + (a + a)) + underflow;
        let (lowest, highest) = (u.smaller(v).smaller(w), u.larger(v).larger(w));
        let mixed = lowest.below(-margin) & highest.above(margin);

        // 3. The quotient t / det against the interval, without a division: both sides times |det|.
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
        // The sign of `along` is that of t only if the sign of det is certain.
        let certain = size.above(wider + underflow);
        // 4. For an any-hit query: beyond the same margins on the other side, a triangle is surely hit.
        let mut sure = 0;
        if Q::ANY {
            let alike = lowest.above(margin) | highest.below(-margin);
            let before_last = most.below(all(last) * smallest);
            let behind_first = least.above(all(ray.t_min) * largest);
            sure = alike & certain & before_last & behind_first;
        }
        Candidates { any: !(mixed | certain & (late | early)), sure }
    }
}

/// The bit of the sign.
const SIGN: u32 = 1 << 31;
