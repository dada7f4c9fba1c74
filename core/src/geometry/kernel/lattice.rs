//! The volumes of the kernel in whole numbers, for coordinates that lie on one lattice.
//!
//! Every `f32` is a whole number times a power of two. Where the exponents of several `f32` do not differ much,
//! all of them are whole numbers times one power of two, and so are their differences and products. The sign of a
//! volume is then that of a whole number. Nothing is rounded, so nothing needs an error bound.
//!
//! # Which coordinates
//! The coordinates of the points get one power of two, the components of the direction another. Each power makes the
//! largest number a whole number of at most 40 bits: 24 of them are its mantissa, so the lowest bit of the other
//! numbers may lie 16 places below the last place of the largest. Coordinates on grid lines, multiples of a step, rays
//! at corners, and most points of one scene fulfil that; a coordinate that is nearly 0 but not 0 does not.
//!
//! # Why nothing overflows
//! Differences are below 2^41 and a minor of two of them below 2 * 2^82. A triple product has three minors times
//! a component below 2^41: below 6 * 2^123 < 2^126, and `i128` holds 2^127.
//!
//! # Measured
//! - Expansions for the same signs, and for ties: a ray through a vertex of a height field took 60,000 instructions
//!   instead of 4,000 (callgrind, wide BVH), because each sum of terms is a loop of branches; and 6 KB of stack.

use super::pair::{Volume, Weight};
use crate::geometry::{Ray, Triangle};

/// Three coordinates or components.
type Vector = [i64; 3];

/// A ray and a triangle in whole numbers: the direction, and the corners as seen from the origin.
pub(super) struct Lattice {
    direction: Vector,
    a: Vector,
    b: Vector,
    c: Vector,
    /// The components are multiples of two to this power.
    direction_exponent: i32,
    /// The coordinates are multiples of two to this power.
    point_exponent: i32,
}

impl Lattice {
    /// Brings a pair on one lattice; `None` where that would take too many bits.
    pub fn new(ray: &Ray, triangle: &Triangle) -> Option<Self> {
        let [ox, oy, oz] = ray.origin().to_array();
        let ([ax, ay, az], [bx, by, bz]) = (triangle.a.to_array(), triangle.b.to_array());
        let [cx, cy, cz] = triangle.c.to_array();
        let (points, point_exponent) = whole([ox, oy, oz, ax, ay, az, bx, by, bz, cx, cy, cz])?;
        let (direction, direction_exponent) = whole(ray.direction().to_array())?;
        let [ox, oy, oz, ax, ay, az, bx, by, bz, cx, cy, cz] = points;
        let seen = |x: i64, y: i64, z: i64| [x - ox, y - oy, z - oz];
        Some(Self {
            direction,
            a: seen(ax, ay, az),
            b: seen(bx, by, bz),
            c: seen(cx, cy, cz),
            direction_exponent,
            point_exponent,
        })
    }

    /// The sign of a volume: -1, 0 or 1.
    pub fn sign(&self, volume: Volume) -> i32 {
        let Self { direction, a, b, c, .. } = self;
        let value = match volume {
            Volume::T => triple(a, b, c),
            Volume::Of(Weight::U) => triple(direction, c, a),
            Volume::Of(Weight::V) => triple(direction, a, b),
            Volume::Of(Weight::W) => triple(direction, b, c),
        };
        value.signum() as i32
    }

