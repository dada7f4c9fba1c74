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
//! 3. Where a weight is still in doubt, what needs no more digits: a plane that is surely crossed outside the interval;
//!    from a far origin, the weights as seen from a point of the line close to the triangle; two weights of opposite
//!    signs; two corners that are one point; a corner on a line along an axis, which is seen by comparing.
//! 4. What is left is mostly a weight of exactly 0, at an edge or a corner, or a ray in the plane: for a direction
//!    along an axis in two coordinates (`planar`), else in whole numbers of 128 bits, where coordinates allow that
//!    (`lattice`).
//! 5. For the rest, fixed-point numbers long enough for any coordinates (`long_sum`).
//!
//! Each filter compares a value with a bound on its own error; the last two stages round nothing, or know the error
//! exactly. Before the `f64` filter, a ray and a triangle that both have no extent on some axis are parallel, which is
//! seen by comparing.
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
//! In `f64` nothing underflows: a volume and its terms are multiples of 2^(-3 * 149), and of 2^(-4 * 149) as seen from
//! a point `o + t d` that `f64` holds exactly, `t` an `f32`. In `f32` a product that
//! underflows loses at most 2^-150, a volume less than `12 * 2^-150 * max(D, 1)`; the bound adds
//! `2^-120 * max(D, 1)` for it.
//! The filter is used only where `D`, `E`, `S` lie in 2^-60..=2^60 and the volumes below 2^103, so
//! that nothing overflows.
//!
//! # Measured
//! Instructions of [`intersect`] on a Cortex-M4, where `f64` is calculated in software:
//! - 10,100 for a hit inside a triangle;
//! - 9,600 through a corner and 14,300 through an edge, along an axis;
//! - 12,200 through a corner, decided in whole numbers, and 19,100 in fixed point.
//!
//! # Source
//! T. Möller, B. Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997, for the volumes;
//! J. R. Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997, for
//! filters and stages.

mod exact;
mod lattice;
mod long_sum;
mod pair;
mod planar;
mod volumes;

use glam::Vec3;

use super::{Ray, Triangle};
use pair::{Pair, Volume, Weight};
pub use volumes::{Approximate, Volumes};
use volumes::{Bracket, Divisor};

/// Intersection of a ray and a triangle: the point `origin + t * direction` is `A + u (B - A) + v (C - A)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// The `f32` nearest to the exact parameter; finite.
    pub t: f32,
    /// The `f32` nearest to the exact weight of corner `b`.
    pub u: f32,
    /// The `f32` nearest to the exact weight of corner `c`; or, if `u + v` would exceed 1, the largest with which it
    /// does not.
    pub v: f32,
}

/// Intersects one ray with one triangle, exactly. `None` if there is no hit in `t_min..=t_max`.
///
/// # Examples
/// ```
/// use arboleda::{Ray, Triangle, Vec3, intersect};
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

/// Result of a caller's own floating-point filter.
#[derive(Clone, Copy)]
pub enum Verdict {
    /// Surely no hit in the interval.
    Missed,
    /// Surely this hit, which lies in the interval.
    Hit(Intersection),
    /// The filter cannot tell; [`meet`] decides.
    InDoubt,
    /// The filter cannot tell, but has computed the volumes with the bounds of this module; [`meet_exactly`] decides.
    Doubtful(Volumes),
}

/// Hit whose weights are computed on demand.
pub struct Meeting<'p> {
    weights: UndividedWeights<'p>,
    t: f32,
}

/// Weights of a hit, before the division by `det`.
struct UndividedWeights<'p> {
    pair: Pair<'p>,
    u: Approximate,
    v: Approximate,
    det: Divisor,
    /// The sign of the exact `det`.
    det_sign: i32,
}

/// Finds the hit with `t_min <= t <= t_max`, exactly; without the `f32` filter.
#[inline]
pub fn meet<'p>(
    ray: &'p Ray,
    triangle: &'p Triangle,
    t_min: f32,
    t_max: f32,
) -> Option<Meeting<'p>> {
    let pair = Pair { ray, triangle };
    if pair.is_along_flat() {
        return None;
    }
    let volumes = Volumes::new(&pair);
    if !volumes.are_certain() {
        return meet_exactly(ray, triangle, &volumes, t_min, t_max);
    }
    Meeting::new(pair, &volumes, volumes.hit_sign()?, t_min, t_max)
}

