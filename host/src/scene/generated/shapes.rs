//! Simple surfaces: floors, boxes, spheres.
//!
//! Neighbouring triangles share their corners bit for bit, so a closed surface has no cracks. Triangles of closed
//! surfaces are wound counter-clockwise, seen from outside.

use std::collections::HashMap;

use arboleda::{Aabb, Triangle, Vec3};

use crate::scene::vector::Vector64;

/// Makes a horizontal square around `centre`, facing up, of `divisions x divisions` quads of two triangles each. With 0
/// divisions there are no triangles.
pub fn floor(centre: Vec3, side: f32, divisions: u32) -> Vec<Triangle> {
    let half = side * 0.5;
    let (lo, hi) = (centre - Vec3::new(half, half, 0.0), centre + Vec3::new(half, half, 0.0));
    let mut triangles = Vec::new();
    patch(
        [lo, Vec3::new(hi.x, lo.y, lo.z), hi, Vec3::new(lo.x, hi.y, lo.z)],
        divisions,
        divisions,
        |triangle| {
            triangles.push(triangle);
        },
    );
    triangles
}

/// Makes a cube around `centre`: 12 triangles.
pub fn cube(centre: Vec3, side: f32) -> Vec<Triangle> {
    let half = Vec3::splat(side * 0.5);
    cuboid(Aabb::new(centre - half, centre + half), 1)
}

/// Makes the surface of a box, each face of `divisions x divisions` quads: `12 divisions^2` triangles.
pub fn cuboid(bounds: Aabb, divisions: u32) -> Vec<Triangle> {
    let (lo, hi) = (bounds.lo, bounds.hi);
    // Bit 0 of a corner selects the upper end in x, bit 1 in y, bit 2 in z, as in the core's octants.
    let corner = |bits: u32| {
        Vec3::new(
            if bits & 1 == 0 { lo.x } else { hi.x },
            if bits & 2 == 0 { lo.y } else { hi.y },
            if bits & 4 == 0 { lo.z } else { hi.z },
        )
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut triangles = Vec::with_capacity(12 * (divisions as usize).pow(2));
    for face in faces {
        patch(face.map(corner), divisions, divisions, |triangle| triangles.push(triangle));
    }
    triangles
}

/// Divides a parallelogram with sides along the axes into `across x along` quads of two triangles.
///
/// `corners` are in counter-clockwise order. `across` divides the first side, `along` the second.
pub(super) fn patch(corners: [Vec3; 4], across: u32, along: u32, mut emit: impl FnMut(Triangle)) {
    let [a, b, c, _] = corners;
    // Each coordinate changes along one side at most. It is interpolated from the lower to the upper end, whichever way
    // the face runs, so neighbouring faces get the same bits.
    let coordinate = |from: f32, to: f32, step: u32, steps: u32| {
        let (low, high, step) =
            if from <= to { (from, to, step) } else { (to, from, steps - step) };
        let (low, high) = (f64::from(low), f64::from(high));
        (low + (high - low) * (f64::from(step) / f64::from(steps))) as f32
    };
    let point = |i: u32, j: u32| {
        let axis = |a: f32, b: f32, c: f32| {
            if a == b { coordinate(b, c, j, along) } else { coordinate(a, b, i, across) }
        };
        Vec3::new(axis(a.x, b.x, c.x), axis(a.y, b.y, c.y), axis(a.z, b.z, c.z))
    };
    for j in 0..along {
        for i in 0..across {
            let (p, q, r, s) = (point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
            emit(Triangle::new(p, q, r));
            emit(Triangle::new(p, r, s));
        }
    }
}

/// Most subdivisions of a sphere: 20 * 4^9 is five million triangles.
const MOST_SUBDIVISIONS: u32 = 9;

/// Makes a closed sphere of radius 1 around the origin: an icosahedron whose triangles are divided into four
/// `subdivisions` times (at most 9), which gives `20 * 4^subdivisions` triangles.
///
/// Every corner is computed once, so neighbours share it exactly.
pub fn closed_sphere(subdivisions: u32) -> Vec<Triangle> {
    // 1. The corners of an icosahedron are those of three golden rectangles, one across each axis.
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for axis in 0..3 {
        for (short, long) in [(-1.0, -golden), (1.0, -golden), (-1.0, golden), (1.0, golden)] {
            let mut corner = [0.0; 3];
            corner[(axis + 1) % 3] = short;
            corner[(axis + 2) % 3] = long;
            corners.push(on_sphere(corner.into()));
        }
    }
    let mut faces = icosahedron_faces(&corners);

    // 2. Subdivision: the midpoint of each edge, moved out to the sphere, is shared by the two triangles of the edge.
    for _ in 0..subdivisions.min(MOST_SUBDIVISIONS) {
        let mut midpoints = HashMap::with_capacity(faces.len() * 3 / 2);
        let mut divided = Vec::with_capacity(faces.len() * 4);
        for [a, b, c] in faces {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[a, b]: [usize; 2]| {
                *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    corners.push(on_sphere(corners[a.min(b)] + corners[a.max(b)]));
                    corners.len() - 1
                })
            });
            divided.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        faces = divided;
    }

    // 3. Rounding, once for each corner.
    let rounded: Vec<Vec3> = corners.iter().map(|corner| corner.rounded()).collect();
    faces.iter().map(|&[a, b, c]| Triangle::new(rounded[a], rounded[b], rounded[c])).collect()
}