    /// The sign of `det t - m det = (a - m d) . (e1 x e2)`, for `m` half-way between two `f32`; `None` where the point
    /// at `m` takes too many bits.
    ///
    /// The components, without the zero bits that they share at the end, are multiplied by the 25 bits of `m`. The
    /// products and `a` are shifted to the finer of their two lattices. If neither takes more than 60 bits there,
    /// `a - m d` is exact and below 2^61; if it is also below 2^41, as differences of corners are, the triple product
    /// fits.
    pub fn side_of_t(&self, m: f64) -> Option<i32> {
        const MOST_BITS: i32 = 60;
        let Self { direction, a, b, c, .. } = self;
        let (mantissa, exponent) = factored(m);
        let zeros = direction.iter().fold(0, |bits, d| bits | d).trailing_zeros();
        let step_bits = (FACTOR_BITS + BITS).saturating_sub(zeros).cast_signed();
        let up = self.direction_exponent + zeros.cast_signed() + exponent - self.point_exponent;
        let (step_up, point_up) = (up.max(0), (-up).max(0));
        if step_bits + step_up > MOST_BITS || BITS.cast_signed() + 1 + point_up > MOST_BITS {
            return None;
        }
        let minus = |p: &Vector, q: &Vector| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let step = direction.map(|d| (mantissa * (d >> zeros)) << step_up);
        let point = minus(&a.map(|a| a << point_up), &step);
        let fits = point.iter().all(|p| p.unsigned_abs() >> (BITS + 1) == 0);
        fits.then(|| triple(&point, &minus(b, a), &minus(c, a)).signum() as i32)
    }
}

/// The bits of a whole number, without its sign.
const BITS: u32 = 40;
/// The bits of the mantissa of an `f32`, of which the highest is not stored.
const MANTISSA_BITS: u32 = f32::MANTISSA_DIGITS;

/// Divides numbers by the power of two that leaves the largest with at most [`BITS`], and returns the whole numbers and
/// the exponent of that power; `None` if a number loses a bit.
fn whole<const N: usize>(values: [f32; N]) -> Option<([i64; N], i32)> {
    // The bits of numbers without a sign are in the order of the numbers.
    let largest = values.iter().fold(0, |largest, value| largest.max(value.abs().to_bits()));
    let top = (largest >> (MANTISSA_BITS - 1)).max(1);
    let mut lost = 0;
    let whole = values.map(|value| {
        let (mantissa, exponent) = decoded(value);
        let shift = (top - exponent).min(u64::BITS - 1);
        let shifted = u64::from(mantissa) << (BITS - MANTISSA_BITS);
        let whole = shifted >> shift;
        lost |= shifted ^ whole << shift;
        let whole = whole.cast_signed();
        if value < 0.0 { -whole } else { whole }
    });
    (lost == 0).then_some((whole, top.cast_signed() - 150 - (BITS - MANTISSA_BITS).cast_signed()))
}

/// The bits of a number half-way between two `f32`.
const FACTOR_BITS: u32 = 25;

/// A number half-way between two `f32`, or one of them, as a whole number below 2^25 and the exponent of the power of
/// two that it is multiplied by.
pub(super) fn factored(value: f64) -> (i64, i32) {
    let bits = value.abs().to_bits();
    if bits == 0 {
        return (0, 0);
    }
    let mantissa = bits & ((1 << 52) - 1) | 1 << 52;
    let zeros = mantissa.trailing_zeros();
    debug_assert!(53 - zeros <= FACTOR_BITS, "not half-way between two f32: {value}");
    let whole = (mantissa >> zeros).cast_signed();
    let exponent = (bits >> 52) as i32 + zeros.cast_signed() - 1075;
    (if value < 0.0 { -whole } else { whole }, exponent)
}

/// The mantissa and the biased exponent, at least 1, of a finite number: without its sign, it is the mantissa times
/// 2^(exponent - 150).
pub(super) fn decoded(value: f32) -> (u32, u32) {
    let bits = value.abs().to_bits();
    let (exponent, fraction) =
        (bits >> (MANTISSA_BITS - 1), bits & ((1 << (MANTISSA_BITS - 1)) - 1));
    // The highest bit is there unless the exponent says that there is none.
    let highest = exponent.min(1) << (MANTISSA_BITS - 1);
    (fraction | highest, exponent.max(1))
}

