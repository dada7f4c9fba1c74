//! Conservative slab test: the part of a ray in a box or before a plane, never too narrow.
//!
//! ```text
//! ray --+-- near, of usual numbers -- lanes of f32 for the three axes, with the bounds of `lane_ray`
//!       +-- any other -------------- f64, axis by axis, rounded outwards to f32
//! ```
//! # The bound in `f64`
//! Let `p` be a plane's coordinate, `o` and `d` the ray's origin and direction on that axis, and `r = 2^-53`.
//! 1. The computed `(p - o) / d` goes through two roundings. So it is the exact parameter times a factor between
//!    `(1 - r)^2` and `(1 + r)^2`, however far away the origin is.
//! 2. Nothing over- or underflows, since all inputs are `f32`.
//! 3. The result is moved by 2^-50 = `8 r` of itself to either side. That covers the exact value.
//! 4. `start` is subtracted, which rounds a result of at most `|t| + |start|`. The margin is taken of that sum, so it
//!    covers this rounding too. Then the next `f32` beyond is taken, which covers the conversion.
//!
//! If `d` is 0, the ray runs along the plane: it is on the low side, on the high side, or in the plane.
//!
//! # Far origins
//! Bounds that are relative to `t` say little about a scene that is small beside its distance: from a million times its
//! size, no `f32` tells the planes of one side from those of the other. So spans count from `start`, the parameter at
//! which such a ray enters the scene. A ray is far if its origin is more than 2^8 times the scene's longest side away
//! from the scene. For all other rays, a relative error of 2^-21 is at most 2^-13 of that side.

use glam::{Vec4, Vec4Swizzles};

use super::lane_filter::Numbers;
use super::lane_ray::{LaneRay, UNDERFLOW};
use super::{Aabb, Ray};

/// Part of a ray, `from <= s <= to`; empty if `from > to`.
///
/// `s` is the ray's parameter `t`; if the ray comes from far away, less the `t` at which it enters the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// A lower bound on the parameter of the first point that counts.
    pub from: f32,
    /// An upper bound on the parameter of the last point that counts.
    pub to: f32,
}

/// Bounds on the parameter at which a ray crosses a plane across an axis, counted as a [`Span`] counts.
///
/// Of the points of the ray's interval, those before `earliest` are on the side that the ray comes from, those after
/// `latest` on the other. A NaN bounds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisCrossing {
    /// A lower bound on the parameter of the crossing.
    pub earliest: f32,
    /// An upper bound on the parameter of the crossing.
    pub latest: f32,
}

/// Ray prepared for slab tests with many boxes.
#[derive(Clone, Copy, Debug)]
pub struct RaySpan {
    lanes: LaneRay,
    /// The parameter from which spans count; 0 if the bounds of lanes hold.
    start: f64,
    span: Span,
    sign_mask: u32,
    /// True if the bounds of lanes hold, and the origin is not far away.
    is_tame: bool,
    /// True if a component of the direction is 0.
    is_along: bool,
}

/// Relative widening of a parameter; see "The bound in `f64`".
const MARGIN: f64 = 8.881_784_197_001_252e-16; // 2^-50
/// Distance of a far origin, in sides of the scene; see "Far origins".
const FAR: f32 = 256.0;

impl RaySpan {
    /// Prepares a ray for boxes and planes inside a scene.
    #[inline]
    pub fn new(ray: &Ray, scene: &Aabb) -> Self {
        let (lo, hi) = (scene.lo.extend(0.0), scene.hi.extend(0.0));
        let (origin, largest) = (ray.origin().extend(0.0), lo.abs().larger(hi.abs()));
        let distance = (lo - origin).larger(origin - hi).max_element();
        if distance <= (hi - lo).max_element() * FAR
            && let Some((lanes, is_along)) = LaneRay::of(ray, largest.max_element())
        {
            let sign_mask = ray.direction().extend(0.0).cmplt(Vec4::ZERO).bitmask();
            let t_max = ray.t_max();
            let last = if t_max < f32::MAX { t_max } else { f32::MAX };
            let span = Span { from: ray.t_min(), to: last + UNDERFLOW };
            return Self { lanes, start: 0.0, span, sign_mask, is_tame: true, is_along };
        }
        Self::in_f64(ray, scene)
    }

