//! The exact test between a ray and a triangle.
//!
//! With `o`, `d` the ray, `a = A - o`, `e1 = B - A`, `e2 = C - A`, everything is a ratio of volumes:
//!
//! ```text
//! det = d . (e1 x e2)       det * u = d . (e2 x a)
//! det * t = a . (e1 x e2)   det * v = d . (a x e1)    w = 1 - u - v
//! ```
//!
//! # What a hit is
//! The line meets the closed triangle if `det * u`, `det * v` and `det * w` have no two opposite
//! signs and are not all zero. All zero means a coplanar line or a triangle without area: no hit.
//! `t` is the `f32` nearest to the exact quotient (ties to even) and must be finite and inside the
//! interval. So a hit is a function of the eighteen input floats, not of the order in which anything
//! was computed; two neighbours agree about their shared edge, and there is no epsilon.
//!
//! # How it is decided
//! 1. An `f32` filter that only rejects.
//! 2. An `f64` filter.
//! 3. For what is still in doubt, expansions, which are exact.
//!
//! Each filter compares a value with a bound on its own error.
//!
//! # The error bounds
//! Let `r` be half an ulp of 1 (2^-24 or 2^-53), `D`, `E`, `S` the largest components of `d`, of `e1`
//! and `e2`, and of `a`. A volume like `d . (e2 x a)` goes through 2 differences, 2 products, 1
//! difference and 2 sums: 7 roundings. Its 6 terms are at most `D E S`, so the error is at most
//! `6 ((1 + r)^7 - 1) D E S < 42.1 r D E S`. The magnitudes in the bound are themselves rounded (at
//! most 5 roundings, each a factor `1 - r`), which 48 covers: `|error| <= 48 r D E S`. `det` is the
//! same with `E` for `S`; `det * t` has 8 roundings, 48.1, and 56 covers it.
//! `w = det - u - v` adds two roundings of values up to `6 D E (E + 2 S)`: `48 + 13 < 64`, hence
//! `64 r D E (E + 2 S)`.
//! In `f64` nothing underflows (see `expansion`). In `f32` a product that underflows loses at most
//! 2^-150, a volume less than `12 * 2^-150 * max(D, 1)`; the bound adds `2^-120 * max(D, 1)` for it.
//! The filter is used only where `D`, `E`, `S` lie in 2^-60..=2^60 and the volumes below 2^103, so
//! that nothing overflows.
//!
//! # Source
//! T. Möller, B. Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997, for the volumes;
//! J. R. Shewchuk 1997 for the filters and expansions.

use glam::Vec3;

use super::exact::{Exact, Volume};
use super::{Ray, Triangle};

/// Where a ray meets a triangle: the point `origin + t * direction` is `A + u (B - A) + v (C - A)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// The `f32` nearest to the exact parameter; finite.
    pub t: f32,
    /// The `f32` nearest to the exact weight of corner `b`.
    pub u: f32,
    /// The `f32` nearest to the exact weight of corner `c`; where `u + v` would be more than 1, the
    /// largest with which it is not.
    pub v: f32,
}

/// Intersects one ray with one triangle, exactly.
///
/// # Examples
/// ```
/// use arboleda::{intersect, Ray, Triangle, Vec3};
/// let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
/// let corner = Ray::new(Vec3::new(1.0, 0.0, -3.0), Vec3::Z)?;
/// let hit = intersect(&corner, &triangle).expect("corners belong to the triangle");
/// assert_eq!((hit.t, hit.u, hit.v), (3.0, 1.0, 0.0));
/// # Ok::<(), arboleda::RayError>(())
/// ```
pub fn intersect(ray: &Ray, triangle: &Triangle) -> Option<Intersection> {
    if surely_missed(ray, triangle) {
        return None;
    }
    meet(ray, triangle, ray.t_min(), ray.t_max()).map(|meeting| meeting.intersection())
}

/// What somebody else's filter says of a ray and a triangle.
#[derive(Clone, Copy)]
pub enum Verdict {
    /// There is surely no hit in the interval.
    Missed,
    /// There surely is, and this is it.
    Hit(Intersection),
    /// Who knows; [`meet`] does.
    InDoubt,
}

/// A ray that hits a triangle; where in the triangle is found out when asked.
pub struct Meeting<'p> {
    pair: Pair<'p>,
    u: Approximate,
    v: Approximate,
    det: Divisor,
    t: f32,
}

