//! The volumes in `f64`, each with a bound on its error, and their quotients. `kernel` derives the bounds.

use super::pair::{Pair, Volume};
use crate::geometry::vector64::{Vector64, cross, difference, dot, max_abs, widened};

/// A computed value and a bound on its distance from the exact one.
#[derive(Clone, Copy)]
pub struct Approximate {
    /// The computed value.
    pub value: f64,
    /// A bound on the distance of the exact value from the computed one.
    pub error: f64,
}

impl Approximate {
    /// The value that is exactly 0.
    pub(super) const ZERO: Self = Self { value: 0.0, error: 0.0 };

    /// Tells whether the exact value surely has the sign of the computed value, and is not 0.
    #[inline]
    fn is_certain(self) -> bool {
        self.value.abs() > self.error
    }

    /// The sign of the exact value where that is certain and not 0, else 0.
    #[inline]
    pub(super) fn certain_sign(self) -> i32 {
        i32::from(self.value > self.error) - i32::from(self.value < -self.error)
    }
}

/// The volumes of one ray and one triangle in `f64`.
#[derive(Clone, Copy)]
pub struct Volumes {
    /// `det t`
    pub t: Approximate,
    /// `det u`
    pub u: Approximate,
    /// `det v`
    pub v: Approximate,
    /// `det w`
    pub w: Approximate,
    /// `det`, the divisor of the others
    pub det: Approximate,
}

impl Volumes {
    #[inline]
    pub(super) fn new(pair: &Pair<'_>) -> Self {
        Self::seen(pair, widened(pair.ray.origin()))
    }

    /// Computes the volumes for a ray that begins at another point.
    #[inline]
    fn seen(&Pair { ray, triangle }: &Pair<'_>, origin: Vector64) -> Self {
        const R: f64 = f64::EPSILON / 2.0;

        let corner = widened(triangle.a);
        let d = widened(ray.direction());
        let a = difference(corner, origin);
        let e1 = difference(widened(triangle.b), corner);
        let e2 = difference(widened(triangle.c), corner);
        let normal = cross(e1, e2);

        let det = dot(d, normal);
        let t = dot(a, normal);
        let u = dot(d, cross(e2, a));
        let v = dot(d, cross(a, e1));
        let w = det - u - v;

        let d_max = max_abs(d);
        let a_max = max_abs(a);
        let (e1_max, e2_max) = (max_abs(e1), max_abs(e2));
        let e_max = if e1_max > e2_max { e1_max } else { e2_max };
        let de = d_max * e_max;
        let bound = |value: f64, error: f64| Approximate { value, error };
        Self {
            t: bound(t, 56.0 * R * a_max * e_max * e_max),
            u: bound(u, 48.0 * R * de * a_max),
            v: bound(v, 48.0 * R * de * a_max),
            w: bound(w, 64.0 * R * de * (e_max + 2.0 * a_max)),
            det: bound(det, 48.0 * R * de * e_max),
        }
    }

    /// Computes the weights again, as seen from a point of the line close to the triangle. `None` if `f64` does not
    /// hold such a point exactly.
    ///
    /// The volumes of the weights do not depend on where on its line a ray begins, but their bounds grow with the
    /// distance. The product of two `f32` is exact, and so is a sum that gives back both of its parts. `t` stays that
    /// of the origin.
    #[cold]
    #[inline(never)]
    pub(super) fn seen_from_nearer(&self, pair: &Pair<'_>) -> Option<Self> {
        let t = f64::from((self.t.value / self.det.value) as f32);
        let (o, d) = (widened(pair.ray.origin()), widened(pair.ray.direction()));
        let mut point = [0.0; 3];
        for (axis, at) in point.iter_mut().enumerate() {
            let (o, step) = (o[axis % 3], t * d[axis % 3]);
            *at = o + step;
            if *at - o != step || *at - step != o {
                return None;
            }
        }
        let Self { u, v, w, .. } = Self::seen(pair, point);
        Some(Self { u, v, w, ..*self })
    }

    /// Tells whether the origin is so far away, measured in edges of the triangle, that [`Volumes::seen_from_nearer`]
    /// pays.
    #[inline]
    pub(super) fn are_from_far(&self) -> bool {
        const EDGES: f64 = 65_536.0; // 2^16
        // Both errors are the same multiple: that of u of the largest distance, that of det of the longest edge.
        self.u.error > EDGES * self.det.error
    }

    /// Tells whether the signs of the three weights are certain, and none is 0.
    #[inline]
    pub(super) fn are_certain(&self) -> bool {
        let Self { u, v, w, .. } = self;
        u.is_certain() && v.is_certain() && w.is_certain()
    }

    /// The sign of `det` if the line meets the closed triangle. The signs of the weights have to be certain.
    #[inline]
    pub(super) fn hit_sign(&self) -> Option<i32> {
        let Self { u, v, w, .. } = self;
        let negative = w.value < 0.0;
        let same = (u.value < 0.0) == negative && (v.value < 0.0) == negative;
        same.then_some(if negative { -1 } else { 1 })
    }
}

/// The divisor of the volumes of a hit: `det`, as its inverse.
#[derive(Clone, Copy)]
pub(super) struct Divisor {
    error: f64,
    /// The inverse of `det`; NaN if the error of `det` is too large a part of it. No comparison with a quotient holds
    /// then, and exact arithmetic decides.
    inverse: f64,
}

impl Divisor {
    #[inline]
    pub fn new(det: Approximate) -> Self {
        let certain = det.error < det.value.abs() * 1e-4;
        let inverse = if certain { 1.0 / det.value } else { f64::NAN };
        Self { error: det.error, inverse }
    }

    /// The `f32` values between which the quotient, rounded to `f32`, must lie.
    ///
    /// With `N`, `D` exact and `n`, `d` computed: `N/D - n/d = ((N - n) d - n (D - d)) / (D d)`, at most
    /// `(error_n + |n/d| error_d) / (|d| - error_d)`, where the divisor is at least `0.9999 |d|`. The
    /// quotient rounds twice, the products and sums of its error a few times; the factor 1.001 and the
    /// relative 2^-50 cover that. Rounding to `f32` keeps the order.
    #[inline]
    pub fn quotient(&self, numerator: Approximate) -> Bracket {
        let q = numerator.value * self.inverse;
        let error = (numerator.error + q.abs() * self.error) * self.inverse.abs() * 1.001
            + q.abs() * 4.0 * f64::EPSILON;
        Bracket { low: (q - error) as f32, high: (q + error) as f32 }
    }
}

/// Bounds on a quotient that is to be rounded to the nearest `f32`.
pub(super) struct Bracket {
    low: f32,
    high: f32,
}

impl Bracket {
    /// Tells whether the nearest `f32` surely lies outside the interval.
    #[inline]
    pub fn is_outside(&self, t_min: f32, t_max: f32) -> bool {
        self.high < t_min || self.low > t_max
    }

    /// Rounds to the nearest `f32`, ties to even, never -0.0. `det_sign` is the sign of the exact `det`.
    #[inline]
    pub fn round(&self, pair: &Pair<'_>, volume: Volume, det_sign: i32) -> f32 {
        let Self { low, high } = *self;
        if low == high { low + 0.0 } else { pair.round(volume, det_sign, low, high) }
    }
}
