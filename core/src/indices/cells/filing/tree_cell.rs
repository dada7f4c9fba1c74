//! Cells of a tree under construction: closed boxes. Their sides are numbers that `f32` holds, in `f64` for those who
//! calculate with them.

use glam::Vec4;

use crate::geometry::Aabb;
use crate::geometry::vector64::widened;
use crate::indices::cost::half_area;

/// Closed cell.
#[derive(Clone, Copy)]
pub struct Cell {
    pub lo: [f64; 3],
    pub hi: [f64; 3],
}

impl Cell {
    /// The midpoint of each side, at which octrees and BSP trees divide, rounded as [`midpoint`] is.
    pub fn midpoint(&self) -> [f64; 3] {
        let middle = |axis: usize| f64::from(midpoint(self.lo[axis] as f32, self.hi[axis] as f32));
        [middle(0), middle(1), middle(2)]
    }

    /// The cell that is the box itself.
    pub fn of(bounds: &Aabb) -> Self {
        Self { lo: widened(bounds.lo), hi: widened(bounds.hi) }
    }

    /// The parts below and above a plane.
    pub fn halves(&self, axis: usize, plane: f64) -> [Self; 2] {
        let (mut below, mut above) = (*self, *self);
        if let (Some(hi), Some(lo)) = (below.hi.get_mut(axis), above.lo.get_mut(axis)) {
            (*hi, *lo) = (plane, plane);
        }
        [below, above]
    }

    /// The part in an octant of some planes. On an axis without a plane, it is the whole.
    pub fn child(&self, planes: &[Option<f64>; 3], octant: u32) -> Self {
        let mut child = *self;
        for (axis, plane) in planes.iter().enumerate() {
            let Some(plane) = *plane else { continue };
            if octant >> axis & 1 == 0 {
                child.hi[axis] = plane;
            } else {
                child.lo[axis] = plane;
            }
        }
        child
    }

    /// Half the surface area of the part inside `bounds`.
    pub fn half_area_within(&self, bounds: &Aabb) -> f64 {
        let side = |axis: usize| {
            let [lo, hi] = bounds.along(axis).map(f64::from);
            let lo = if self.lo[axis] > lo { self.lo[axis] } else { lo };
            let hi = if self.hi[axis] < hi { self.hi[axis] } else { hi };
            if hi > lo { hi - lo } else { 0.0 }
        };
        half_area([side(0), side(1), side(2)])
    }
}

/// The midpoint of a side. Halves are added, because the sum of both ends may overflow.
fn midpoint(lo: f32, hi: f32) -> f32 {
    lo * 0.5 + hi * 0.5
}

/// The [midpoints](midpoint) of all sides at once.
#[inline]
pub fn midpoints(lo: Vec4, hi: Vec4) -> Vec4 {
    lo * 0.5 + hi * 0.5
}
