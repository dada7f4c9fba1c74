//! Vectors of `f64`, as arrays. Sums go from left to right, so that all targets agree to the bit.

use glam::Vec3;

pub(crate) type Vector64 = [f64; 3];

#[inline]
pub(crate) fn widened(v: Vec3) -> Vector64 {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

#[inline]
pub(crate) fn difference(p: Vector64, q: Vector64) -> Vector64 {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline]
pub(crate) fn cross(p: Vector64, q: Vector64) -> Vector64 {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

#[inline]
pub(crate) fn dot(p: Vector64, q: Vector64) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The largest absolute value of a component.
#[inline]
pub(crate) fn max_abs(v: Vector64) -> f64 {
    larger(v[0].abs(), larger(v[1].abs(), v[2].abs()))
}
