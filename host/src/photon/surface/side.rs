//! Side of a triangle on which a ray hits it.

use arboleda::{Hit, Ray, Triangle, Vec3};
use robust::{Coord3D, orient3d};

use super::offset::doubt;
use crate::scene::vector::Vector64;

/// Side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Side from which the corners are seen counter-clockwise. The normal points to it.
    Front,
    /// Side from which the corners are seen clockwise.
    Back,
}

impl Side {
    /// Decides on which side a ray hits a triangle, as [`Side::met`] does for a ray that hits it.
    ///
    /// For `t` above 0, the ray hits the front if its direction and the normal have a negative dot product. The sign of
    /// `d . (e1 x e2)` is certain beyond the bound of the kernel. Other hits are decided exactly.
    #[inline]
    pub fn hit(triangle: &Triangle, ray: &Ray, hit: &Hit) -> Self {
        let corners = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
        Self::judged(Self::judge(corners, ray.direction().into()), triangle, ray, hit)
    }

    /// Judges by the direction alone: 0 for the front, 1 for the back, 2 in doubt. It has no branch, so that the
    /// compiler can judge several at once.
    #[inline(always)]
    pub(in crate::photon) fn judge([a, b, c]: [Vector64; 3], direction: Vector64) -> u64 {
        let (e1, e2) = (b - a, c - a);
        let along = direction.dot(e1.cross(e2));
        let doubt = doubt(e1, e2) * direction.largest();
        let not_front = if along > doubt { BACK } else { DOUBT };
        if along < -doubt { FRONT } else { not_front }
    }

    /// Decides by what [`Side::judge`] returned.
    #[inline(always)]
    pub(in crate::photon) fn judged(
        verdict: u64,
        triangle: &Triangle,
        ray: &Ray,
        hit: &Hit,
    ) -> Self {
        match verdict {
            FRONT if hit.t > 0.0 => Self::Front,
            BACK if hit.t > 0.0 => Self::Back,
            _ => Self::met(triangle, ray),
        }
    }

    /// Decides on which side a ray hits a triangle.
    ///
    /// The side is that of the plane on which the ray begins, decided exactly. For a ray that begins in the plane, the
    /// direction decides, in `f64`.
    ///
    /// # Source
    /// Shewchuk 1997, `orient3d`, in the crate `robust`. It is positive where the corners are seen clockwise.
    pub fn met(triangle: &Triangle, ray: &Ray) -> Self {
        let [a, b, c, origin] = [triangle.a, triangle.b, triangle.c, ray.origin()].map(exact);
        let volume = orient3d(a, b, c, origin);
        if volume < 0.0 || volume == 0.0 && !leaves_towards_front(triangle, ray.direction()) {
            Self::Front
        } else {
            Self::Back
        }
    }
}

const FRONT: u64 = 0;
const BACK: u64 = 1;
const DOUBT: u64 = 2;

fn exact(point: Vec3) -> Coord3D<f64> {
    Coord3D { x: point.x.into(), y: point.y.into(), z: point.z.into() }
}

fn leaves_towards_front(triangle: &Triangle, direction: Vec3) -> bool {
    Vector64::normal_of(triangle).dot(direction.into()) > 0.0
}

#[cfg(test)]
mod tests {
    use arboleda::{TriangleId, intersect};

    use super::*;
    use crate::photon::random::PhotonRandom;

    #[test]
    fn sides_are_told_apart_at_every_size() {
        for scale in [1e-44_f32, 1e-30, 1.0, 1e30, 3e38] {
            let triangle = Triangle::new(Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale);
            for (z, direction, side) in [
                (scale, -Vec3::Z, Side::Front),
                (-scale, Vec3::Z, Side::Back),
                (0.0, -Vec3::Z, Side::Front),
                (0.0, Vec3::Z, Side::Back),
            ] {
                let ray = Ray::new(Vec3::new(0.0, 0.0, z), direction).unwrap();
                assert_eq!(Side::met(&triangle, &ray), side, "{scale} {z} {direction}");
            }
        }
    }

    #[test]
    fn the_nearest_origin_to_a_tilted_plane_is_decided() {
        // 2^24 + 1 is not an f32. The origin lies off the plane x + y + z = 2^24 by one part in 2^24.
        let far = 16_777_216.0_f32;
        let triangle = Triangle::new(Vec3::X * far, Vec3::Y * far, Vec3::Z * far);
        for (x, side) in [(1.0_f32.next_up(), Side::Front), (1.0_f32.next_down(), Side::Back)] {
            let origin = Vec3::new(x, far - 2.0, 1.0);
            let ray = Ray::new(origin, Vec3::new(-1.0, -1.0, -1.0)).unwrap();
            assert_eq!(Side::met(&triangle, &ray), side, "{x}");
        }
    }

    #[test]
    fn a_hit_is_on_the_side_from_which_it_is_met() {
        let mut random = PhotonRandom::new(21, 0);
        let (mut fronts, mut hits) = (0, 0);
        for size in [1e-38_f32, 1e-6, 1.0, 1e18] {
            // The thinnest triangles are a few ulps wide.
            for thinness in [1.0_f32, 1e-4, 1e-7] {
                for _ in 0..2000 {
                    let mut vector =
                        || Vec3::new(random.uniform(), random.uniform(), random.uniform()) - 0.5;
                    let (a, along, across) = (vector(), vector(), vector());
                    let corners = [a, a + along, a + along * 0.5 + across * thinness];
                    let origin = vector() * 2.0;
                    let target = (corners[0] + corners[1] + corners[2]) / 3.0;
                    let [a, b, c] = corners.map(|corner| corner * size);
                    let triangle = Triangle::new(a, b, c);
                    let Ok(ray) = Ray::new(origin * size, target - origin) else { continue };
                    let Some(met) = intersect(&ray, &triangle) else { continue };
                    let hit = Hit { triangle: TriangleId(0), t: met.t, u: met.u, v: met.v };
                    let side = Side::met(&triangle, &ray);
                    assert_eq!(Side::hit(&triangle, &ray, &hit), side, "{triangle:?} {ray:?}");
                    hits += 1;
                    fronts += u32::from(side == Side::Front);
                }
            }
        }
        assert!(hits > 10_000 && fronts > hits / 3 && fronts < hits / 3 * 2, "{fronts} of {hits}");
    }

    #[test]
    fn a_hit_at_the_origin_of_its_ray_is_decided_as_it_is_met() {
        let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
        for direction in [Vec3::Z, -Vec3::Z] {
            let ray = Ray::new(Vec3::splat(0.25) * Vec3::new(1.0, 1.0, 0.0), direction).unwrap();
            let met = intersect(&ray, &triangle).unwrap();
            let hit = Hit { triangle: TriangleId(0), t: met.t, u: met.u, v: met.v };
            assert_eq!(hit.t, 0.0);
            assert_eq!(Side::hit(&triangle, &ray, &hit), Side::met(&triangle, &ray));
        }
    }
}
