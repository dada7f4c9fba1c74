//! Origin of a photon's next ray after it hit a triangle.
//!
//! The problem: the hit point is not representable in `f32`. If the rounded point lies behind the triangle, the photon
//! leaves a closed room. If it lies in front but too near, the photon may hit the same triangle again.
//!
//! ```text
//!          o  origin: lifted, then rounded          margin = 16 heights
//!          |  height = a few ulps                  |<----->|
//!   -------x---------------------------------------x-------+ edge, where a neighbour begins
//!          hit point from u, v                     points nearer to an edge are moved in
//! ```
//!
//! # Proof: the photon never hits the triangle it left
//! Let `m` be the largest coordinate of the point and `s` that of the corners.
//!
//! - The point is `A + u (B - A) + v (C - A)`. Rounding of `u` and `v` moves the point inside the triangle's plane.
//! - Computed in `f64`, the point is off the plane by less than `2^-49 s`.
//! - Rounding to `f32` moves each coordinate by at most `2^-24` of itself, so the point by at most `sqrt(3) 2^-24 m`,
//!   or `0.44 * 2^-22 m`.
//! - The computed normal deviates from the exact one by at most 30 degrees in the worst case that is accepted: its
//!   error is `14 r E^2` where the kernel's bound requires a length of `27 r E^2`, with `r = 2^-53` and `E` the largest
//!   edge.
//! - With `height = 2^-22 m + 2^-45 s + 2^-140`, the rounded point therefore stays in front of the plane by more than
//!   `0.86 - 0.44 - 0.02 = 0.4` heights.
//! - A direction is accepted only if it certainly leads away from the plane, by the kernel's bound on the error of
//!   `d . (e1 x e2)`. The same bound decides from which side the photon came.
//! - For a point strictly in front and a direction strictly away, the exact parameter on the plane is negative: at most
//!   `-2^-142`, which is not rounded to zero in `f32`.
//! - Cases in doubt are refused. In doubt are rays within about 10^-14 of the plane, and triangles whose corners are
//!   collinear to the precision of `f64`.
//!
//! # Proof: the photon does not slip through a neighbour
//! - The origin is at most 1.5 heights above the triangle and at least 15 heights inside each edge.
//! - So it is on the right side of every triangle that joins this one in an edge or corner at an angle, measured on the
//!   photon's side, of more than atan(1.5 / 15), or 5.8 degrees rounded up.
//! - In a triangle too small for the margin, the origin is the incentre, the point farthest from the edges.
//!
//! # Limits
//! A photon may still pass through a surface in these cases, which generic rays do not meet:
//!
//! - A surface comes within a few ulps of the hit point without ending there: the inside of a crease below 6 degrees,
//!   within 16 heights of its bottom; a triangle a few ulps wide; two surfaces that cross or coincide.
//! - A ray meets the silhouette edge of a body *exactly*, which hits both triangles of the edge. If the triangle with
//!   the lower id faces away from the ray, the photon continues inside the body.
//!
//! # Source
//! C. Waechter, N. Binder, *A Fast and Robust Method for Avoiding Self-Intersection*, 2019, for the point from
//! barycentric coordinates and the offset in ulps. Their offset is tuned; this one is derived. The margin is ours.

use arboleda::{Hit, Ray, Triangle, Vec3};

use crate::scene::vector::{Vector64, greater};

/// Term of [`height`] for rounding a point to `f32`: 2^-22, 2.3 times the largest displacement.
const ROUNDING: f64 = 1.0 / (1 << 22) as f64;
/// Term of [`height`] for computing a point in `f64`: 2^-45, 16 times the largest error.
const COMPUTING: f64 = 1.0 / (1_u64 << 45) as f64;
/// Term of [`height`] for sub-normal numbers: 2^-140, far above half of their step, 2^-150.
const SUBNORMAL: f64 = 1.0 / (1_u128 << 70) as f64 / (1_u128 << 70) as f64;
/// Least distance of an origin from the edges, in heights.
///
/// - 16 moves photons near an edge by 4 mm on coordinates of 1000, and handles creases from 5.8 degrees.
/// - 64 would handle creases from 1.4 degrees, but would move photons by 15 mm.
pub(in crate::photon) const MARGIN: f64 = 16.0;

/// Computes the height of an origin above the triangle's plane. The point's coordinates are at most `largest`, those of
/// the corners at most `scale`.
#[inline]
pub(crate) fn height(largest: f64, scale: f64) -> f64 {
    ROUNDING * largest + COMPUTING * scale + SUBNORMAL
}

/// Returns the `f32` point nearest to the point `height` above `point`.
#[inline]
pub(crate) fn lifted(point: Vector64, normal: Vector64, height: f64) -> Vec3 {
    (point + normal * height).rounded()
}

/// Computes the error bound of `d . (e1 x e2)`, to be multiplied by the largest component of `d`: `48 r E^2`, as in the
/// core's kernel.
#[inline(always)]
pub(in crate::photon) fn doubt(e1: Vector64, e2: Vector64) -> f64 {
    let extent = greater(e1.largest(), e2.largest());
    48.0 * (f64::EPSILON / 2.0) * extent * extent
}