/// The hit with `t_min <= t <= t_max`, if there is one; without the `f32` filter.
#[inline]
pub fn meet<'p>(
    ray: &'p Ray,
    triangle: &'p Triangle,
    t_min: f32,
    t_max: f32,
) -> Option<Meeting<'p>> {
    let pair = Pair { ray, triangle };
    let volumes = Volumes::new(&pair);
    let det = Divisor::new(volumes.det, volumes.hit_sign(&pair)?);
    let t = det.quotient(volumes.t);
    if t.high < t_min || t.low > t_max {
        return None;
    }
    let t = t.round(&pair, det.sign, Exact::t_minus);
    let inside = t_min <= t && t <= t_max && t.is_finite();
    inside.then_some(Meeting { pair, u: volumes.u, v: volumes.v, det, t })
}

impl Meeting<'_> {
    /// See [`Intersection::t`].
    #[inline]
    pub fn t(&self) -> f32 {
        self.t
    }

    /// All of it.
    #[inline]
    pub fn intersection(&self) -> Intersection {
        let (pair, det) = (&self.pair, &self.det);
        let u = det.quotient(self.u).round(pair, det.sign, Exact::u_minus);
        let v = det.quotient(self.v).round(pair, det.sign, Exact::v_minus);
        Intersection { t: self.t, u, v: clamped(u, v) }
    }
}

/// The largest `f32` that is at most `v` and at most the exact `1 - u`.
#[inline]
pub(crate) fn clamped(u: f32, v: f32) -> f32 {
    // Rounded down where u is too small for the difference to be exact.
    let rounded = 1.0 - f64::from(u);
    let room = if 1.0 - rounded < f64::from(u) { rounded.next_down() } else { rounded };
    if f64::from(v) <= room {
        return v;
    }
    let nearest = room as f32;
    if f64::from(nearest) > room { nearest.next_down() } else { nearest }
}

/// The `f32` filter: `true` only if two of the volumes surely have opposite signs.
pub fn surely_missed(ray: &Ray, triangle: &Triangle) -> bool {
    const R: f32 = f32::EPSILON / 2.0;
    const UNDERFLOW: f32 = 7.523_164e-37; // 2^-120
    const LEAST: f32 = 8.673_617e-19; // 2^-60
    const MOST: f32 = 1.152_921_5e18; // 2^60

    let d = ray.direction();
    let a = triangle.a - ray.origin();
    let e1 = triangle.b - triangle.a;
    let e2 = triangle.c - triangle.a;
    let d_max = largest(d);
    let a_max = largest(a);
    let e_max = larger(largest(e1), largest(e2));
    let tame = |x: f32| (LEAST..=MOST).contains(&x);
    let de = d_max * e_max;
    let scale = de * larger(e_max, a_max);
    // A NaN or an infinity fails these comparisons, and the f64 filter takes over.
    if !(tame(d_max) && tame(a_max) && tame(e_max) && scale <= 1.267_650_6e30) {
        return false;
    }
    let u = d.dot(e2.cross(a));
    let v = d.dot(a.cross(e1));
    let w = d.dot(e1.cross(e2)) - u - v;
    let underflow = UNDERFLOW * larger(d_max, 1.0);
    let margin = 48.0 * R * de * a_max + underflow;
    let w_margin = 64.0 * R * de * (e_max + 2.0 * a_max) + 4.0 * underflow;
    let negative = u < -margin || v < -margin || w < -w_margin;
    let positive = u > margin || v > margin || w > w_margin;
    negative && positive
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

fn largest(v: Vec3) -> f32 {
    larger(v.x.abs(), larger(v.y.abs(), v.z.abs()))
}

type V3 = [f64; 3];

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn largest64(v: V3) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    larger(v[0].abs(), larger(v[1].abs(), v[2].abs()))
}

/// A computed value and a bound on its distance from the exact one.
#[derive(Clone, Copy)]
struct Approximate {
    value: f64,
    error: f64,
}

impl Approximate {
    /// Whether the exact value has the same sign, and is not 0.
    #[inline]
    fn is_certain(self) -> bool {
        self.value.abs() > self.error
    }

    /// The sign of the exact value, by `exact` where the error leaves it in doubt.
    fn sign(self, exact: impl FnOnce() -> i32) -> i32 {
        if self.value > self.error {
            1
        } else if self.value < -self.error {
            -1
        } else {
            exact()
        }
    }
}

/// What the exact volumes are made from.
#[derive(Clone, Copy)]
struct Pair<'p> {
    ray: &'p Ray,
    triangle: &'p Triangle,
}

impl Pair<'_> {
    fn exact(&self) -> Exact {
        Exact::new(self.ray, *self.triangle)
    }
}

/// The volumes of one ray and one triangle in `f64`.
struct Volumes {
    t: Approximate,
    u: Approximate,
    v: Approximate,
    w: Approximate,
    det: Approximate,
}

impl Volumes {
    #[inline]
    fn new(&Pair { ray, triangle }: &Pair<'_>) -> Self {
        const R: f64 = f64::EPSILON / 2.0;
        let wide = |v: Vec3| [f64::from(v.x), f64::from(v.y), f64::from(v.z)];
        let minus = |p: V3, q: V3| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];