/// Makes a closed sphere around `centre`, divided as [`closed_sphere`] is.
pub fn sphere_at(centre: Vec3, radius: f32, subdivisions: u32) -> Vec<Triangle> {
    let moved = |point: Vec3| centre + point * radius;
    closed_sphere(subdivisions)
        .into_iter()
        .map(|triangle| Triangle::new(moved(triangle.a), moved(triangle.b), moved(triangle.c)))
        .collect()
}

/// Finds the faces: the triples of corners one edge length apart, wound outwards.
fn icosahedron_faces(corners: &[Vector64]) -> Vec<[usize; 3]> {
    // On the unit sphere, the cosine between neighbouring corners is 1/sqrt(5) = 0.447; between others it is negative.
    let near = |a: usize, b: usize| corners[a].dot(corners[b]) > 0.0;
    let count = corners.len();
    let mut faces = Vec::new();
    for a in 0..count {
        for b in (a + 1..count).filter(|&b| near(a, b)) {
            for c in (b + 1..count).filter(|&c| near(a, c) && near(b, c)) {
                let volume = corners[a].dot(corners[b].cross(corners[c]));
                faces.push(if volume > 0.0 { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    faces
}

fn on_sphere(point: Vector64) -> Vector64 {
    point / point.length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::closed::is_closed;

    #[test]
    fn closed_surfaces_are_closed_and_face_outwards() {
        let shifted = Aabb::new(Vec3::new(0.1, -3.7, 11.3), Vec3::new(0.4, 5.1, 12.9));
        for (triangles, centre, count) in [
            (closed_sphere(0), Vec3::ZERO, 20),
            (closed_sphere(1), Vec3::ZERO, 80),
            (closed_sphere(5), Vec3::ZERO, 20_480),
            (sphere_at(Vec3::splat(9.0), 0.3, 2), Vec3::splat(9.0), 320),
            (cube(Vec3::splat(0.7), 0.3), Vec3::splat(0.7), 12),
            (cuboid(shifted, 7), shifted.centre(), 588),
        ] {
            assert_eq!(triangles.len(), count);
            assert!(is_closed(&triangles), "{count} triangles");
            assert!(triangles.iter().all(|t| t.normal().dot(t.a - centre) > 0.0));
        }
    }

    #[test]
    fn spheres_have_their_radius() {
        for triangle in closed_sphere(5) {
            assert!((triangle.a.length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn floors_face_up() {
        let triangles = floor(Vec3::new(1.0, 2.0, 3.0), 10.0, 50);
        assert_eq!(triangles.len(), 5_000);
        assert!(triangles.iter().all(|t| t.normal().z > 0.0 && t.a.z == 3.0));
        let bounds = triangles.iter().fold(Aabb::EMPTY, |all, t| all.union(t.bounds()));
        assert_eq!(bounds, Aabb::new(Vec3::new(-4.0, -3.0, 3.0), Vec3::new(6.0, 7.0, 3.0)));
        assert!(floor(Vec3::ZERO, 1.0, 0).is_empty());
    }
}
