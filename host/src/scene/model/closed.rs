//! Closed meshes, and a ball inside them.
//!
//! Every ray that begins inside a closed mesh must hit it. An index that reports a miss for such a ray has a leak.

use std::collections::HashMap;
use std::f64::consts::TAU;

use arboleda::{Aabb, Triangle, Vec3};

use crate::scene::vector::Vector64;

/// Ball that no triangle of a closed mesh reaches into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// Centre of the ball and of the mesh's bounding box.
    pub centre: Vec3,
    /// Radius: more than 0, at most the distance of the closest triangle.
    pub radius: f32,
}

/// Tells whether a mesh is closed and wound consistently: whether triangles run along every edge exactly once in each
/// direction. Edges are compared by the bits of their ends.
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

/// Computes a ball around the centre of a closed mesh's bounding box. `None` if the mesh is not closed, or if the
/// centre is not inside, as in a ring.
pub fn inside(triangles: &[Triangle]) -> Option<Inside> {
    if triangles.is_empty() || !is_closed(triangles) {
        return None;
    }
    let bounds = triangles.iter().fold(Aabb::EMPTY, |all, triangle| all.union(triangle.bounds()));
    let centre = bounds.centre();
    let seen: f64 = triangles.iter().map(|triangle| solid_angle(triangle, centre)).sum();
    // Seen from inside, the mesh covers the whole sphere of directions, 4 pi = 2 TAU; seen from outside, the parts
    // cancel to 0.
    if seen.abs() < TAU {
        return None;
    }
    let point = Aabb::new(centre, centre);
    let gaps = triangles.iter().map(|triangle| triangle.bounds().gap_squared(&point));
    let radius = gaps.fold(f64::INFINITY, f64::min).sqrt() as f32;
    (radius > 0.0).then_some(Inside { centre, radius })
}

/// Computes the solid angle of a triangle seen from `eye`. It is positive from the triangle's back.
///
/// # Source
/// A. van Oosterom, J. Strackee, *The Solid Angle of a Plane Triangle*, 1983.
fn solid_angle(triangle: &Triangle, eye: Vec3) -> f64 {
    let eye = Vector64::from(eye);
    let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|corner| Vector64::from(corner) - eye);
    let [la, lb, lc] = [a, b, c].map(Vector64::length);
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * libm::atan2(a.dot(b.cross(c)), denominator)
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
