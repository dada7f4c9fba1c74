//! Build primitives.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use super::box8::Box8;
use crate::geometry::{Box4, Triangle};

/// Build primitive: the box of a triangle and, beside its corners, its id: the upper 16 bits and the lower 16 bits as
/// numbers.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct Primitive(Box8);

impl Primitive {
    pub fn new(triangle: &Triangle, id: u32) -> Self {
        Self(Box8::new(Box4::of_triangle(triangle), [(id >> 16) as f32, (id & 0xffff) as f32]))
    }

    pub fn id(&self) -> u32 {
        let [upper, lower] = self.0.numbers();
        (upper as u32) << 16 | lower as u32
    }

    /// The smallest box around some primitives.
    pub fn bounds_of(primitives: &[Self]) -> Box4 {
        primitives.iter().fold(Box8::EMPTY, |all, primitive| all.union(primitive.0)).box4()
    }

    /// The box of the triangle. Its numbers for any use are the id's, which are not negative.
    #[inline(always)]
    pub fn bounds(&self) -> Box8 {
        self.0
    }

    /// Twice the centroid of the box. It is infinite where it overflows; no plane separates such centroids.
    #[inline(always)]
    pub fn doubled_centroid(&self) -> Vec4 {
        self.0.doubled_centroid()
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

    #[inline(always)]
    pub fn around(primitives: &[Primitive]) -> Self {
        Self::EMPTY.with(primitives)
    }

    /// The bounds of these and more primitives.
    #[inline(always)]
    pub fn with(self, primitives: &[Primitive]) -> Self {
        let mut bounds = Box8::new(self.bounds, [0.0; 2]);
        let mut centroids = self.centroids;
        for primitive in primitives {
            bounds = bounds.union(primitive.bounds());
            centroids = centroids.union(Box4::at(primitive.doubled_centroid()));
        }
        Self { bounds: bounds.box4(), centroids }
    }
}