        let corner = wide(triangle.a);
        let d = wide(ray.direction());
        let a = minus(corner, wide(ray.origin()));
        let e1 = minus(wide(triangle.b), corner);
        let e2 = minus(wide(triangle.c), corner);
        let normal = cross(e1, e2);

        let det = dot(d, normal);
        let t = dot(a, normal);
        let u = dot(d, cross(e2, a));
        let v = dot(d, cross(a, e1));
        let w = det - u - v;

        let d_max = largest64(d);
        let a_max = largest64(a);
        let (e1_max, e2_max) = (largest64(e1), largest64(e2));
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

    /// The sign of `det` if the line meets the closed triangle.
    #[inline]
    fn hit_sign(&self, pair: &Pair<'_>) -> Option<i32> {
        let Self { u, v, w, .. } = self;
        if !(u.is_certain() && v.is_certain() && w.is_certain()) {
            return self.hit_sign_exactly(pair);
        }
        let negative = w.value < 0.0;
        let same = (u.value < 0.0) == negative && (v.value < 0.0) == negative;
        same.then_some(if negative { -1 } else { 1 })
    }

    #[cold]
    #[inline(never)]
    fn hit_sign_exactly(&self, pair: &Pair<'_>) -> Option<i32> {
        let u = self.u.sign(|| pair.exact().u_minus(0.0).sign());
        let v = self.v.sign(|| pair.exact().v_minus(0.0).sign());
        if u * v < 0 {
            return None;
        }
        let w = self.w.sign(|| pair.exact().w().sign());
        if u * w < 0 || v * w < 0 {
            return None;
        }
        // No two are opposite, so any that is not zero has the sign of their sum, det.
        [u, v, w].into_iter().find(|&sign| sign != 0)
    }
}

/// What the volumes of a hit are divided by.
#[derive(Clone, Copy)]
struct Divisor {
    error: f64,
    /// NaN where the error is too large a part of it; then nothing that is compared holds, and exact
    /// arithmetic decides.
    inverse: f64,
    sign: i32,
}

impl Divisor {
    #[inline]
    fn new(det: Approximate, sign: i32) -> Self {
        let certain = det.error < det.value.abs() * 1e-4;
        let inverse = if certain { 1.0 / det.value } else { f64::NAN };
        Self { error: det.error, inverse, sign }
    }

    /// The `f32` values between which the quotient, rounded to `f32`, must lie.
    ///
    /// With `N`, `D` exact and `n`, `d` computed: `N/D - n/d = ((N - n) d - n (D - d)) / (D d)`, at most
    /// `(error_n + |n/d| error_d) / (|d| - error_d)`, where the divisor is at least `0.9999 |d|`. The
    /// quotient rounds twice, the products and sums of its error a few times; the factor 1.001 and the
    /// relative 2^-50 cover that. Rounding to `f32` keeps the order.
    #[inline]
    fn quotient(&self, numerator: Approximate) -> Bracket {
        let q = numerator.value * self.inverse;
        let error = (numerator.error + q.abs() * self.error) * self.inverse.abs() * 1.001
            + q.abs() * 4.0 * f64::EPSILON;
        Bracket { low: (q - error) as f32, high: (q + error) as f32 }
    }
}

/// Half-way from the largest `f32` to what would be the next, 2^128: from here on rounding overflows.
const BEYOND_MAX: f64 = 340_282_356_779_733_661_637_539_395_458_142_568_448.0; // 2^128 - 2^103

/// Where a quotient lies that is to be rounded to the nearest `f32`.
struct Bracket {
    low: f32,
    high: f32,
}

impl Bracket {
    /// The nearest `f32`, ties to even; never -0.0. `minus` is the exact `numerator - m * det`.
    #[inline]
    fn round(&self, pair: &Pair<'_>, det_sign: i32, minus: fn(&Exact, f64) -> Volume) -> f32 {
        if self.low == self.high { self.low + 0.0 } else { round_exactly(pair, det_sign, minus) }
    }
}

#[cold]
#[inline(never)]
fn round_exactly(pair: &Pair<'_>, det_sign: i32, minus: fn(&Exact, f64) -> Volume) -> f32 {
    // The exact volumes, rounded: each is off by at most 2^-51 of itself, the quotient by less
    // than 2^-49. At most one boundary between two f32 values lies in such an interval.
    let exact = pair.exact();
    let numerator = minus(&exact, 0.0).estimate();
    let q = numerator / exact.det().estimate();
    let error = q.abs() * (4.0 * f64::EPSILON);
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
    let side = minus(&exact, boundary).sign() * det_sign;
    let nearest = match side {
        0 => boundary as f32, // the conversion rounds ties to even
        1.. => high,
        _ => low,
    };
    nearest + 0.0
}