/// `p . (q x r)`
fn triple(p: &Vector, q: &Vector, r: &Vector) -> i128 {
    let product = |x: i64, y: i64| i128::from(x) * i128::from(y);
    let minor = |i: usize, j: usize| product(q[i], r[j]) - product(q[j], r[i]);
    i128::from(p[0]) * minor(1, 2) + i128::from(p[1]) * minor(2, 0) + i128::from(p[2]) * minor(0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;

    #[test]
    fn whole_numbers_keep_every_bit_or_are_refused() {
        let far = 65_536.0 * f32::from_bits(1); // 16 places above the last
        assert_eq!(whole([1.0, -0.5, 0.0]), Some(([1 << 39, -(1 << 38), 0], -39)));
        assert_eq!(whole([1.0, 1.0 + f32::EPSILON]), Some(([1 << 39, (1 << 39) + (1 << 16)], -39)));
        assert_eq!(whole([1.0, 9.094_947e-13]), None); // 2^-40
        assert_eq!(whole([1.0, 1.818_989_4e-12]), Some(([1 << 39, 1], -39))); // 2^-39
        assert_eq!(whole([far, f32::from_bits(1)]), Some(([1 << 32, 1 << 16], -165)));
        assert_eq!(whole([f32::MAX, -f32::MAX]).map(|([a, b], _)| a + b), Some(0));
        assert_eq!(whole([f32::MAX, f32::from_bits(1)]), None);
    }

    #[test]
    fn the_side_of_a_tie_is_that_of_the_exact_quotient() {
        // t is 2^24 + 1, half-way between two f32.
        let ray = Ray::new(Vec3::new(0.0, 0.0, -1.0), Vec3::Z).expect("a valid ray");
        let height = 16_777_216.0;
        let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, height + z);
        let side = |z: f32, m: f64| {
            let triangle =
                Triangle::new(corner(-1.0, -1.0, z), corner(1.0, -1.0, z), corner(0.0, 2.0, z));
            Lattice::new(&ray, &triangle).and_then(|lattice| lattice.side_of_t(m))
        };
        let m = f64::from(height) + 1.0;
        assert_eq!([side(0.0, m), side(2.0, m), side(-1.0, m)], [Some(0), Some(1), Some(-1)]);
    }

    /// Rays on grid lines: a step that is no power of two, any heights, an origin far above.
    #[test]
    fn corners_of_a_height_field_are_on_a_lattice() {
        let line = |i: u16| f32::from(i) * 0.1;
        for i in 0..1_000 {
            let corner = |i: u16, k: u16| Vec3::new(line(i), (line(i) * 7.3).sin(), line(k));
            let triangle = Triangle::new(corner(i, i), corner(i + 1, i), corner(i + 1, i + 1));
            let origin = Vec3::new(line(i), 50.0, line(i));
            let ray = Ray::new(origin, Vec3::NEG_Y).expect("a valid ray");
            let lattice = Lattice::new(&ray, &triangle).expect("close together");
            let weights = [Weight::U, Weight::V, Weight::W].map(Volume::Of);
            let [u, v, w] = weights.map(|weight| lattice.sign(weight));
            assert!(u == 0 && v == 0 && w != 0);
        }
    }

    /// The largest volume there can be: coordinates of 40 bits with opposite signs.
    #[test]
    fn the_largest_volume_does_not_overflow() {
        let most = f32::MAX;
        let ray = Ray::new(Vec3::splat(-most), Vec3::new(most, -most, most)).expect("a valid ray");
        let triangle = Triangle::new(
            Vec3::new(most, most, -most),
            Vec3::new(-most, most, most),
            Vec3::new(most, -most, most),
        );
        let lattice = Lattice::new(&ray, &triangle).expect("one exponent");
        let weights = [Weight::U, Weight::V, Weight::W].map(Volume::Of);
        assert_eq!(weights.map(|weight| lattice.sign(weight)), [-1, 1, -1]);
        assert_eq!(lattice.sign(Volume::T), 1);
    }
}
