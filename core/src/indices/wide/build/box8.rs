//! Axis-aligned boxes of which one minimum makes the union, for builds.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use crate::geometry::Box4;
use crate::simd::HAS_VECTORS;

/// Axis-aligned box as eight numbers: the lower corner and a number for any use, the negated upper corner and another.
///
/// The union is a minimum of numbers, one by one. Compilers make one instruction of it where registers hold eight
/// numbers, and two where they hold four.
///
/// No lower corner is -0.0 and no negated upper corner is 0.0, which [`Box4::of_triangle`] sees to. So the minimum does not
/// depend on the order, and is that of [`Box4`].
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Box8([f32; 8]);

impl Box8 {
    pub const EMPTY: Self = Self([f32::INFINITY; 8]);

    /// The box, and its numbers for any use.
    pub fn new(bounds: Box4, [first, second]: [f32; 2]) -> Self {
        let corners = [bounds.lo.with_w(first), (-bounds.hi).with_w(second)];
        bytemuck::must_cast(corners)
    }

    /// The same box with another number behind the lower corner.
    pub const fn with_number(self, number: f32) -> Self {
        let [a, b, c, _, d, e, f, last] = self.0;
        Self([a, b, c, number, d, e, f, last])
    }

    /// The box. Its fourth components are the number behind the lower corner, and the negated number behind the upper.
    #[inline(always)]
    pub fn box4(&self) -> Box4 {
        let [lo, negated_hi]: [Vec4; 2] = bytemuck::must_cast(*self);
        Box4 { lo, hi: -negated_hi }
    }

    /// The numbers for any use.
    #[inline(always)]
    pub fn numbers(&self) -> [f32; 2] {
        let [_, _, _, first, .., second] = self.0;
        [first, second]
    }

    /// The union of the boxes. The numbers for any use stay if they are at most those of `other`; else what they become
    /// depends on the target.
    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        let lesser = |all: f32, number: f32| if number < all { number } else { all };
        let [a, b, c, mut first, d, e, f, mut second] = self.0;
        let [g, h, i, other_first, j, k, l, other_second] = other.0;
        if HAS_VECTORS {
            // So that there are eight minima, of which compilers make one instruction or two.
            first = lesser(first, other_first);
            second = lesser(second, other_second);
        }
        let lo = [lesser(a, g), lesser(b, h), lesser(c, i)];
        let hi = [lesser(d, j), lesser(e, k), lesser(f, l)];
        Self([lo[0], lo[1], lo[2], first, hi[0], hi[1], hi[2], second])
    }

    /// The lower corner plus the upper corner.
    #[inline(always)]
    pub fn doubled_centroid(&self) -> Vec4 {
        let [lo, negated_hi]: [Vec4; 2] = bytemuck::must_cast(*self);
        lo - negated_hi
    }

    /// The lengths of the sides, negated.
    #[inline(always)]
    pub fn negated_size(&self) -> Vec4 {
        let [lo, negated_hi]: [Vec4; 2] = bytemuck::must_cast(*self);
        lo + negated_hi
    }

    /// Adds `numbers`, of which all but the fourth are -0.0 and change nothing. In vectors, eight additions are one.
    #[inline(always)]
    pub fn plus(mut self, numbers: &[f32; 8]) -> Self {
        if HAS_VECTORS {
            for (all, number) in self.0.iter_mut().zip(numbers) {
                *all += number;
            }
        } else {
            self.0[3] += numbers[3];
        }
        self
    }
}