/// Triangle seen from the side from which a photon came.
///
/// Nothing here branches, so that the compiler can compute several at once.
#[derive(Clone, Copy, Debug)]
struct SeenTriangle {
    a: Vector64,
    e1: Vector64,
    e2: Vector64,
    /// Lengths of the edges opposite to the corners.
    edges: [f64; 3],
    /// Largest coordinate of the corners.
    scale: f64,
    /// Normal towards the side from which the photon came: `e1 x e2` or its opposite.
    normal: Vector64,
    unit_normal: Vector64,
    length: f64,
    error: f64,
    /// False if the side is in doubt; then the normals are arbitrary.
    is_certain: bool,
}

impl SeenTriangle {
    #[inline(always)]
    fn new([a, b, c]: [Vector64; 3], incoming: Vector64) -> Self {
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let error = doubt(e1, e2);
        let along = incoming.dot(normal);
        let doubt = error * incoming.largest();
        let is_front = along < -doubt;
        // Both comparisons are false for NaN, which is refused.
        let is_certain = is_front | (along > doubt);
        let normal = if is_front { normal } else { -normal };
        // Edges are multiples of 2^-149 and the normal is not 0, so the square of its length cannot underflow.
        let length = normal.length();
        let unit_normal = normal / length;
        let edges = [(c - b).length(), e2.length(), e1.length()];
        let scale = greater(greater(a.largest(), b.largest()), c.largest());
        Self { a, e1, e2, edges, scale, normal, unit_normal, length, error, is_certain }
    }

    #[inline(always)]
    fn point(&self, u: f64, v: f64) -> Vector64 {
        self.a + self.e1 * u + self.e2 * v
    }

    /// Computes the least weights that keep a point off the edges. At weight 1 the distance from the opposite edge is
    /// length / edge.
    #[inline(always)]
    fn least_weights(&self, lift: f64) -> [f64; 3] {
        self.edges.map(|edge| edge * (MARGIN * lift / self.length))
    }

    #[inline(always)]
    fn is_near_an_edge(&self, u: f64, v: f64, lift: f64) -> bool {
        let least = self.least_weights(lift);
        (1.0 - u - v < least[0]) | (u < least[1]) | (v < least[2])
    }

    /// Moves a point near an edge in, as if the triangle shrank about its incentre. The point may move to larger
    /// coordinates, so the margin is that of the largest possible coordinates.
    fn moved_in(&self, u: f64, v: f64) -> Vector64 {
        let least = self.least_weights(height(self.scale, self.scale));
        let sum = least[0] + least[1] + least[2];
        let (kept, share) = if sum < 1.0 { (1.0 - sum, 1.0) } else { (0.0, 1.0 / sum) };
        self.point(u * kept + least[1] * share, v * kept + least[2] * share)
    }

    #[inline(always)]
    fn lift(&self, point: Vector64) -> f64 {
        height(point.largest(), self.scale)
    }
}

/// Point of departure of a photon from a triangle, on the side from which it came.
#[derive(Clone, Copy, Debug)]
pub(in crate::photon) struct Departure {
    origin: Vec3,
    /// Normal towards the side from which the photon came: `e1 x e2` or its opposite.
    normal: Vector64,
    unit_normal: Vector64,
    /// The triangle's [`doubt`].
    error: f64,
}

impl Departure {
    /// Computes the departure after a hit of a ray with direction `incoming`; `None` if the side is in doubt.
    pub fn new(triangle: &Triangle, hit: &Hit, incoming: Vec3) -> Option<Self> {
        let corners = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
        let facing = SeenTriangle::new(corners, incoming.into());
        if !facing.is_certain {
            return None;
        }
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        let mut point = facing.point(u, v);
        let mut lift = facing.lift(point);
        if facing.is_near_an_edge(u, v, lift) {
            point = facing.moved_in(u, v);
            lift = facing.lift(point);
        }
        Some(Self::at(&facing, point, lift))
    }

    /// Computes the same departure without a branch. False if it is not the same, because the side is in doubt or the
    /// point is near an edge.
    #[inline(always)]
    pub fn usual(corners: [Vector64; 3], u: f64, v: f64, incoming: Vector64) -> (Self, bool) {
        let facing = SeenTriangle::new(corners, incoming);
        let point = facing.point(u, v);
        let lift = facing.lift(point);
        let is_usual = facing.is_certain & !facing.is_near_an_edge(u, v, lift);
        (Self::at(&facing, point, lift), is_usual)
    }

    #[inline(always)]
    fn at(facing: &SeenTriangle, point: Vector64, lift: f64) -> Self {
        let SeenTriangle { normal, unit_normal, error, .. } = *facing;
        Self { origin: lifted(point, unit_normal, lift), normal, unit_normal, error }
    }

    /// Returns the unit normal on the side from which the photon came.
    #[inline]
    pub fn unit_normal(&self) -> Vector64 {
        self.unit_normal
    }

    /// Returns the point of departure.
    #[inline]
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Tells whether a direction certainly leads away from the plane.
    #[inline(always)]
    pub fn leads_away(&self, direction: Vec3) -> bool {
        let along = Vector64::from(direction);
        along.dot(self.normal) > self.error * along.largest()
    }

