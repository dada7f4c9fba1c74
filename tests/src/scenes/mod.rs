//! Scenes for index builds. Each scene is a function of its arguments.

pub mod crowds;

use std::collections::HashMap;

use arboleda::{Triangle, Vec3};

use crate::random::Random;

/// Makes triangles with whole coordinates in `-reach..=reach`. They share planes, edges and corners; some have no area.
pub fn lattice(count: usize, reach: i32, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed);
    let mut triangle = || {
        // Two thirds are small; otherwise all would overlap.
        let a = random.lattice(reach);
        let near = random.pick(&[1, 1, reach]);
        Triangle::new(a, a + random.lattice(near), a + random.lattice(near))
    };
    (0..count).map(|_| triangle()).collect()
}

/// Makes small triangles, strewn over the cube from -1 to 1.
pub fn soup(count: usize, seed: u64) -> Vec<Triangle> {
    let mut random = Random::new(seed);
    let mut triangle = || {
        let (a, size) = (random.point(), random.pick(&[0.02, 0.1, 0.5]));
        Triangle::new(a, a + random.point() * size, a + random.point() * size)
    };
    (0..count).map(|_| triangle()).collect()
}

/// Makes `count` copies of a triangle.
pub fn coincident(count: usize) -> Vec<Triangle> {
    vec![Triangle::new(Vec3::ZERO, Vec3::new(4.0, 0.0, 1.0), Vec3::new(0.0, 4.0, 2.0)); count]
}

/// Makes a triangulated square of `2 * side * side` triangles, perpendicular to one axis at height 3.
pub fn flat(side: usize, axis: usize) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let mut p = [i as f32, j as f32, 3.0];
        p.rotate_right((axis + 1) % 3);
        Vec3::from_array(p)
    };
    let mut triangles = Vec::new();
    for i in 0..side {
        for j in 0..side {
            let (p, q) = (point(i, j), point(i + 1, j + 1));
            triangles.push(Triangle::new(p, point(i + 1, j), q));
            triangles.push(Triangle::new(p, q, point(i, j + 1)));
        }
    }
    triangles
}

/// Makes a soup with coordinates up to the largest floats.
pub fn huge(count: usize, seed: u64) -> Vec<Triangle> {
    scaled(&soup(count, seed), 2.0e38)
}

/// Makes a lattice with subnormal coordinates.
pub fn tiny(count: usize, seed: u64) -> Vec<Triangle> {
    scaled(&lattice(count, 6, seed), 1e-45)
}

/// Multiplies every coordinate by a factor.
pub fn scaled(triangles: &[Triangle], factor: f32) -> Vec<Triangle> {
    moved(triangles, factor, Vec3::ZERO)
}

/// Multiplies every corner by a factor, then adds a step.
pub fn moved(triangles: &[Triangle], factor: f32, step: Vec3) -> Vec<Triangle> {
    let at = |p: Vec3| p * factor + step;
    triangles.iter().map(|t| Triangle::new(at(t.a), at(t.b), at(t.c))).collect()
}

/// Makes the twelve triangles of a box.
pub fn cuboid(lo: Vec3, hi: Vec3) -> [Triangle; 12] {
    let corner = |bits: usize| {
        let pick = |axis: usize| if bits >> axis & 1 == 0 { lo[axis] } else { hi[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let mut triangles = [Triangle::default(); 12];
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in 0..2 {
            let base = side << axis;
            let [p, q, r, s] = [base, base | u, base | u | v, base | v].map(corner);
            triangles[4 * axis + 2 * side] = Triangle::new(p, q, r);
            triangles[4 * axis + 2 * side + 1] = Triangle::new(p, r, s);
        }
    }
    triangles
}

/// Makes `side` cubed unit boxes on a lattice, each touching its neighbours.
pub fn touching_boxes(side: usize) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for place in 0..side * side * side {
        let at = [place % side, place / side % side, place / side / side].map(|i| i as f32);
        let lo = Vec3::from_array(at);
        triangles.extend(cuboid(lo, lo + Vec3::ONE));
    }
    triangles
}

/// Makes a closed sphere of radius 1 around the origin: 20 triangles, each divided into four `subdivisions` times.
/// Neighbours share corners bit for bit.
pub fn icosphere(subdivisions: usize) -> Vec<Triangle> {
    const FACES: [[usize; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut corners: Vec<[f64; 3]> = Vec::new();
    for turn in 0..3 {
        for (long, short) in [(golden, -1.0), (golden, 1.0), (-golden, -1.0), (-golden, 1.0)] {
            // `usual` below has the corners in the order of the table of faces.
            let mut p = [0.0, short, long];
            p.rotate_right(turn);
            corners.push(p);
        }
    }
    let place = |p: [f64; 3]| corners.iter().position(|q| *q == p);
    let g = golden;
    let usual: Vec<usize> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .into_iter()
    .filter_map(place)
    .collect();
    let mut faces: Vec<[usize; 3]> = FACES.iter().map(|face| face.map(|i| usual[i])).collect();

    for _ in 0..subdivisions {
        let mut halves = HashMap::new();
        let mut half = |i: usize, j: usize, corners: &mut Vec<[f64; 3]>| {
            *halves.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let (p, q) = (corners[i], corners[j]);
                corners.push([0, 1, 2].map(|axis| f64::midpoint(p[axis], q[axis])));
                corners.len() - 1
            })
        };
        let divided = faces.iter().flat_map(|&[a, b, c]| {
            let ab = half(a, b, &mut corners);
            let bc = half(b, c, &mut corners);
            let ca = half(c, a, &mut corners);
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        });
        faces = divided.collect();
        for p in &mut corners {
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            *p = p.map(|c| c / length);
        }
    }
    let at = |i: usize| Vec3::from_array(corners[i].map(|c| c as f32));
    faces.iter().map(|&[a, b, c]| Triangle::new(at(a), at(b), at(c))).collect()
}

/// Converts triangles to an indexed mesh: the distinct vertices, and the corners of each triangle.
pub fn welded(triangles: &[Triangle]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut vertices, mut places) = (Vec::new(), HashMap::new());
    let mut place = |vertex: Vec3| {
        *places.entry(vertex.to_array().map(f32::to_bits)).or_insert_with(|| {
            vertices.push(vertex);
            vertices.len() as u32 - 1
        })
    };
    let corners = triangles.iter().map(|t| [t.a, t.b, t.c].map(&mut place)).collect();
    (vertices, corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed() {
        let mut edges: HashMap<[[u32; 3]; 2], usize> = HashMap::new();
        let sphere = icosphere(3);
        assert_eq!(sphere.len(), 20 * 64);
        for Triangle { a, b, c } in sphere {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let mut edge = [p, q].map(|p| p.to_array().map(f32::to_bits));
                edge.sort_unstable();
                *edges.entry(edge).or_default() += 1;
            }
        }
        assert!(edges.values().all(|&count| count == 2));
    }
}
