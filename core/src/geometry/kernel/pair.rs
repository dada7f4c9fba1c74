//! Ray and triangle, and what is asked about them: the terms in which all stages of the kernel speak.

use glam::Vec3;

use crate::geometry::{Ray, Triangle};

/// A volume: divided by `det`, it gives `t` or a weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Volume {
    /// `det t`
    T,
    /// `det` times a weight
    Of(Weight),
}

/// A weight of a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weight {
    /// The weight of corner `b`.
    U,
    /// The weight of corner `c`.
    V,
    /// The weight of corner `a`.
    W,
}

/// Ray and triangle.
#[derive(Clone, Copy)]
pub(super) struct Pair<'p> {
    pub ray: &'p Ray,
    pub triangle: &'p Triangle,
}

impl Pair<'_> {
    /// Tells whether both have no extent on some axis; see [`Triangle::is_along`].
    #[inline]
    pub fn is_along_flat(&self) -> bool {
        self.triangle.is_along(self.ray.direction())
    }

    /// Tells whether two corners are one point, so that the triangle has no area.
    pub fn has_equal_corners(&self) -> bool {
        let Triangle { a, b, c } = self.triangle;
        a == b || b == c || c == a
    }

    /// Finds the weight of a corner that lies on the line of a ray along an axis. Such a corner differs from the origin
    /// on that axis only, which is found by comparing. The other weights are 0. If two corners lie there, `det` is 0
    /// too.
    #[inline]
    pub fn corner_on_line(&self) -> Option<Weight> {
        let (o, Triangle { a, b, c }) = (self.ray.origin(), *self.triangle);
        let first = |is_on: fn(Vec3, Vec3) -> bool| {
            if is_on(a, o) {
                Some(Weight::W)
            } else if is_on(b, o) {
                Some(Weight::U)
            } else {
                is_on(c, o).then_some(Weight::V)
            }
        };
        match self.ray.direction().cmpne(Vec3::ZERO).bitmask() {
            0b001 => first(|p, o| p.y == o.y && p.z == o.z),
            0b010 => first(|p, o| p.z == o.z && p.x == o.x),
            0b100 => first(|p, o| p.x == o.x && p.y == o.y),
            _ => None,
        }
    }

    /// Tells whether the origin has a coordinate that all corners have, so that it lies in their plane: `t` is 0.
    pub fn begins_on_flat(&self) -> bool {
        let (o, Triangle { a, b, c }) = (self.ray.origin(), self.triangle);
        let same = |o: f32, a: f32, b: f32, c: f32| o == a && o == b && o == c;
        same(o.x, a.x, b.x, c.x) || same(o.y, a.y, b.y, c.y) || same(o.z, a.z, b.z, c.z)
    }
}
