//! Rays, which are checked once when they are made, so that no query checks them again.

use core::fmt;

use bytemuck::NoUninit;
use glam::Vec3;

/// Ray: the points `origin + t * direction` with `t_min <= t <= t_max`.
///
/// The direction need not have unit length; `t` is counted in lengths of it. A ray is valid by construction: finite
/// origin, finite and non-zero direction, no NaN, a non-empty interval, and no negative zero.
///
/// Layout: 32 bytes, aligned to 4: origin, direction, `t_min`, `t_max`.
#[derive(Clone, Copy, Debug, PartialEq, NoUninit)]
#[repr(C)]
pub struct Ray {
    origin: Vec3,
    direction: Vec3,
    t_min: f32,
    t_max: f32,
}

impl Ray {
    /// Makes a ray over `0 <= t <= +inf`.
    ///
    /// # Errors
    /// The errors of [`Ray::with_interval`] about the origin and the direction.
    ///
    /// # Examples
    /// ```
    /// use arboleda::{Ray, RayError, Vec3};
    /// assert!(Ray::new(Vec3::ZERO, Vec3::Z).is_ok());
    /// assert_eq!(Ray::new(Vec3::ZERO, Vec3::ZERO), Err(RayError::ZeroDirection));
    /// ```
    pub fn new(origin: Vec3, direction: Vec3) -> Result<Self, RayError> {
        Self::with_interval(origin, direction, 0.0, f32::INFINITY)
    }

    /// Makes a ray over `t_min <= t <= t_max`; either bound may be infinite.
    ///
    /// # Errors
    /// The first of [`RayError`] that applies, in the order of its variants.
    pub fn with_interval(
        origin: Vec3,
        direction: Vec3,
        t_min: f32,
        t_max: f32,
    ) -> Result<Self, RayError> {
        if !origin.is_finite() {
            return Err(RayError::NonFiniteOrigin);
        }
        if !direction.is_finite() {
            return Err(RayError::NonFiniteDirection);
        }
        if direction == Vec3::ZERO {
            return Err(RayError::ZeroDirection);
        }
        if t_min.is_nan() || t_max.is_nan() {
            return Err(RayError::NanInterval);
        }
        if t_min > t_max {
            return Err(RayError::EmptyInterval);
        }
        // Adding +0.0 turns -0.0 into +0.0 and changes nothing else.
        Ok(Self {
            origin: origin + Vec3::ZERO,
            direction: direction + Vec3::ZERO,
            t_min: t_min + 0.0,
            t_max: t_max + 0.0,
        })
    }

    /// The point at which `t` is 0.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The direction, of any finite length above 0; `t` is counted in lengths of it.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// The smallest `t` that counts as a hit.
    pub fn t_min(&self) -> f32 {
        self.t_min
    }

    /// The largest `t` that counts as a hit.
    pub fn t_max(&self) -> f32 {
        self.t_max
    }

    /// Computes `origin + t * direction`, rounded after each operation.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Reason why numbers are not a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RayError {
    /// A coordinate of the origin is infinite or NaN.
    NonFiniteOrigin,
    /// A coordinate of the direction is infinite or NaN.
    NonFiniteDirection,
    /// All coordinates of the direction are zero.
    ZeroDirection,
    /// `t_min` or `t_max` is NaN.
    NanInterval,
    /// `t_min` is greater than `t_max`.
    EmptyInterval,
}

impl fmt::Display for RayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NonFiniteOrigin => "the ray's origin is infinite or NaN",
            Self::NonFiniteDirection => "the ray's direction is infinite or NaN",
            Self::ZeroDirection => "the ray's direction is zero",
            Self::NanInterval => "t_min or t_max is NaN",
            Self::EmptyInterval => "t_min is greater than t_max",
        })
    }
}

impl core::error::Error for RayError {}

#[cfg(test)]
mod tests {
    use core::mem::offset_of;

    use super::*;

    #[test]
    fn fields_lie_where_the_documentation_says() {
        assert_eq!((offset_of!(Ray, origin), offset_of!(Ray, direction)), (0, 12));
        assert_eq!((offset_of!(Ray, t_min), offset_of!(Ray, t_max)), (24, 28));
        assert_eq!((size_of::<Ray>(), align_of::<Ray>()), (32, 4));
    }
}