    /// Prepares a ray for which the bounds of lanes do not hold.
    #[cold]
    #[inline(never)]
    fn in_f64(ray: &Ray, scene: &Aabb) -> Self {
        let (origin, d) = (ray.origin().extend(0.0), ray.direction().extend(0.0));
        let lanes = LaneRay { origin: origin.to_array(), direction: d.to_array(), ..LaneRay::IDLE };
        let span = Span { from: f32::NEG_INFINITY, to: f32::INFINITY };
        let (sign_mask, is_along) =
            (d.cmplt(Vec4::ZERO).bitmask(), ray.direction().to_array().contains(&0.0));
        let mut prepared = Self { lanes, start: 0.0, span, sign_mask, is_tame: false, is_along };
        // The first point of the scene, or of the ray, if that is later.
        let near = |axis: usize| scene.along(axis)[prepared.sign_mask() >> axis & 1];
        let entries = [0, 1, 2].map(|axis| prepared.bounds_of_crossing(axis, near(axis))[0]);
        let start =
            entries.into_iter().fold(f64::from(ray.t_min()), |a, b| if b > a { b } else { a });
        prepared.start = if start.is_finite() { start } else { 0.0 };
        prepared.span = Span {
            from: prepared.rounded(f64::from(ray.t_min().next_down())).earliest,
            to: prepared.last(ray.t_max()),
        };
        prepared
    }

    /// The whole ray.
    #[inline]
    pub fn whole(&self) -> Span {
        self.span
    }

    /// The signs of the direction: bit `axis` is set if the ray runs towards smaller coordinates on that axis.
    #[inline]
    pub fn sign_mask(&self) -> usize {
        self.sign_mask as usize
    }

    /// The ray for lanes; `None` if their bounds do not hold.
    #[inline]
    pub(crate) fn lanes(&self) -> Option<&LaneRay> {
        self.is_tame.then_some(&self.lanes)
    }

    /// The largest parameter that a hit can have whose parameter is rounded to `t`. If hits count up to `t`, a part that
    /// begins beyond need not be entered.
    #[inline]
    pub fn last(&self, t: f32) -> f32 {
        if self.is_tame { t + UNDERFLOW } else { self.last_in_f64(t) }
    }

    /// The point at which the ray is at a parameter, on one axis; rounded.
    #[inline]
    pub(crate) fn position(&self, axis: usize, at: f32) -> f32 {
        let (origin, direction) = self.along(axis);
        if self.is_tame {
            return origin + direction * at;
        }
        (f64::from(origin) + f64::from(direction) * (self.start + f64::from(at))) as f32
    }

    /// The coordinate of the origin, and the component of the direction, on one axis.
    #[inline]
    pub fn along(&self, axis: usize) -> (f32, f32) {
        (self.lanes.origin[axis % 4], self.lanes.direction[axis % 4])
    }

    /// Bounds the parameter at which the ray crosses the plane at coordinate `plane` of axis 0, 1 or 2.
    #[inline]
    pub fn crossing(&self, axis: usize, plane: f32) -> AxisCrossing {
        if !self.is_tame {
            return self.crossing_in_f64(axis, plane);
        }
        let distance = self.lanes.origin[axis % 4] - plane;
        AxisCrossing {
            earliest: distance * self.lanes.enter[axis % 4],
            latest: distance * self.lanes.leave[axis % 4] + UNDERFLOW,
        }
    }

    /// Bounds the parameters at which the ray crosses three planes, one across each axis: the earliest, then the
    /// latest. The fourth number given must be 0 or NaN; the fourth lanes are NaN. Planes at NaN bound nothing.
    #[inline]
    pub(crate) fn crossings(&self, planes: Vec4) -> [Vec4; 2] {
        if !self.is_tame {
            return self.crossings_in_f64(planes);
        }
        let distance = Vec4::from_array(self.lanes.origin) - planes;
        [
            distance * Vec4::from_array(self.lanes.enter),
            distance * Vec4::from_array(self.lanes.leave) + Vec4::splat(UNDERFLOW),
        ]
    }

