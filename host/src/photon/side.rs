//! Side of a triangle on which a ray hits it.

use arboleda::{Ray, Triangle, Vec3};
use robust::{Coord3D, orient3d};

use crate::vector::Vector64;

/// Side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Side from which the corners are seen counter-clockwise. The normal points to it.
    Front,
    /// Side from which the corners are seen clockwise.
    Back,
}

impl Side {
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

fn exact(point: Vec3) -> Coord3D<f64> {
    Coord3D { x: point.x.into(), y: point.y.into(), z: point.z.into() }
}

fn leaves_towards_front(triangle: &Triangle, direction: Vec3) -> bool {
    let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
    (b - a).cross(c - a).dot(Vector64::from(direction)) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
