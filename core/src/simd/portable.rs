//! Lanes of every target: two vectors of four. They are SSE2, NEON or simd128 where the crate is compiled for them, and
//! four numbers elsewhere.

// Forced, because what a traversal calls must be compiled for the instructions of its lanes, in one function with it.
#![allow(clippy::inline_always)]

use core::ops::{Add, Mul, Neg, Sub};

use glam::Vec4;

use super::lanes::{FAR, LANES, Lanes, LeafRows, Node, Row, sides_of};
use crate::geometry::{
    Candidates, LaneRay, Numbers, Points, UNDERFLOW, longest_edges, meet_triangles,
};
use crate::query::Query;

/// Lanes for every target.
pub(crate) enum Portable {}

/// Vector of eight `f32`.
#[derive(Clone, Copy)]
pub(crate) struct Eight([Vec4; 2]);

impl Eight {
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
}

impl Numbers for Eight {
    #[inline(always)]
    fn all(number: f32) -> Self {
        Self([Vec4::splat(number); 2])
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.each(Vec4::abs)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.with(other, Numbers::larger)
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.with(other, Numbers::smaller)
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        let ([a, b], [c, d]) = (self.0, other.0);
        a.below(c) | b.below(d) << 4
    }

    #[inline(always)]
    fn negated_by(self, other: Self) -> Self {
        self.with(other, Numbers::negated_by)
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

/// The corners of the triangles of a leaf.
#[inline(always)]
fn corners(leaf: &LeafRows) -> [Points<Eight>; 3] {
    let corner = |row: usize| [0, 1, 2].map(|axis| Eight::of(&leaf[row + axis]));
    [corner(0), corner(3), corner(6)]
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
        longest_edges(corners(leaf))
    }

    #[inline(always)]
    fn meet_triangles<Q: Query>(
        leaf: &LeafRows,
        ray: &LaneRay,
        edges: Eight,
        last: f32,
    ) -> Candidates {
        meet_triangles(corners(leaf), ray, edges, last, Q::ANY)
    }
}
