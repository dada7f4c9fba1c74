//! Division of polygons into triangles.
//!
//! ```text
//! 4---------3        The fan from corner 0 would cover the notch below corner 1 too,
//!  \   1   /         so ears are cut off instead:
//!   \ / \ /
//!    0   2           (4 0 1), (1 2 3), (1 3 4)
//! ```
//! # How it is done
//! 1. Projection: the polygon is projected along the largest component of its normal (Newell), such that it runs
//!    counter-clockwise.
//! 2. Fan: if the fan from the first corner covers the polygon exactly, the fan is the division. That is so for every
//!    convex polygon, and for every polygon that is wholly visible from its first corner.
//! 3. Ears: else, if the direction of the outline turns around once (`turning`), ears are cut off, one corner after the
//!    other (`ears`).
//! 4. Failure: a polygon without a division into ears crosses itself. The fan is returned, marked as
//!    [`PolygonDivision::Crossing`].
//!
//! # Invariants
//! - `n` corners give `n - 2` triangles; triangles without area are kept.
//! - Orientations are decided exactly (Shewchuk 1997, by the crate `robust`).
//! - They are decided on coordinates rounded to `f32`, those that rays meet. A polygon may be convex in the file and
//!   not convex after rounding; a fan of it would have overlapping triangles.
//!
//! # Source
//! G. H. Meisters, *Polygons have ears*, American Mathematical Monthly 82, 1975. M. Newell's normal: I. E.
//! Sutherland, R. F. Sproull, R. A. Schumacker, *A characterization of ten hidden-surface algorithms*, 1974.

mod blockers;
mod ears;
mod fan;
mod turning;

use arboleda::Vec3;
use robust::Coord;

use crate::scene::vector::Vector64;
use ears::Ears;

/// Corner in the plane of projection.
type Point = Coord<f64>;

/// Result of a division.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolygonDivision {
    /// The triangles cover each part of the polygon once.
    Covering,
    /// The polygon crosses itself, so the triangles are a fan from its first corner.
    Crossing,
}

/// Divider of polygons, which reuses its memory from polygon to polygon.
#[derive(Default)]
pub struct Divider {
    points: Vec<Point>,
    ears: Ears,
    triangles: Vec<[usize; 3]>,
}

impl Divider {
    /// Divides a polygon of three or more finite corners. Triangles are indices into `corners`, and have the polygon's
    /// orientation.
    ///
    /// Cost: linear in the corners if the fan covers the polygon; else about `n log n` to `n^1.5` for outlines of
    /// mechanical parts; never more than `WORK` steps for each corner.
    pub fn divide(&mut self, corners: &[Vec3]) -> (&[[usize; 3]], PolygonDivision) {
        self.triangles.clear();
        let division =
            if corners.len() == 3 { PolygonDivision::Covering } else { self.ears(corners) };
        if self.triangles.is_empty() {
            self.triangles.extend((2..corners.len()).map(|corner| [0, corner - 1, corner]));
        }
        (&self.triangles, division)
    }

    /// Fills `triangles` with ears, or leaves it empty if the division is the fan.
    fn ears(&mut self, corners: &[Vec3]) -> PolygonDivision {
        let Some(projection) = Projection::of(corners) else {
            // The areas sum to 0. Either all triangles are without area, or parts of opposite orientation cancel.
            let flat = (2..corners.len()).all(|corner| {
                let [a, b, c] = [0, corner - 1, corner].map(|at| Vector64::from(corners[at]));
                (b - a).cross(c - a) == Vector64::ZERO
            });
            return if flat { PolygonDivision::Covering } else { PolygonDivision::Crossing };
        };
        self.points.clear();
        self.points.extend(corners.iter().map(|&corner| projection.apply(corner)));
        if fan::covers(&self.points) {
            return PolygonDivision::Covering;
        }
        let winds_once = turning::number(&self.points).is_none_or(|turns| turns == 1);
        if winds_once && self.ears.cut(&self.points, &mut self.triangles) {
            return PolygonDivision::Covering;
        }
        self.triangles.clear();
        PolygonDivision::Crossing
    }
}

/// Projection to two axes, in the order in which the polygon runs counter-clockwise.
struct Projection([usize; 2]);

impl Projection {
    /// Chooses the axes for a polygon; `None` if its normal is zero.
    fn of(corners: &[Vec3]) -> Option<Self> {
        // Corners are taken relative to the first, so that a small polygon far from the origin keeps its digits.
        let first = Vector64::from(corners[0]);
        let (mut normal, mut before) = (Vector64::ZERO, Vector64::ZERO);
        for &corner in &corners[1..] {
            let here = Vector64::from(corner) - first;
            normal = normal + before.cross(here);
            before = here;
        }
        let normal = normal.to_array();
        let size = normal.map(f64::abs);
        let axis = if size[0] > size[1] && size[0] > size[2] {
            0
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        if normal[axis] > 0.0 {
            Some(Self([u, v]))
        } else {
            (normal[axis] < 0.0).then_some(Self([v, u]))
        }
    }

    fn apply(&self, corner: Vec3) -> Point {
        let corner = corner.to_array().map(f64::from);
        Coord { x: corner[self.0[0]], y: corner[self.0[1]] }
    }
}

/// Computes twice the signed area of a triangle. The sign is exact, positive for counter-clockwise.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    robust::orient2d(a, b, c)
}

#[cfg(test)]
mod tests;
