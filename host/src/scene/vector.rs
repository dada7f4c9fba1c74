//! Vectors of three `f64`, for computations in which `f32` is too coarse: points on triangles, normals, frames.
//!
//! Every operation is the plain sum of products from left to right, without fused multiply-adds, so the bits are the
//! same on every target.

use std::ops::{Add, Div, Mul, Neg, Sub};

use arboleda::{Triangle, Vec3};

/// Three coordinates in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vector64 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

impl Vector64 {
    pub const ZERO: Self = Self::new(0.0, 0.0, 0.0);

    #[inline]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// Computes the normal of a triangle, towards the side from which its corners are seen counter-clockwise. Its
    /// length is twice the area.
    #[inline]
    pub fn normal_of(triangle: &Triangle) -> Self {
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(Self::from);
        (b - a).cross(c - a)
    }

    #[inline]
    pub fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }

    /// Rounds each coordinate to the nearest `f32`.
    #[inline]
    pub fn rounded(self) -> Vec3 {
        Vec3::new(self.x as f32, self.y as f32, self.z as f32)
    }

    #[inline]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    #[inline]
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Returns the largest absolute value of a coordinate. NaN in a coordinate gives an arbitrary value.
    #[inline]
    pub fn largest(self) -> f64 {
        greater(greater(self.x.abs(), self.y.abs()), self.z.abs())
    }
}

/// Computes the area of a triangle.
pub(crate) fn area_of(triangle: &Triangle) -> f64 {
    0.5 * Vector64::normal_of(triangle).length()
}

/// Returns the greater of two numbers: one instruction, where `f64::max` has to look for NaN. If either is NaN, the
/// second one.
#[inline]
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl From<Vec3> for Vector64 {
    #[inline]
    fn from(v: Vec3) -> Self {
        Self { x: f64::from(v.x), y: f64::from(v.y), z: f64::from(v.z) }
    }
}

impl From<[f64; 3]> for Vector64 {
    #[inline]
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl Add for Vector64 {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Vector64 {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul<f64> for Vector64 {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

impl Div<f64> for Vector64 {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        Self { x: self.x / divisor, y: self.y / divisor, z: self.z / divisor }
    }
}

impl Neg for Vector64 {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
