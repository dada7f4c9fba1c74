//! Oracle of the intersection of a line and a triangle, in exact integers.
//!
//! The core divides volumes. This oracle intersects the line with the triangle's plane, then computes the point's
//! weights in a coordinate plane on which the triangle's projection has an area:
//!
//! ```text
//! n = (B - A) x (C - A)     t = n . (A - o) / n . d     P = o + t d
//! u = area(P - A, C - A) / area(B - A, C - A)     v = area(B - A, P - A) / area(B - A, C - A)
//! ```
//! All coordinates are integers after a common shift; the direction has a shift of its own. `P` stays multiplied by
//! `n . d`, so the only divisions are the last ones, whose quotients are rounded.

use arboleda::{Intersection, Ray, Triangle};
use num_bigint::{BigInt, Sign};

use super::rounding::{aligned, nearest_f32};

type Vector = [BigInt; 3];

/// Computes the hit by its definition: the line meets the closed triangle in one point; `t`, `u`, `v` are the nearest
/// floats; `t` is finite and in the interval; `v` is lowered until `u + v <= 1`.
pub fn intersect(ray: &Ray, triangle: &Triangle) -> Option<Intersection> {
    let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|p| p.to_array());
    let o = ray.origin().to_array();
    let (integers, point_exponent) =
        aligned([a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2], o[0], o[1], o[2]]);
    let [ax, ay, az, bx, by, bz, cx, cy, cz, ox, oy, oz] = integers;
    let (a, b, c, o) = ([ax, ay, az], [bx, by, bz], [cx, cy, cz], [ox, oy, oz]);
    let (d, direction_exponent) = aligned(ray.direction().to_array());

    // 1. The intersection of line and plane.
    let (e1, e2) = (minus(&b, &a), minus(&c, &a));
    let normal = cross(&e1, &e2);
    let along = dot(&normal, &d);
    if along.sign() == Sign::NoSign {
        return None; // no area, or a ray along the plane
    }
    let distance = dot(&normal, &minus(&a, &o));

    // 2. The point: (P - A) (n . d).
    let from_a = minus(&o, &a);
    let axes = [0, 1, 2];
    let point: Vector = axes.map(|i| &from_a[i] * &along + &d[i] * &distance);

    // 3. The weights, projected along the first axis along which the triangle has an area.
    let axis = axes.into_iter().find(|&i| normal[i].sign() != Sign::NoSign)?;
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let area = |p: &Vector, q: &Vector| &p[i] * &q[j] - &p[j] * &q[i];
    let whole = &normal[axis] * &along;
    let (u, v) = (area(&point, &e2), area(&e1, &point));
    let w = &whole - &u - &v;
    let outside = |weight: &BigInt| weight.sign() != Sign::NoSign && weight.sign() != whole.sign();
    if outside(&u) || outside(&v) || outside(&w) {
        return None;
    }

    // 4. Rounding.
    let t = nearest_f32(&distance, &along, point_exponent - direction_exponent);
    if !(t.is_finite() && ray.t_min() <= t && t <= ray.t_max()) {
        return None;
    }
    let u = nearest_f32(&u, &whole, 0);
    let v = lowered(u, nearest_f32(&v, &whole, 0));
    Some(Intersection { t, u, v })
}

/// Computes the largest `f32` at most `v` with which `u + v <= 1`, for `u` and `v` in `0..=1`.
fn lowered(u: f32, v: f32) -> f32 {
    if weights_fit(u, v) {
        return v;
    }
    // Bisection over bits, which ascend as non-negative floats do; 0 fits, `v` does not.
    let (mut fits, mut exceeds) = (0_u32, v.to_bits());
    while exceeds - fits > 1 {
        let middle = u32::midpoint(fits, exceeds);
        if weights_fit(u, f32::from_bits(middle)) {
            fits = middle;
        } else {
            exceeds = middle;
        }
    }
    f32::from_bits(fits)
}

/// Tells whether `u + v <= 1`, without rounding the sum.
pub fn weights_fit(u: f32, v: f32) -> bool {
    let ([u, v, one], _) = aligned([u, v, 1.0]);
    u + v <= one
}

fn minus(p: &Vector, q: &Vector) -> Vector {
    [0, 1, 2].map(|i| &p[i] - &q[i])
}

fn dot(p: &Vector, q: &Vector) -> BigInt {
    &p[0] * &q[0] + &p[1] * &q[1] + &p[2] * &q[2]
}

fn cross(p: &Vector, q: &Vector) -> Vector {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use arboleda::Vec3;

    #[test]
    fn knows_a_corner_an_edge_and_what_lies_beside() {
        let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
        let at = |x: f32, y: f32| {
            let ray = Ray::new(Vec3::new(x, y, -2.0), Vec3::Z).expect("a valid ray");
            intersect(&ray, &triangle).map(|hit| (hit.t, hit.u, hit.v))
        };
        assert_eq!(at(1.0, 0.0), Some((2.0, 1.0, 0.0)));
        assert_eq!(at(0.5, 0.5), Some((2.0, 0.5, 0.5)));
        assert_eq!(at(0.5, 0.5_f32.next_up()), None);
        assert_eq!(at(-1e-40, 0.5), None);
    }

    #[test]
    fn lowers_a_weight_as_little_as_it_must() {
        let below_one = 1.0_f32.next_down();
        assert_eq!(lowered(0.5, 0.5), 0.5);
        assert_eq!(lowered(1e-40, 1.0), below_one);
        assert_eq!(lowered(1.0, 1e-9), 0.0);
    }
}