    /// Clips `span` to what may lie between two planes of one axis, `lo <= hi`.
    #[inline]
    pub fn between(&self, axis: usize, lo: f32, hi: f32, span: Span) -> Span {
        let (near, far) = if self.sign_mask >> axis & 1 == 0 { (lo, hi) } else { (hi, lo) };
        span.after(self.crossing(axis, near).earliest).until(self.crossing(axis, far).latest)
    }

    /// Clips `span` to what may lie in a closed box, which is not empty.
    ///
    /// The result is also empty if the box has no extent on an axis on which the direction is 0: all triangles in such
    /// a box lie in a plane along which the ray runs, so none of them can be hit.
    #[inline]
    pub fn clip(&self, bounds: &Aabb, span: Span) -> Span {
        let sides: &[f32; 6] = bytemuck::must_cast_ref(bounds);
        let [a, b, c, d, e, f] = *sides;
        let (lo, hi) = (Vec4::new(a, b, c, d), Vec4::new(c, d, e, f).yzwx());
        self.clip_sides(lo, hi, span)
    }

    /// Clips as [`clip`](Self::clip) does. The fourth lane of the sides is ignored.
    #[inline]
    pub(crate) fn clip_sides(&self, lo: Vec4, hi: Vec4, span: Span) -> Span {
        if self.is_along || !self.is_tame {
            return self.clip_slowly(lo, hi, span);
        }
        // The nearer side is the one with the earlier crossing: two products and a comparison take less than choosing
        // the sides.
        let [below, above] = [lo, hi].map(|side| Vec4::from_array(self.lanes.origin) - side);
        let (enter, leave) =
            (Vec4::from_array(self.lanes.enter), Vec4::from_array(self.lanes.leave));
        let from = (below * enter).smaller(above * enter);
        let to = (below * leave).larger(above * leave) + Vec4::splat(UNDERFLOW);
        span.within(from, to)
    }

    /// Clips any ray.
    #[inline(never)]
    fn clip_slowly(&self, lo: Vec4, hi: Vec4, span: Span) -> Span {
        if self.is_along && self.is_along_flat(lo, hi) {
            return Span { from: f32::INFINITY, to: f32::NEG_INFINITY };
        }
        let downwards = Vec4::from_array(self.lanes.direction).cmplt(Vec4::ZERO);
        let (near, far) = (Vec4::select(downwards, hi, lo), Vec4::select(downwards, lo, hi));
        let ([from, _], [_, to]) = (self.crossings(near), self.crossings(far));
        span.within(from, to)
    }

    /// Tells whether a box has no extent on an axis on which the direction is 0.
    #[cold]
    #[inline(never)]
    fn is_along_flat(&self, lo: Vec4, hi: Vec4) -> bool {
        const AXES: u32 = 0b0111;
        let still = Vec4::from_array(self.lanes.direction).cmpeq(Vec4::ZERO);
        still.bitmask() & lo.cmpeq(hi).bitmask() & AXES != 0
    }

    /// Bounds a crossing in `f64`, without subtracting the start.
    fn bounds_of_crossing(&self, axis: usize, plane: f32) -> [f64; 2] {
        let (origin, direction) = self.along(axis);
        if direction == 0.0 {
            // Along the plane: on its low side for all t, on its high side for all t, or in it for all t.
            return if origin < plane {
                [f64::INFINITY; 2]
            } else if origin > plane {
                [f64::NEG_INFINITY; 2]
            } else {
                [f64::NEG_INFINITY, f64::INFINITY]
            };
        }
        let t = (f64::from(plane) - f64::from(origin)) / f64::from(direction);
        let margin = t.abs() * MARGIN;
        [t - margin, t + margin]
    }

