//! Directions with a cosine distribution around a normal.
//!
//! The idea (Malley): a point uniform in the unit disc, lifted to the hemisphere above the disc, has a density in
//! proportion to the cosine. The point is drawn by rejection from the square, which needs no transcendental function.
//! In `f64` every step but the square root is exact:
//!
//! ```text
//! x, y = multiples of 2^-23 in -1..1;   s = x^2 + y^2 = multiple of 2^-46;   z = sqrt(1 - s)
//! ```
//!
//! Only `+ - * / sqrt` are used, so the bits are the same on every target.
//!
//! # Source
//! T. Duff, J. Burgess, P. Christensen, C. Hery, A. Kensler, M. Liani, R. Villemin, *Building an
//! Orthonormal Basis, Revisited*, 2017, for the frame.

use crate::photon::random::PhotonRandom;
use crate::scene::vector::Vector64;

/// Smallest cosine of a returned direction: 2^-20.
///
/// The caller rounds the direction to `f32`. That moves each coordinate by at most 2^-25, half an ulp below 1, and so
/// the direction by less than 2^-24. A direction with a cosine of 2^-20 therefore stays above the plane. Smaller
/// cosines have probability 2^-40.
const LEAST_COSINE: f64 = 1.0 / (1 << 20) as f64;

/// Most points tried by rejection, a bound for the loop. All fail with probability (1 - pi/4)^64 < 2^-141.
const MOST_ATTEMPTS: u32 = 64;

/// Draws a unit vector (up to rounding) with density cosine / pi around the unit vector `normal`.
///
/// Takes two draws for each point tried, 2.5 draws on average. Returns the normal if none of 64 points lies in the
/// disc.
#[inline]
pub(crate) fn cosine_direction(normal: Vector64, random: &mut PhotonRandom) -> Vector64 {
    later_direction(normal, random, 0)
}

/// Draws as [`cosine_direction`] does, after `tried` points that lie outside the disc.
#[inline]
pub(in crate::photon) fn later_direction(
    normal: Vector64,
    random: &mut PhotonRandom,
    tried: u32,
) -> Vector64 {
    for _ in tried..MOST_ATTEMPTS {
        let x = 2.0 * f64::from(random.uniform()) - 1.0;
        let y = 2.0 * f64::from(random.uniform()) - 1.0;
        if square_of(x, y) < 1.0 {
            return Frame::around(normal).lifted(x, y);
        }
    }
    normal
}

/// Computes the square of a point's distance from the middle of the disc.
#[inline(always)]
pub(in crate::photon) fn square_of(x: f64, y: f64) -> f64 {
    x * x + y * y
}

/// Orthonormal frame around a normal.
#[derive(Clone, Copy, Debug)]
pub(in crate::photon) struct Frame {
    tangent: Vector64,
    bitangent: Vector64,
    normal: Vector64,
}

impl Frame {
    /// Makes the frame of [`tangents`] around a unit vector.
    #[inline(always)]
    pub fn around(normal: Vector64) -> Self {
        let (tangent, bitangent) = tangents(normal);
        Self { tangent, bitangent, normal }
    }

    /// Lifts a point of the unit disc to the hemisphere.
    #[inline(always)]
    pub fn lifted(&self, x: f64, y: f64) -> Vector64 {
        let cosine = (1.0 - square_of(x, y)).sqrt();
        let cosine = if cosine < LEAST_COSINE { LEAST_COSINE } else { cosine };
        self.tangent * x + self.bitangent * y + self.normal * cosine
    }
}

/// Computes two unit vectors orthogonal to a unit vector and to each other (Duff et al., listing 3).
///
/// The divisor's absolute value is at least 1. The only branch is on the sign of z; -0.0 and 0.0 give different frames,
/// and both are orthonormal.
#[inline(always)]
pub(crate) fn tangents(normal: Vector64) -> (Vector64, Vector64) {
    let sign = 1.0_f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    (
        Vector64::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vector64::new(b, sign + normal.y * normal.y * a, -normal.y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Vector64 = Vector64::new(1.0, 0.0, 0.0);
    const Y: Vector64 = Vector64::new(0.0, 1.0, 0.0);
    const Z: Vector64 = Vector64::new(0.0, 0.0, 1.0);

    fn normals() -> Vec<Vector64> {
        let tiny = 1e-18;
        let mut normals = vec![
            X,
            -X,
            Y,
            -Y,
            Z,
            -Z,
            Vector64::new(tiny, -tiny, -1.0),
            Vector64::new(1.0, tiny, -0.0),
        ];
        let mut random = PhotonRandom::new(3, 0);
        for _ in 0..1000 {
            let [x, y, z] = [0; 3].map(|_| f64::from(random.uniform()) - 0.5);
            let v = Vector64::new(x, y, z);
            normals.push(v / v.length());
        }
        normals
    }

    #[test]
    fn frames_are_orthonormal() {
        for n in normals() {
            let (t, b) = tangents(n);
            for (value, expected) in [
                (t.dot(t), 1.0),
                (b.dot(b), 1.0),
                (t.dot(b), 0.0),
                (t.dot(n), 0.0),
                (b.dot(n), 0.0),
            ] {
                assert!((value - expected).abs() < 1e-14, "{n:?}: {value}");
            }
        }
    }

    #[test]
    fn every_direction_is_above_the_plane_even_in_f32() {
        for (photon, n) in normals().into_iter().enumerate() {
            let mut random = PhotonRandom::new(4, photon as u64);
            for _ in 0..100 {
                let direction = cosine_direction(n, &mut random);
                assert!((direction.dot(direction) - 1.0).abs() < 1e-11);
                assert!(Vector64::from(direction.rounded()).dot(n) > 0.0);
            }
        }
    }

    #[test]
    fn the_cosine_has_the_moments_of_its_distribution() {
        // Density 2c on 0..1: mean 2/3, variance 1/18; its square is uniform: mean 1/2, variance 1/12.
        let count = 200_000_u32;
        let (mut sum, mut squares, mut sideways) = (0.0, 0.0, Vector64::new(0.0, 0.0, 0.0));
        for photon in 0..count {
            let direction = cosine_direction(Z, &mut PhotonRandom::new(5, u64::from(photon)));
            sum += direction.z;
            squares += direction.z * direction.z;
            sideways = sideways + direction;
        }
        let count = f64::from(count);
        let sigma = 1.0 / count.sqrt();
        assert!((sum / count - 2.0 / 3.0).abs() < 4.0 * (1.0_f64 / 18.0).sqrt() * sigma);
        assert!((squares / count - 0.5).abs() < 4.0 * (1.0_f64 / 12.0).sqrt() * sigma);
        // x^2 + y^2 has mean 1/2, so x and y have variance 1/4 each.
        assert!((sideways.x / count).abs() < 4.0 * 0.5 * sigma);
        assert!((sideways.y / count).abs() < 4.0 * 0.5 * sigma);
    }
}
