//! Conservative slab test: the part of a ray in a box or before a plane, never too narrow.
//!
//! # The bound
//! Let `p` be a plane's coordinate, `o` and `d` the ray's origin and direction on that axis, and `r = 2^-53`.
//! 1. The computed `(p - o) * (1 / d)` goes through three roundings. So it is the exact parameter times a factor
//!    between `(1 - r)^3` and `(1 + r)^3`, however far away the origin is.
//! 2. Nothing over- or underflows, since all inputs are `f32` or dyadic fractions of them.
//! 3. The result is moved by 2^-50 = `8 r` of itself to either side: a multiplication by a power of two and one more
//!    rounding. That covers the exact value.
//!
//! Ize 2013 (*Robust BVH Ray Traversal*) gives the like for `f32`.
//!
//! A reported `t` is the exact parameter rounded to `f32`, so the exact one lies between the two
//! `f32` neighbours of `t`; the interval is widened by one `f32` on both sides.
//!
//! If `d` is 0, the ray runs along the plane: it is on the low side, on the high side, or in the plane.

use glam::{BVec3, Vec3};

use super::{Aabb, Ray};

/// Part of a ray, `from <= t <= to`; empty if `from > to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// A lower bound on the parameter of the first point.
    pub from: f64,
    /// An upper bound on the parameter of the last point.
    pub to: f64,
}

/// Bounds on the parameter at which a ray crosses a plane across an axis.
///
/// The ray is on the side it comes from for all `t < earliest`, on the other for all `t > latest`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisCrossing {
    /// A lower bound on the parameter of the crossing.
    pub earliest: f64,
    /// An upper bound on the parameter of the crossing.
    pub latest: f64,
}

/// Ray prepared for slab tests with many boxes.
#[derive(Clone, Copy, Debug)]
pub struct RaySpan {
    origin: [f64; 3],
    direction: [f64; 3],
    inverse: [f64; 3],
    span: Span,
    sign_mask: usize,
    /// The axes on which the direction is 0.
    still: BVec3,
}

/// Relative widening of a parameter; see "The bound" in the module's documentation.
const MARGIN: f64 = 8.881_784_197_001_252e-16; // 2^-50

impl RaySpan {
    /// Prepares a ray.
    pub fn new(ray: &Ray) -> Self {
        let d = ray.direction().to_array();
        let negative = |axis: usize, d: f32| usize::from(d < 0.0) << axis;
        Self {
            origin: ray.origin().to_array().map(f64::from),
            direction: d.map(f64::from),
            // 1 / 0 is never used: `crossing` tests for infinity first.
            inverse: d.map(|d| 1.0 / f64::from(d)),
            span: Span {
                from: f64::from(ray.t_min().next_down()),
                to: last_parameter(ray.t_max()),
            },
            sign_mask: negative(0, d[0]) | negative(1, d[1]) | negative(2, d[2]),
            still: ray.direction().cmpeq(Vec3::ZERO),
        }
    }

    /// The whole ray.
    pub fn whole(&self) -> Span {
        self.span
    }

    /// The signs of the direction: bit `axis` is set if the ray runs towards smaller coordinates on that axis.
    pub fn sign_mask(&self) -> usize {
        self.sign_mask
    }

    /// The coordinate of the origin, and the component of the direction, on one axis.
    pub fn along(&self, axis: usize) -> (f64, f64) {
        match axis {
            0 => (self.origin[0], self.direction[0]),
            1 => (self.origin[1], self.direction[1]),
            _ => (self.origin[2], self.direction[2]),
        }
    }

    /// Bounds the parameter at which the ray crosses the plane at coordinate `plane` of axis 0, 1 or 2.
    #[inline]
    pub fn crossing(&self, axis: usize, plane: f64) -> AxisCrossing {
        let (origin, inverse) = match axis {
            0 => (self.origin[0], self.inverse[0]),
            1 => (self.origin[1], self.inverse[1]),
            _ => (self.origin[2], self.inverse[2]),
        };
        if inverse.is_infinite() {
            // Along the plane: on its low side for all t, on its high side for all t, or in it for all t.
            return if origin < plane {
                AxisCrossing { earliest: f64::INFINITY, latest: f64::INFINITY }
            } else if origin > plane {
                AxisCrossing { earliest: f64::NEG_INFINITY, latest: f64::NEG_INFINITY }
            } else {
                AxisCrossing { earliest: f64::NEG_INFINITY, latest: f64::INFINITY }
            };
        }
        let t = (plane - origin) * inverse;
        let margin = t.abs() * MARGIN;
        AxisCrossing { earliest: t - margin, latest: t + margin }
    }

    /// Clips `span` to what may lie between two planes of one axis, `lo <= hi`.
    #[inline]
    pub fn between(&self, axis: usize, lo: f64, hi: f64, span: Span) -> Span {
        let (near, far) = if self.sign_mask >> axis & 1 == 0 { (lo, hi) } else { (hi, lo) };
        let from = self.crossing(axis, near).earliest;
        let to = self.crossing(axis, far).latest;
        Span {
            from: if from > span.from { from } else { span.from },
            to: if to < span.to { to } else { span.to },
        }
    }

    /// Clips `span` to what may lie in a closed box.
    ///
    /// The result is also empty if the box has no extent on an axis on which the direction is 0: all triangles in such
    /// a box lie in a plane along which the ray runs, so none of them can be hit.
    #[inline]
    pub fn clip(&self, bounds: &Aabb, span: Span) -> Span {
        if self.still.any() && (self.still & bounds.flat_axes()).any() {
            return Span { from: f64::INFINITY, to: f64::NEG_INFINITY };
        }
        let (lo, hi) = (bounds.lo, bounds.hi);
        let span = self.between(0, f64::from(lo.x), f64::from(hi.x), span);
        let span = self.between(1, f64::from(lo.y), f64::from(hi.y), span);
        self.between(2, f64::from(lo.z), f64::from(hi.z), span)
    }
}

impl Span {
    /// Tells whether no point of the ray lies in the part.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.from > self.to
    }
}

/// A bound on the exact parameters that are rounded to a `t <= t_max`; finite, as a reported `t` is.
pub(crate) fn last_parameter(t_max: f32) -> f64 {
    const BEYOND_MAX: f64 = 3.402_823_669_209_385e38; // 2^128
    let next = f64::from(t_max.next_up());
    if next < BEYOND_MAX { next } else { BEYOND_MAX }
}
