//! Axis-aligned bounding boxes.

use bytemuck::{Pod, Zeroable};
use glam::{BVec3, Vec3};

use super::Ray;

/// Axis-aligned bounding box (AABB), closed: `lo..=hi` on each axis.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Aabb {
    /// The smallest coordinates.
    pub lo: Vec3,
    /// The largest coordinates.
    pub hi: Vec3,
}

impl Aabb {
    /// The empty box: its union with a box is that box.
    pub const EMPTY: Self = Self { lo: Vec3::INFINITY, hi: Vec3::NEG_INFINITY };

    /// Makes the box between two corners.
    pub const fn new(lo: Vec3, hi: Vec3) -> Self {
        Self { lo, hi }
    }

    /// Tells whether no point lies in the box.
    pub fn is_empty(&self) -> bool {
        !(self.lo.x <= self.hi.x && self.lo.y <= self.hi.y && self.lo.z <= self.hi.z)
    }

    /// The smallest box that holds this one and `point`.
    #[must_use]
    pub fn with_point(self, point: Vec3) -> Self {
        self.union(Self::new(point, point))
    }

    /// The smallest box that holds both boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        // Comparisons, because the sign of the zero that `f32::min` returns for (0, -0) differs between targets. Adding
        // 0.0 turns -0.0 into 0.0.
        let less = |a: f32, b: f32| if b < a { b } else { a } + 0.0;
        let more = |a: f32, b: f32| if b > a { b } else { a } + 0.0;
        Self {
            lo: Vec3::new(
                less(self.lo.x, other.lo.x),
                less(self.lo.y, other.lo.y),
                less(self.lo.z, other.lo.z),
            ),
            hi: Vec3::new(
                more(self.hi.x, other.hi.x),
                more(self.hi.y, other.hi.y),
                more(self.hi.z, other.hi.z),
            ),
        }
    }

    /// The axes on which the box has no extent.
    #[inline]
    pub(super) fn flat_axes(&self) -> BVec3 {
        self.lo.cmpeq(self.hi)
    }

    /// Tells whether the box has no extent on an axis on which the direction of a ray is 0. All triangles in such a box
    /// lie in one plane, and the ray runs along that plane: it hits none of them, wherever it begins.
    #[inline]
    pub(crate) fn is_along(&self, ray: &Ray) -> bool {
        (ray.direction().cmpeq(Vec3::ZERO) & self.flat_axes()).any()
    }

    /// Both sides across an axis, 0 to 2 for x, y and z: the lower, then the upper.
    #[inline]
    pub fn along(&self, axis: usize) -> [f32; 2] {
        match axis {
            0 => [self.lo.x, self.hi.x],
            1 => [self.lo.y, self.hi.y],
            _ => [self.lo.z, self.hi.z],
        }
    }

    /// The lengths of the sides, in `f64`, so that they neither overflow nor round a non-zero length to 0. Zeros for
    /// the empty box.
    pub fn extent(&self) -> [f64; 3] {
        if self.is_empty() {
            return [0.0; 3];
        }
        [
            f64::from(self.hi.x) - f64::from(self.lo.x),
            f64::from(self.hi.y) - f64::from(self.lo.y),
            f64::from(self.hi.z) - f64::from(self.lo.z),
        ]
    }

    /// The centroid: the midpoint of each side, rounded to `f32`. It never overflows.
    pub fn centre(&self) -> Vec3 {
        let middle = |lo: f32, hi: f32| ((f64::from(lo) + f64::from(hi)) * 0.5) as f32;
        Vec3::new(
            middle(self.lo.x, self.hi.x),
            middle(self.lo.y, self.hi.y),
            middle(self.lo.z, self.hi.z),
        )
    }

    /// The square of the length of the diagonal, in `f64`.
    pub fn diagonal_squared(&self) -> f64 {
        let [x, y, z] = self.extent();
        x * x + y * y + z * z
    }

    /// The square of the gap between two boxes; 0 where they touch or overlap.
    pub fn gap_squared(&self, other: &Self) -> f64 {
        // On an axis where the boxes are apart, the higher of the lower bounds lies above the lower of the upper ones.
        let (from, to) = (self.hi.min(other.hi), self.lo.max(other.lo));
        let gap = |from: f32, to: f32| {
            let gap = f64::from(to) - f64::from(from);
            if gap > 0.0 { gap } else { 0.0 }
        };
        let (x, y, z) = (gap(from.x, to.x), gap(from.y, to.y), gap(from.z, to.z));
        x * x + y * y + z * z
    }

    /// Tells whether `other` lies wholly inside; the empty box lies in every box.
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || self.union(*other) == *self
    }
}
