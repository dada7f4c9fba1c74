//! Axis-aligned boxes in SIMD registers, for builds.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use super::{Aabb, Triangle};

/// Axis-aligned box in registers of four numbers; the fourth component is not used.
///
/// No coordinate is -0.0, so minimum and maximum are the same on every target.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Box4 {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Box4 {
    pub const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    pub fn of(bounds: &Aabb) -> Self {
        Self { lo: bounds.lo.extend(0.0), hi: bounds.hi.extend(0.0) }
    }

    /// The box around a triangle.
    #[inline]
    pub fn of_triangle(triangle: &Triangle) -> Self {
        let Triangle { a, b, c } = triangle;
        let [a, b, c] = [a, b, c].map(|corner| Self::at(corner.extend(0.0) + Vec4::ZERO));
        a.union(b).union(c)
    }

    /// The box that is one point.
    #[inline]
    pub fn at(point: Vec4) -> Self {
        Self { lo: point, hi: point }
    }

    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Converts to an [`Aabb`].
    pub fn aabb(self) -> Aabb {
        Aabb::new(self.lo.truncate(), self.hi.truncate())
    }

    /// The largest absolute value of a coordinate.
    pub fn largest_coordinate(&self) -> f32 {
        self.lo.abs().max(self.hi.abs()).truncate().max_element()
    }

    /// Half the surface area.
    pub fn half_area(&self) -> f32 {
        let [x, y, z, _] = (self.hi - self.lo).to_array();
        x * y + y * z + z * x
    }
}
