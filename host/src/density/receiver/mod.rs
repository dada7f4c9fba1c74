//! Receiver: a point and the side on which light falls on it.
//!
//! Photons are counted in the disc around it: only in its `visible` part, and weighted by a `kernel`.

mod kernel;
pub(super) mod visible;

use arboleda::{Hit, Ray, Triangle, Vec3};

use crate::photon::PhotonRandom;
use crate::photon::surface::hemisphere::cosine_direction;
use crate::photon::surface::offset::height;
use crate::scene::vector::Vector64;

pub use kernel::Kernel;
pub use visible::{Fan, VisiblePolygon};

/// Point with a unit normal towards the lit side. It need not lie on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    position: Vec3,
    normal: Vector64,
}

impl Receiver {
    /// Creates a receiver. The normal may have any length but 0. `None` if a coordinate is not finite or the normal
    /// is 0.
    pub fn new(position: Vec3, normal: Vec3) -> Option<Self> {
        let normal = Vector64::from(normal);
        let length = normal.length();
        // The comparison is false for NaN too.
        let valid = position.is_finite() && length > 0.0 && length.is_finite();
        valid.then(|| Self { position, normal: normal / length })
    }

    /// Creates the receiver at a hit of a ray: the hit point in `f32`, and the triangle's geometric normal on the side
    /// from which the ray comes. `None` if the triangle has no area.
    pub fn at_hit(triangle: &Triangle, hit: &Hit, direction: Vec3) -> Option<Self> {
        let normal = unit_normal(triangle)?;
        let towards = normal.dot(direction.into()) <= 0.0;
        let position = hit_point(triangle, hit);
        Some(Self { position, normal: if towards { normal } else { -normal } })
    }

    /// Returns the receiver at another point of its plane.
    #[must_use]
    pub fn moved_to(&self, position: Vec3) -> Self {
        Self { position, normal: self.normal }
    }

    /// Returns the bits of the normal, by which receivers in one plane can be brought together.
    pub fn normal_bits(&self) -> [u64; 3] {
        self.normal.to_array().map(f64::to_bits)
    }

    /// Tells whether two receivers face the same way.
    pub fn faces_as(&self, other: &Self) -> bool {
        self.normal == other.normal
    }

    /// Returns the position.
    pub fn position(&self) -> Vec3 {
        self.position
    }

    pub(super) fn point(&self) -> Vector64 {
        self.position.into()
    }

    pub(super) fn normal(&self) -> Vector64 {
        self.normal
    }

    /// Draws a ray from just above the point, with a cosine distribution around the normal. `None` if it is beyond the
    /// range of `f32`.
    pub(crate) fn ray_from(&self, random: &mut PhotonRandom) -> Option<Ray> {
        let origin = (self.point() + self.normal * self.slack(0.0)).rounded();
        Ray::new(origin, cosine_direction(self.normal, random).rounded()).ok()
    }

    /// Returns the distance from the plane up to which rounding may move points of the plane that are at most `reach`
    /// away: four of the heights by which photons are lifted from a surface.
    pub(super) fn slack(&self, reach: f64) -> f64 {
        let largest = self.point().largest() + reach;
        4.0 * height(largest, largest)
    }
}

/// Computes the unit normal of a triangle, towards the side from which its corners are seen counter-clockwise; `None`
/// without area.
pub(super) fn unit_normal(triangle: &Triangle) -> Option<Vector64> {
    let normal = Vector64::normal_of(triangle);
    let length = normal.length();
    (length > 0.0).then(|| normal / length)
}

/// Computes the `f32` point nearest to a hit, from its weights `u` and `v`. A point from `t` would lie off the triangle
/// if the ray begins far away.
#[inline]
pub(super) fn hit_point(triangle: &Triangle, hit: &Hit) -> Vec3 {
    let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
    (a + (b - a) * f64::from(hit.u) + (c - a) * f64::from(hit.v)).rounded()
}

/// Computes the squared distance of two points of `f32` coordinates, in `f64`. All estimators decide by this value.
#[inline]
pub(super) fn distance_squared(a: Vector64, b: Vector64) -> f64 {
    let offset = a - b;
    offset.dot(offset)
}
