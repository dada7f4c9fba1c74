//! Pinhole camera: anywhere, or where it sees a whole scene from above one corner.

use arboleda::{Aabb, Ray, Vec3};

pub use crate::scene::UpAxis;

/// Pinhole camera: maps pixels to rays, and points to pixels.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    width: u32,
    height: u32,
    /// Half of the picture's width at distance 1.
    tangent: f32,
}

impl Camera {
    /// Places a camera that sees the box from a corner, such that it fills a picture of `width` times `height` pixels.
    pub fn looking_at(bounds: &Aabb, up: Vec3, width: u32, height: u32) -> Self {
        // Two axes orthogonal to `up`.
        let (side, depth) = if up == Vec3::Y { (Vec3::X, -Vec3::Z) } else { (Vec3::X, Vec3::Y) };
        let extent = (bounds.hi - bounds.lo).max(Vec3::splat(f32::MIN_POSITIVE));
        let centre = bounds.centre();
        // 1. The direction: along the shorter side, a little from the left and from above.
        let long = extent.dot(side.abs()) >= extent.dot(depth.abs());
        let toward = if long { depth * 0.85 + side * 0.38 } else { side * 0.85 + depth * 0.38 };
        let forward = (toward - up * 0.62).normalize();
        let right = forward.cross(up).normalize();
        let upward = right.cross(forward);
        let tangent = 0.36;
        // 2. The distance: the least at which all eight corners are in the picture, with a margin of 4%.
        let aspect = height as f32 / width as f32;
        let mut distance = 0.0_f32;
        for corner in corners(bounds) {
            let offset = corner - centre;
            let across = offset.dot(right).abs() / tangent;
            let along = offset.dot(upward).abs() / (tangent * aspect);
            distance = distance.max(across.max(along) * 1.04 - offset.dot(forward));
        }
        let eye = centre - forward * distance;
        Self { eye, right, up: upward, forward, width, height, tangent }
    }

    /// Says in numbers where the camera is and what it sees; two cameras of equal pictures say the same.
    pub fn described(&self) -> String {
        let Self { eye, right, up, forward, tangent, .. } = self;
        format!("at {eye} towards {forward}, up {up}, right {right}, tangent {tangent}")
    }

    /// Places a camera at `eye` that looks at a point. The picture's width is `field_of_view` degrees, between 0 and
    /// 180. `None` if the point is at the eye or straight above or below it, or a number is not finite.
    pub fn at(
        eye: Vec3,
        look_at: Vec3,
        up: Vec3,
        field_of_view: f32,
        (width, height): (u32, u32),
    ) -> Option<Self> {
        let forward = (look_at - eye).try_normalize()?;
        // Below 1e-6, rounding decides where `right` is.
        let right = forward.cross(up.try_normalize()?);
        let right = (right.length() > 1e-6).then(|| right.normalize())?;
        let tangent = libm::tanf(field_of_view.to_radians() * 0.5);
        let valid = eye.is_finite() && tangent > 0.0 && tangent.is_finite();
        valid.then(|| Self {
            eye,
            right,
            up: right.cross(forward),
            forward,
            width,
            height,
            tangent,
        })
    }

    /// Makes the ray through a point of the picture, in pixels from the upper left; `None` if the scene is too small or
    /// large for `f32` directions.
    pub fn ray(&self, x: f32, y: f32) -> Option<Ray> {
        let half = self.width as f32 * 0.5;
        let across = (x - half) / half * self.tangent;
        let along = (self.height as f32 * 0.5 - y) / half * self.tangent;
        Ray::new(self.eye, self.forward + self.right * across + self.up * along).ok()
    }

    /// Projects a point: returns x and y in pixels, and its distance along the line of sight; `None` behind the eye.
    pub fn project(&self, point: Vec3) -> Option<(f32, f32, f32)> {
        let offset = point - self.eye;
        let distance = offset.dot(self.forward);
        if distance <= 0.0 {
            return None;
        }
        let half = self.width as f32 * 0.5;
        let scale = half / (distance * self.tangent);
        let x = half + offset.dot(self.right) * scale;
        let y = self.height as f32 * 0.5 - offset.dot(self.up) * scale;
        Some((x, y, distance))
    }

    /// Returns the width and height of the picture in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Returns the direction of the line of sight, of unit length.
    pub fn forward(&self) -> Vec3 {
        self.forward
    }

    /// Returns the position of the eye.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }
}

/// Lists the corners of a box. Bit 0 of a corner's index selects the upper end in x, bit 1 in y, bit 2 in z.
pub(super) fn corners(bounds: &Aabb) -> [Vec3; 8] {
    std::array::from_fn(|at| {
        let pick =
            |axis: usize| if at >> axis & 1 == 0 { bounds.lo[axis] } else { bounds.hi[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    })
}
