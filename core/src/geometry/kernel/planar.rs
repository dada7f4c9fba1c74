//! The weights for a direction along a coordinate axis, where each is a minor of two rows of two numbers.
//!
//! If only component `k` of the direction is not 0, a triple product `d . (p x q)` is `d_k (p_i q_j - p_j q_i)`. Rays
//! straight down on grid lines are of this sort: most weights that are exactly 0 without intent come from such rays.
//!
//! # Why the signs are exact
//! 1. A difference `p - q` of two `f32` is used only if `f64` holds it exactly. The test: adding the difference to `q`
//!    gives `p`, and subtracting it from `p` gives `q`. A rounded difference fails, because its error is a multiple of
//!    the last place of the smaller number, and `f64` shows such an error when that number should come back.
//! 2. A product rounds to the nearest, which keeps the order: if two rounded products differ, the exact ones differ the
//!    same way.
//! 3. If the rounded products are the same, the exact ones differ as their errors do, and an error is exact by the
//!    splitting of Dekker and Veltkamp.
//!
//! Differences lie between 2^-149 and 2^129, so nothing over- or underflows.
//!
//! # Source
//! J. R. Shewchuk 1997: TWO-DIFF, SPLIT, TWO-PRODUCT; without fused multiply-add, which is slow where it is emulated.

use glam::Vec3;

use super::pair::{Pair, Weight};
use crate::geometry::Triangle;

/// A corner in the two coordinates across the direction.
type Point = [f64; 2];

/// The corners as seen from the origin, along the direction.
pub(super) struct Planar {
    direction_sign: i32,
    a: Point,
    b: Point,
    c: Point,
}

impl Planar {
    /// Prepares a pair; `None` for a direction along no axis, or where `f64` does not hold a difference.
    #[inline]
    pub fn new(pair: &Pair<'_>) -> Option<Self> {
        let d = pair.ray.direction();
        match d.cmpne(Vec3::ZERO).bitmask() {
            0b001 => Self::seen(pair, d.x, |p| [p.y, p.z]),
            0b010 => Self::seen(pair, d.y, |p| [p.z, p.x]),
            0b100 => Self::seen(pair, d.z, |p| [p.x, p.y]),
            _ => None,
        }
    }

    #[inline]
    fn seen(pair: &Pair<'_>, along: f32, across: impl Fn(Vec3) -> [f32; 2]) -> Option<Self> {
        let [first, second] = across(pair.ray.origin());
        let seen = |corner: Vec3| {
            let [p, q] = across(corner);
            Some([difference(p, first)?, difference(q, second)?])
        };
        let Triangle { a, b, c } = *pair.triangle;
        let direction_sign = if along < 0.0 { -1 } else { 1 };
        Some(Self { direction_sign, a: seen(a)?, b: seen(b)?, c: seen(c)? })
    }

    /// The sign of the weight of a corner.
    #[inline]
    pub fn sign(&self, weight: Weight) -> i32 {
        let Self { direction_sign, a, b, c } = self;
        let minor = match weight {
            Weight::U => minor_sign(c, a),
            Weight::V => minor_sign(a, b),
            Weight::W => minor_sign(b, c),
        };
        direction_sign * minor
    }
}

/// `p - q` where it is exact.
#[inline]
fn difference(p: f32, q: f32) -> Option<f64> {
    let (p, q) = (f64::from(p), f64::from(q));
    let difference = p - q;
    (difference + q == p && p - difference == q).then_some(difference)
}

/// The sign of `p_0 q_1 - p_1 q_0`.
fn minor_sign(p: &Point, q: &Point) -> i32 {
    let (left, right) = (p[0] * q[1], p[1] * q[0]);
    let sign = |less: bool, more: bool| i32::from(more) - i32::from(less);
    if left != right {
        return sign(left < right, left > right);
    }
    let (left, right) = (product_error(p[0], q[1], left), product_error(p[1], q[0], right));
    sign(left < right, left > right)
}

/// `a` as a high half of 26 bits and a low half.
fn split(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0; // 2^27 + 1
    let c = SPLITTER * a;
    let high = c - (c - a);
    (high, a - high)
}

/// The part of `a * b` that rounding to `product` has cut off.
fn product_error(a: f64, b: f64, product: f64) -> f64 {
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_exact_or_refused() {
        let least = f32::from_bits(1);
        assert_eq!(difference(1.0, -1e-8), Some(1.0 + f64::from(1e-8_f32)));
        assert_eq!(difference(0.0, least), Some(-f64::from(least)));
        for (p, q) in [(1.0, least), (least, 1.0), (-3.0e38, 1.0), (1.0, -1.0e-30)] {
            assert_eq!(difference(p, q), None, "{p} - {q}");
        }
    }

    #[test]
    fn a_minor_that_rounding_hides_has_a_sign() {
        // (2^28 + 1)^2 - 2^28 (2^28 + 2) = 1: both products round to 2^56 + 2^29.
        let x = 268_435_456.0; // 2^28
        assert_eq!(minor_sign(&[x + 1.0, x], &[x + 2.0, x + 1.0]), 1);
        assert_eq!(minor_sign(&[x, x + 1.0], &[x + 1.0, x + 2.0]), -1);
        assert_eq!(minor_sign(&[x + 1.0, x + 2.0], &[x + 1.0, x + 2.0]), 0);
    }
}