/// Finds the hit as [`meet`] does, for a pair of which a weight may be 0. Tests that need no exact arithmetic come
/// first.
// Forced: each caller is a function of its own for this, and two calls would be one too many.
#[allow(clippy::inline_always)]
#[inline(always)]
pub fn meet_exactly<'p>(
    ray: &'p Ray,
    triangle: &'p Triangle,
    volumes: &Volumes,
    t_min: f32,
    t_max: f32,
) -> Option<Meeting<'p>> {
    let pair = Pair { ray, triangle };
    // 1. Reject a plane that is surely crossed outside the interval.
    let det = Divisor::new(volumes.det);
    let t = det.quotient(volumes.t);
    if t.is_outside(t_min, t_max) {
        return None;
    }
    // 2. Reject certain signs that are opposite, and triangles without area. A far origin is replaced by a closer
    // point.
    let nearer = if volumes.are_from_far() { volumes.seen_from_nearer(&pair) } else { None };
    let volumes = nearer.as_ref().unwrap_or(volumes);
    let [u, v, w] = [volumes.u, volumes.v, volumes.w].map(Approximate::certain_sign);
    if (u > 0 || v > 0 || w > 0) && (u < 0 || v < 0 || w < 0) {
        return None;
    }
    let det_sign = volumes.det.certain_sign();
    if det_sign == 0 && (pair.is_along_flat() || pair.has_equal_corners()) {
        return None;
    }
    // 3. Decide the other signs: by a corner on the ray's line, else exactly.
    let corner = if det_sign == 0 { None } else { pair.corner_on_line() };
    let (u, v, det_sign) = match corner {
        _ if u != 0 && v != 0 && w != 0 => (u, v, u),
        Some(Weight::U) => (det_sign, 0, det_sign),
        Some(Weight::V) => (0, det_sign, det_sign),
        Some(Weight::W) => (0, 0, det_sign),
        None => exact_signs(&pair, u, v, w)?,
    };
    let known = |sign: i32, volume| if sign == 0 { Approximate::ZERO } else { volume };
    let (u, v) = (known(u, volumes.u), known(v, volumes.v));
    Meeting::at(&t, UndividedWeights { pair, u, v, det, det_sign }, t_min, t_max)
}

/// Finds the signs of `det u`, `det v` and `det`; `None` if the line misses the triangle. A sign given as 0 is found by
/// exact arithmetic.
#[cold]
#[inline(never)]
fn exact_signs(pair: &Pair<'_>, u: i32, v: i32, w: i32) -> Option<(i32, i32, i32)> {
    let signs = pair.signs();
    let of = |certain: i32, weight| if certain != 0 { certain } else { signs.of(weight) };
    let (u, v) = (of(u, Weight::U), of(v, Weight::V));
    if u * v < 0 {
        return None;
    }
    let w = of(w, Weight::W);
    if u * w < 0 || v * w < 0 {
        return None;
    }
    // No two signs are opposite, so any sign that is not 0 is that of their sum, det.
    let det = [u, v, w].into_iter().find(|&sign| sign != 0)?;
    Some((u, v, det))
}

impl<'p> Meeting<'p> {
    /// Makes the hit of a line that meets the triangle; `None` if it lies outside the interval.
    #[inline]
    fn new(
        pair: Pair<'p>,
        volumes: &Volumes,
        det_sign: i32,
        t_min: f32,
        t_max: f32,
    ) -> Option<Self> {
        let det = Divisor::new(volumes.det);
        let t = det.quotient(volumes.t);
        if t.is_outside(t_min, t_max) {
            return None;
        }
        let weights = UndividedWeights { pair, u: volumes.u, v: volumes.v, det, det_sign };
        Self::at(&t, weights, t_min, t_max)
    }

    /// Makes the hit of bounds on `t` that are not outside the interval.
    #[inline]
    fn at(t: &Bracket, weights: UndividedWeights<'p>, t_min: f32, t_max: f32) -> Option<Self> {
        let t = t.round(&weights.pair, Volume::T, weights.det_sign);
        let inside = t_min <= t && t <= t_max && t.is_finite();
        inside.then_some(Self { weights, t })
    }

    /// The parameter; see [`Intersection::t`].
    #[inline]
    pub fn t(&self) -> f32 {
        self.t
    }

    /// Computes the weights too.
    #[inline]
    pub fn intersection(&self) -> Intersection {
        let UndividedWeights { pair, u, v, det, det_sign } = &self.weights;
        let u = det.quotient(*u).round(pair, Volume::Of(Weight::U), *det_sign);
        let v = det.quotient(*v).round(pair, Volume::Of(Weight::V), *det_sign);
        Intersection { t: self.t, u, v: clamped(u, v) }
    }
}

/// The largest `f32` that exceeds neither `v` nor the exact `1 - u`.
#[inline]
pub(crate) fn clamped(u: f32, v: f32) -> f32 {
    // Far from 1, the sum needs no exact arithmetic to be at most 1.
    if u + v < 0.999 {
        return v;
    }
    // Rounded down where u is too small for the difference to be exact.
    let rounded = 1.0 - f64::from(u);
    let room = if 1.0 - rounded < f64::from(u) { rounded.next_down() } else { rounded };
    if f64::from(v) <= room {
        return v;
    }
    let nearest = room as f32;
    if f64::from(nearest) > room { nearest.next_down() } else { nearest }
}

/// Filters in `f32`: true only if two of the weights surely have opposite signs.
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
        // Differences of what is not equal are never 0. So this is a triangle whose corners are one point.
        return e_max == 0.0;
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
