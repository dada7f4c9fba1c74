//! Exact arithmetic on the volumes of the kernel, which decides where `f64` cannot.
//!
//! Seen from the origin of the ray, with `a = A - o`, `b = B - o`, `c = C - o`, the volumes have one form:
//!
//! ```text
//! det t = a . (b x c)    det u = d . (c x a)    det v = d . (a x b)    det w = d . (b x c)
//! ```
//!
//! They are those of the kernel, because `e1 = b - a`, `e2 = c - a` and `a x a = 0`; and `det`, the sum of the last
//! three, does not depend on the origin.
//!
//! 1. For a direction along an axis, the signs of weights are decided in two coordinates ([`Planar`]).
//! 2. Where coordinates allow that, signs are decided in whole numbers ([`Lattice`]).
//! 3. Otherwise signs, and quotients that lie between two `f32`, are decided by [`LongSum`]: the differences are
//!    multiplied out, a product that has the origin twice is 0, and triple products of `f32` as they were given are
//!    left.

use super::lattice::Lattice;
use super::long_sum::{Factor, LongSum};
use super::pair::{Pair, Volume, Weight};
use super::planar::Planar;
use crate::geometry::Triangle;

impl Pair<'_> {
    /// Chooses the arithmetic that decides the signs of weights.
    pub fn signs(self) -> Signs {
        let Self { ray, triangle } = self;
        if let Some(planar) = Planar::new(&self) {
            return Signs::Planar(planar);
        }
        Lattice::new(ray, triangle).map_or(Signs::Long(Long::new(self)), Signs::Lattice)
    }

    /// Rounds the exact quotient of a volume and `det` to the nearest `f32`, ties to even, never -0.0. The result lies
    /// in `low..=high`; bounds that are NaN say nothing.
    #[cold]
    #[inline(never)]
    pub fn round(self, volume: Volume, det_sign: i32, low: f32, high: f32) -> f32 {
        let may_be_zero = !(low > 0.0 || high < 0.0);
        if may_be_zero && volume == Volume::T && self.begins_on_flat() {
            return 0.0;
        }
        let lattice = Lattice::new(self.ray, self.triangle);
        if may_be_zero && lattice.as_ref().is_some_and(|lattice| lattice.sign(volume) == 0) {
            return 0.0;
        }
        let long = Long::new(self);
        if high != low.next_up() {
            return long.round(volume, det_sign);
        }
        let boundary = (f64::from(low) + f64::from(high)) * 0.5;
        let side = lattice.filter(|_| volume == Volume::T);
        let side = side.and_then(|lattice| lattice.side_of_t(boundary));
        let side = side.unwrap_or_else(|| long.minus(volume, Some(boundary)).sign());
        nearest(side * det_sign, low, boundary, high)
    }
}

/// The nearest of two neighbours to a number on the given side of the boundary half-way between them.
fn nearest(side: i32, low: f32, boundary: f64, high: f32) -> f32 {
    let nearest = match side {
        0 => boundary as f32, // the conversion rounds ties to even
        1.. => high,
        _ => low,
    };
    nearest + 0.0
}

/// Arithmetic that decides the signs of weights.
pub(super) enum Signs {
    /// Two coordinates.
    Planar(Planar),
    /// Whole numbers.
    Lattice(Lattice),
    /// Long sums.
    Long(Long),
}

impl Signs {
    /// The sign of a weight: -1, 0 or 1.
    #[inline(never)]
    pub fn of(&self, weight: Weight) -> i32 {
        match self {
            Self::Planar(planar) => planar.sign(weight),
            Self::Lattice(lattice) => lattice.sign(Volume::Of(weight)),
            Self::Long(long) => long.minus(Volume::Of(weight), None).sign(),
        }
    }
}

/// A ray and a triangle, for long sums.
pub(super) struct Long {
    direction: [f32; 3],
    origin: [f32; 3],
    a: [f32; 3],
    b: [f32; 3],
    c: [f32; 3],
}

/// Number half-way from the largest `f32` to what would be the next, 2^128. From here on, rounding overflows.
const BEYOND_MAX: f64 = 340_282_356_779_733_661_637_539_395_458_142_568_448.0; // 2^128 - 2^103

impl Long {
    fn new(Pair { ray, triangle: &Triangle { a, b, c } }: Pair<'_>) -> Self {
        let [direction, origin] = [ray.direction(), ray.origin()].map(|v| v.to_array());
        Self { direction, origin, a: a.to_array(), b: b.to_array(), c: c.to_array() }
    }

    /// A volume less `m` times `det`; `m` is half-way between two `f32`.
    #[inline(never)]
    fn minus(&self, volume: Volume, m: Option<f64>) -> LongSum {
        let Self { direction: d, origin: o, a, b, c } = self;
        let mut sum = LongSum::ZERO;
        // p . ((q - o) x (r - o))
        let mut seen = |p, q, r| {
            sum.add_triple(Factor::ONE, p, q, r);
            sum.add_triple(-Factor::ONE, p, q, o);
            sum.add_triple(-Factor::ONE, p, o, r);
        };
        match volume {
            Volume::Of(Weight::U) => seen(d, c, a),
            Volume::Of(Weight::V) => seen(d, a, b),
            Volume::Of(Weight::W) => seen(d, b, c),
            Volume::T => {
                seen(a, b, c);
                sum.add_triple(-Factor::ONE, o, b, c);
            }
        }
        if let Some(m) = m {
            self.add_det(-Factor::of(m), &mut sum);
        }
        sum
    }

    fn add_det(&self, factor: Factor, sum: &mut LongSum) {
        let Self { direction: d, a, b, c, .. } = self;
        for [p, q] in [[a, b], [b, c], [c, a]] {
            sum.add_triple(factor, d, p, q);
        }
    }

    /// Rounds the exact quotient of a volume and `det`; see [`Pair::round`].
    fn round(&self, volume: Volume, det_sign: i32) -> f32 {
        // The exact volumes, rounded: each is off by less than 2^-51 of itself, the quotient by less
        // than 2^-49. At most one boundary between two f32 values lies in such an interval.
        let q = self.quotient(volume);
        let error = q.abs() * (8.0 * f64::EPSILON);
        let (low, high) = ((q - error) as f32, (q + error) as f32);
        if low == high {
            return low + 0.0;
        }
        // On which side of that boundary is the exact quotient?
        let boundary = match (low.is_finite(), high.is_finite()) {
            (true, true) => (f64::from(low) + f64::from(high)) * 0.5,
            (true, false) => BEYOND_MAX,
            _ => -BEYOND_MAX,
        };
        nearest(self.minus(volume, Some(boundary)).sign() * det_sign, low, boundary, high)
    }

    fn quotient(&self, volume: Volume) -> f64 {
        let numerator = self.minus(volume, None).estimate();
        let mut det = LongSum::ZERO;
        self.add_det(Factor::ONE, &mut det);
        numerator / det.estimate()
    }
}
