//! Triangles.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::Aabb;

/// Closed triangle: its edges and corners belong to it.
///
/// Corners may coincide or lie on a line; such a triangle is never hit. Winding does not matter: both sides are hit.
///
/// Layout: 36 bytes, aligned to 4: `a`, `b`, `c`, each x, y, z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Triangle {
    /// The corner where `u = v = 0`.
    pub a: Vec3,
    /// The corner where `u = 1`.
    pub b: Vec3,
    /// The corner where `v = 1`.
    pub c: Vec3,
}

impl Triangle {
    /// Makes a triangle from its corners.
    pub const fn new(a: Vec3, b: Vec3, c: Vec3) -> Self {
        Self { a, b, c }
    }

    /// Tells whether all nine coordinates are finite.
    pub fn is_finite(&self) -> bool {
        self.a.is_finite() && self.b.is_finite() && self.c.is_finite()
    }

    /// Tells whether the triangle has no extent on an axis on which a direction is 0. A ray in that direction runs
    /// along the triangle's plane and never hits it: the normal lies along that axis, so `det` is 0.
    #[inline]
    pub(crate) fn is_along(&self, direction: Vec3) -> bool {
        let (Self { a, b, c }, d) = (self, direction);
        d.x == 0.0 && a.x == b.x && a.x == c.x
            || d.y == 0.0 && a.y == b.y && a.y == c.y
            || d.z == 0.0 && a.z == b.z && a.z == c.z
    }

    /// The smallest box that holds the triangle; exact.
    pub fn bounds(&self) -> Aabb {
        Aabb::EMPTY.with_point(self.a).with_point(self.b).with_point(self.c)
    }

    /// The normal `(b - a) x (c - a)`, not of unit length: its length is twice the area, and 0 for a triangle without
    /// area.
    pub fn normal(&self) -> Vec3 {
        (self.b - self.a).cross(self.c - self.a)
    }

    /// The point with the barycentric weights `u` (of `b`) and `v` (of `c`).
    pub fn at(&self, u: f32, v: f32) -> Vec3 {
        self.a + (self.b - self.a) * u + (self.c - self.a) * v
    }
}