    /// Counts a parameter from the start: the next `f32` before it, and the next after it. What is beyond all `f32`
    /// lies behind all hits, because a reported `t` is finite. An infinity stays: it has no margin.
    fn rounded(&self, t: f64) -> AxisCrossing {
        if t.is_infinite() {
            return AxisCrossing { earliest: t as f32, latest: t as f32 };
        }
        let s = t - self.start;
        let margin = (t.abs() + self.start.abs()) * MARGIN;
        let is_beyond = t as f32 == f32::INFINITY;
        let earliest = ((s - margin) as f32).next_down();
        AxisCrossing {
            earliest: if is_beyond { f32::INFINITY } else { earliest },
            latest: ((s + margin) as f32).next_up(),
        }
    }

    /// Bounds a crossing; see "The bound in `f64`".
    #[cold]
    #[inline(never)]
    fn crossing_in_f64(&self, axis: usize, plane: f32) -> AxisCrossing {
        let [earliest, latest] = self.bounds_of_crossing(axis, plane);
        AxisCrossing {
            earliest: self.rounded(earliest).earliest,
            latest: self.rounded(latest).latest,
        }
    }

    /// The last parameter of hits that round to `t`; see [`last`](Self::last).
    #[cold]
    #[inline(never)]
    fn last_in_f64(&self, t: f32) -> f32 {
        let last = self.rounded(f64::from(t.next_up())).latest;
        if last < f32::MAX { last } else { f32::MAX }
    }

    /// Bounds three crossings in `f64`.
    #[cold]
    #[inline(never)]
    fn crossings_in_f64(&self, planes: Vec4) -> [Vec4; 2] {
        let planes = planes.to_array();
        let [x, y, z] = [0, 1, 2].map(|axis| self.crossing_in_f64(axis, planes[axis % 4]));
        [
            Vec4::new(x.earliest, y.earliest, z.earliest, f32::NAN),
            Vec4::new(x.latest, y.latest, z.latest, f32::NAN),
        ]
    }
}

impl Span {
    /// Tells whether no point of the ray lies in the part.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.from > self.to
    }

    /// The part in which the first three numbers of `from` and `to` bound each axis; a NaN bounds nothing.
    #[inline]
    fn within(self, from: Vec4, to: Vec4) -> Self {
        let ([x, y, z, _], [p, q, r, _]) = (from.to_array(), to.to_array());
        self.after(x).after(y).after(z).until(p).until(q).until(r)
    }

    /// The part from `earliest` on; the same part if that is NaN.
    #[inline]
    #[must_use]
    pub fn after(self, earliest: f32) -> Self {
        Self { from: if earliest > self.from { earliest } else { self.from }, ..self }
    }

    /// The part up to `latest`; the same part if that is NaN.
    #[inline]
    #[must_use]
    pub fn until(self, latest: f32) -> Self {
        Self { to: if latest < self.to { latest } else { self.to }, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;

    /// A ray that runs beside a box misses it from any distance, on either side and on any axis.
    #[test]
    fn rays_beside_a_box_are_clipped() {
        let scene = Aabb { lo: Vec3::splat(-4.0), hi: Vec3::splat(4.0) };
        let bounds = Aabb { lo: Vec3::splat(-1.0), hi: Vec3::splat(1.0) };
        for distance in [8.0, 1e9_f32] {
            for axis in 0..3 {
                for beside in [-2.0, 2.0] {
                    let along = (axis + 1) % 3;
                    let mut origin = [0.0; 3];
                    let mut direction = [0.0; 3];
                    (origin[axis], origin[along], direction[along]) = (beside, -distance, 1.0);
                    let ray = Ray::new(origin.into(), direction.into()).unwrap();
                    let prepared = RaySpan::new(&ray, &scene);
                    let part = prepared.clip(&bounds, prepared.whole());
                    assert!(part.is_empty(), "{origin:?} along {direction:?}: {part:?}");
                    origin[axis] = 0.0;
                    let ray = Ray::new(origin.into(), direction.into()).unwrap();
                    let prepared = RaySpan::new(&ray, &scene);
                    assert!(!prepared.clip(&bounds, prepared.whole()).is_empty());
                }
            }
        }
    }
}
