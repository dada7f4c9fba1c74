//! Whether a mesh is closed, and a place inside it.
//!
//! From inside a closed mesh every ray must hit something: what does not is a leak of whoever says so.

use std::collections::HashMap;
use std::f64::consts::TAU;

use arboleda::{Aabb, Triangle, Vec3};

/// A ball that no triangle of a closed mesh reaches into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// Its middle: that of the mesh's bounding box.
    pub centre: Vec3,
    /// At most the distance of the closest triangle; more than 0.
    pub radius: f32,
}

/// Tells whether every edge, by the bits of its ends, is run along once each way: a surface without
/// border, wound alike everywhere.
pub fn is_closed(triangles: &[Triangle]) -> bool {
    let bits = |point: Vec3| point.to_array().map(|x| (x + 0.0).to_bits());
    let mut edges: HashMap<_, u32> = HashMap::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(bits);
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    edges.iter().all(|(&(a, b), &times)| times == 1 && edges.get(&(b, a)) == Some(&1))
}

/// A ball around the middle of a closed mesh; `None` if the mesh is not closed or its middle is not
/// inside, as with a ring.
pub fn inside(triangles: &[Triangle]) -> Option<Inside> {
    if triangles.is_empty() || !is_closed(triangles) {
        return None;
    }
    let bounds = triangles.iter().fold(Aabb::EMPTY, |all, triangle| all.union(triangle.bounds()));
    let centre = bounds.centre();
    let seen: f64 = triangles.iter().map(|triangle| solid_angle(triangle, centre)).sum();
    // The whole sphere of directions once, or 4 pi = 2 TAU; nothing from outside.
    if seen.abs() < TAU {
        return None;
    }
    let point = Aabb::new(centre, centre);
    let gaps = triangles.iter().map(|triangle| triangle.bounds().gap_squared(&point));
    let radius = gaps.fold(f64::INFINITY, f64::min).sqrt() as f32;
    (radius > 0.0).then_some(Inside { centre, radius })
}

/// The solid angle of a triangle seen from `eye`, positive from behind.
///
/// # Source
/// A. van Oosterom, J. Strackee, *The Solid Angle of a Plane Triangle*, 1983.
fn solid_angle(triangle: &Triangle, eye: Vec3) -> f64 {
    let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|corner| {
        let from = |axis: usize| f64::from(corner[axis]) - f64::from(eye[axis]);
        [from(0), from(1), from(2)]
    });
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    let [la, lb, lc] = [a, b, c].map(|corner| dot(corner, corner).sqrt());
    let denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * libm::atan2(dot(a, cross), denominator)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{builtin, shapes};

    #[test]
    fn a_ball_fits_in_a_ball() {
        let centre = Vec3::new(3.0, -2.0, 10.0);
        let ball = shapes::sphere_at(centre, 2.0, 3);
        let inside = inside(&ball).unwrap();
        assert!((inside.centre - centre).length() < 1e-5);
        assert!((1.7..=2.0).contains(&inside.radius), "{}", inside.radius);
    }

    #[test]
    fn what_is_open_or_empty_in_the_middle_has_no_inside() {
        let mut open = shapes::closed_sphere(2);
        open.pop();
        assert_eq!(inside(&open), None);
        assert_eq!(inside(&[]), None);
        // Two boxes side by side are closed, and their middle is outside.
        let mut boxes = shapes::cube(Vec3::ZERO, 1.0);
        boxes.extend(shapes::cube(Vec3::X * 5.0, 1.0));
        assert!(is_closed(&boxes));
        assert_eq!(inside(&boxes), None);
        assert_eq!(inside(&builtin::require("fig3").unwrap().triangles), None);
    }
}
