//! Division of polygons into triangles.
//!
//! ```text
//! 3---------2        the fan from corner 0 covers what lies outside the notch,
//!  \  4    /         so corner 4 is joined to 2 first:
//!   \ / \ /
//!    0   1           ears: (2 3 4), then (4 0 1), ...
//! ```
//! # How it is done
//! 1. The polygon is projected along the largest component of its own normal (Newell), so that it
//!    runs counterclockwise.
//! 2. Where the fan from the first corner covers it, the fan is taken: always for convex polygons, and
//!    for others that are seen whole from that corner.
//! 3. Else, if its direction goes round once (`turning`), ears are cut off, one corner after the other
//!    (`ears`).
//! 4. A polygon without such a division crosses itself: it is fanned, and the caller is told.
//!
//! # Invariants
//! `n` corners give `n - 2` triangles, whatever they are: triangles without area are kept. All turns are
//! decided exactly (Shewchuk 1997, by the crate `robust`), on the coordinates that rays meet: rounded to
//! `f32`. A polygon that is convex in the file but not after rounding would else have triangles that
//! overlap.
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

use ears::Ears;

/// A corner in the plane of projection.
type Point = Coord<f64>;

/// Result of a division.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Division {
    /// The triangles cover the polygon, each part once.
    Covering,
    /// The polygon crosses itself, so the triangles are a fan from its first corner.
    Crossing,
}

/// Divides polygons; keeps its memory from one to the next.
#[derive(Default)]
pub struct Divider {
    points: Vec<Point>,
    ears: Ears,
    triangles: Vec<[usize; 3]>,
}

impl Divider {
    /// Divides a polygon of three or more corners, all finite. `triangles` names corners by their place.
    ///
    /// Triangles turn as the polygon does. Takes time linear in the corners where the fan covers the
    /// polygon, else about `n log n` to `n^1.5` for outlines of parts, and never more than `WORK` steps a
    /// corner.
    pub fn divide(&mut self, corners: &[Vec3]) -> (&[[usize; 3]], Division) {
        self.triangles.clear();
        let division = if corners.len() == 3 { Division::Covering } else { self.ears(corners) };
        if self.triangles.is_empty() {
            self.triangles.extend((2..corners.len()).map(|corner| [0, corner - 1, corner]));
        }
        (&self.triangles, division)
    }

    /// Fills `triangles`, or leaves them empty for a fan.
    fn ears(&mut self, corners: &[Vec3]) -> Division {
        let Some(projection) = Projection::of(corners) else {
            // No side is seen. Either nothing has an area, or one part makes up for the other.
            let flat = (2..corners.len()).all(|corner| {
                let [a, b, c] = [0, corner - 1, corner].map(|at| corners[at]);
                cross(difference(b, a), difference(c, a)) == [0.0; 3]
            });
            return if flat { Division::Covering } else { Division::Crossing };
        };
        self.points.clear();
        self.points.extend(corners.iter().map(|&corner| projection.apply(corner)));
        if fan::covers(&self.points) {
            return Division::Covering;
        }
        let winds_once = turning::number(&self.points).is_none_or(|turns| turns == 1);
        if winds_once && self.ears.cut(&self.points, &mut self.triangles) {
            return Division::Covering;
        }
        self.triangles.clear();
        Division::Crossing
    }
}

/// The two axes that stay, in the order in which the polygon runs counterclockwise.
struct Projection([usize; 2]);

impl Projection {
    /// None if the normal is zero.
    fn of(corners: &[Vec3]) -> Option<Self> {
        // Relative to the first corner, so that a small polygon far away keeps its digits.
        let mut normal = [0.0; 3];
        let mut before = [0.0; 3];
        for &corner in &corners[1..] {
            let here = difference(corner, corners[0]);
            for (sum, part) in normal.iter_mut().zip(cross(before, here)) {
                *sum += part;
            }
            before = here;
        }
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

fn difference(a: Vec3, b: Vec3) -> [f64; 3] {
    let (a, b) = (a.to_array(), b.to_array());
    [0, 1, 2].map(|axis| f64::from(a[axis]) - f64::from(b[axis]))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Twice the area of a triangle: its sign is exact, positive for counterclockwise.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    robust::orient2d(a, b, c)
}

#[cfg(test)]
mod tests;
