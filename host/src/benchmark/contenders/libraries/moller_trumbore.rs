//! The usual triangle test, for libraries that leave it to their users or see one side only.
//!
//! # Source
//! T. Möller, B. Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection*, 1997; without culling.

use arboleda::{Triangle, Vec3};

/// Corner of a triangle and the two edges from it.
#[derive(Clone, Copy, Debug)]
pub(in crate::benchmark::contenders) struct EdgeTriangle {
    corner: Vec3,
    edge_b: Vec3,
    edge_c: Vec3,
}

impl EdgeTriangle {
    /// Prepares a triangle.
    pub(in crate::benchmark::contenders) fn new(triangle: &Triangle) -> Self {
        let Triangle { a, b, c } = *triangle;
        Self { corner: a, edge_b: b - a, edge_c: c - a }
    }

    /// Returns the parameter of the hit, if the rounded test sees one from 0 up to `last`.
    #[inline]
    pub(in crate::benchmark::contenders) fn hit(
        &self,
        origin: Vec3,
        direction: Vec3,
        last: f32,
    ) -> Option<f32> {
        let across = direction.cross(self.edge_c);
        let determinant = self.edge_b.dot(across);
        let inverse = 1.0 / determinant;
        let from_corner = origin - self.corner;
        let u = from_corner.dot(across) * inverse;
        let along = from_corner.cross(self.edge_b);
        let v = direction.dot(along) * inverse;
        let t = self.edge_c.dot(along) * inverse;
        // False where the determinant is 0 and the others are NaN or infinite.
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        (inside && t >= 0.0 && t <= last).then_some(t)
    }
}
