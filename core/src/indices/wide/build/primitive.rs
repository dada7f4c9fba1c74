//! Build primitives.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use crate::geometry::{Box4, Triangle};

/// Build primitive: the box of a triangle and, in the fourth components, its id, the upper 16 bits and the lower 16
/// bits as numbers.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct Primitive(Box4);

impl Primitive {
    pub fn new(triangle: &Triangle, id: u32) -> Self {
        let Box4 { lo, hi } = Box4::of_triangle(triangle);
        Self(Box4 { lo: lo.with_w((id >> 16) as f32), hi: hi.with_w((id & 0xffff) as f32) })
    }

    pub fn id(&self) -> u32 {
        (self.0.lo.w as u32) << 16 | self.0.hi.w as u32
    }

    /// The smallest box around some primitives.
    pub fn bounds_of(primitives: &[Self]) -> Box4 {
        primitives.iter().fold(Box4::EMPTY, |all, primitive| all.union(primitive.0))
    }

    /// The box of the triangle. Its fourth components are the id's.
    pub fn bounds(&self) -> Box4 {
        self.0
    }

    /// Twice the centroid of the box. It is infinite where it overflows; no plane separates such centroids.
    #[inline]
    pub fn doubled_centroid(&self) -> Vec4 {
        self.0.lo + self.0.hi
    }
}

/// Bounds of some primitives.
#[derive(Clone, Copy)]
pub(crate) struct PrimitiveBounds {
    pub bounds: Box4,
    /// The box around their doubled centroids.
    pub centroids: Box4,
}

impl PrimitiveBounds {
    /// The bounds of no primitives.
    pub const EMPTY: Self = Self { bounds: Box4::EMPTY, centroids: Box4::EMPTY };

    pub fn around(primitives: &[Primitive]) -> Self {
        Self::EMPTY.with(primitives)
    }

    /// The bounds of these and more primitives.
    pub fn with(self, primitives: &[Primitive]) -> Self {
        primitives.iter().fold(self, |all, primitive| Self {
            bounds: all.bounds.union(primitive.bounds()),
            centroids: all.centroids.union(Box4::at(primitive.doubled_centroid())),
        })
    }
}