    /// Makes the ray from the point of departure; `None` if it does not certainly leave the plane, or is not a valid
    /// ray.
    pub fn ray(&self, direction: Vec3) -> Option<Ray> {
        if self.leads_away(direction) { Ray::new(self.origin, direction).ok() } else { None }
    }
}

#[cfg(test)]
mod tests {
    use arboleda::{TriangleId, intersect};

    use super::super::hemisphere::cosine_direction;
    use super::*;
    use crate::photon::random::PhotonRandom;

    fn hit_at(u: f32, v: f32) -> Hit {
        Hit { triangle: TriangleId(0), t: 1.0, u, v }
    }

    /// Draws weights inside the triangle, close to an edge, on an edge, or at a corner.
    fn weights(random: &mut PhotonRandom) -> (f32, f32) {
        let near_zero = |random: &mut PhotonRandom| match random.bits() % 4 {
            0 => 0.0,
            1 => random.uniform() * 1e-7,
            _ => random.uniform(),
        };
        let (u, v) = (near_zero(random), near_zero(random));
        // Weights outside the triangle are moved to the third edge.
        if u + v > 1.0 { (u, 1.0 - u) } else { (u, v) }
    }

    #[test]
    fn a_photon_never_hits_the_triangle_it_left() {
        let mut random = PhotonRandom::new(11, 0);
        let mut refused = 0;
        let mut count = 0;
        for size in [1e-38_f32, 1e-20, 1e-3, 1.0, 1e5, 1e18, 1e37] {
            for distance in [0.0_f32, 1.0, 1e3, 1e6] {
                for _ in 0..2000 {
                    let mut vector =
                        || Vec3::new(random.uniform(), random.uniform(), random.uniform()) - 0.5;
                    let centre = vector() * (size * distance).min(1e38);
                    let corners = [(); 3].map(|()| centre + vector() * size);
                    let triangle = Triangle::new(corners[0], corners[1], corners[2]);
                    let incoming = vector();
                    let (u, v) = weights(&mut random);
                    count += 1;
                    let departure = Departure::new(&triangle, &hit_at(u, v), incoming);
                    let ray = departure.and_then(|departure| {
                        let n = departure.unit_normal();
                        assert!(n.dot(incoming.into()) < 0.0);
                        departure.ray(cosine_direction(n, &mut random).rounded())
                    });
                    let Some(ray) = ray else {
                        refused += 1;
                        continue;
                    };
                    assert_eq!(intersect(&ray, &triangle), None, "{ray:?} {triangle:?}");
                }
            }
        }
        // At a distance of 1e6 sizes, corners are a few ulps apart and often collinear, which is refused.
        assert!(refused * 10 < count, "{refused} of {count}");
    }

    #[test]
    fn a_photon_stays_inside_a_tetrahedron_even_from_its_edges_and_corners() {
        let mut random = PhotonRandom::new(12, 0);
        let mut count = 0;
        for distance in [0.0_f32, 1.0, 30.0, 1000.0] {
            for _ in 0..3000 {
                let mut vector =
                    || Vec3::new(random.uniform(), random.uniform(), random.uniform()) - 0.5;
                let centre = vector() * distance;
                let corners = [(); 4].map(|()| centre + vector());
                let wide = corners.map(Vector64::from);
                let middle = (wide[0] + wide[1] + wide[2] + wide[3]) * 0.25;
                let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
                // Unit normals that point inwards.
                let inwards = faces.map(|[a, b, c]| {
                    let normal = (wide[b] - wide[a]).cross(wide[c] - wide[a]);
                    let normal = normal / normal.length();
                    if normal.dot(middle - wide[a]) > 0.0 { normal } else { -normal }
                });
                // Tetrahedra are skipped if they are too small for the margin, or have a crease below 8 degrees.
                let fits = faces.iter().all(|face| {
                    let [a, b, c] = face.map(|corner| wide[corner]);
                    let double_area = (b - a).cross(c - a).length();
                    let perimeter = (b - a).length() + (c - b).length() + (a - c).length();
                    let margin = MARGIN * height(f64::from(distance) + 1.0, 1.0);
                    double_area / perimeter > 1.1 * margin
                });
                let open = (0..4).all(|i| (0..i).all(|j| -inwards[i].dot(inwards[j]) < 0.99));
                if !(fits && open) {
                    continue;
                }
                for (face, inward) in faces.iter().zip(inwards) {
                    let [a, b, c] = face.map(|corner| corners[corner]);
                    let (u, v) = weights(&mut random);
                    let incoming = (-inward).rounded();
                    let departure =
                        Departure::new(&Triangle::new(a, b, c), &hit_at(u, v), incoming).unwrap();
                    for (other, normal) in faces.iter().zip(inwards) {
                        let from_plane = Vector64::from(departure.origin) - wide[other[0]];
                        assert!(from_plane.dot(normal) > 0.0, "{corners:?} {face:?} {u} {v}");
                    }
                    count += 1;
                }
            }
        }
        assert!(count > 20_000, "{count}");
    }
}
