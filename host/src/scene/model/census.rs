//! Counts of distinct vertices, degenerate triangles and duplicates of a scene.

use std::collections::HashSet;
use std::fmt;

use arboleda::{Triangle, Vec3};

use super::Model;

/// Counts of a scene's distinct vertices and of triangles that no closest hit reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Distinct points among all corners; 0 and -0 are equal.
    pub vertices: usize,
    /// Triangles without area, which no ray hits.
    pub degenerate: usize,
    /// Triangles with the same corners, in any order, as a triangle of lower id, which wins every tie.
    pub duplicate: usize,
}

type Bits = [u32; 3];

impl Census {
    /// Counts vertices and triangles, in time and memory linear in the triangles.
    pub fn of(model: &Model) -> Self {
        let mut census = Self::default();
        let mut points: HashSet<Bits> = HashSet::new();
        let mut triangles: HashSet<[Bits; 3]> = HashSet::new();
        for triangle in &model.triangles {
            census.degenerate += usize::from(is_degenerate(triangle));
            let mut corners = [triangle.a, triangle.b, triangle.c].map(bits);
            points.extend(corners);
            corners.sort_unstable();
            census.duplicate += usize::from(!triangles.insert(corners));
        }
        census.vertices = points.len();
        census
    }
}

impl fmt::Display for Census {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { vertices, degenerate, duplicate } = self;
        write!(f, "{vertices} vertices; {degenerate} triangles without area, {duplicate} duplicate")
    }
}

/// Returns the bits of a point, for comparison. Adding 0 turns -0 into 0.
fn bits(point: Vec3) -> Bits {
    point.to_array().map(|x| (x + 0.0).to_bits())
}

/// Tells exactly whether the corners lie on a line: whether `orient2d` is 0 in each of three projections.
fn is_degenerate(triangle: &Triangle) -> bool {
    let corners =
        [triangle.a, triangle.b, triangle.c].map(|corner| corner.to_array().map(f64::from));
    [(0, 1), (1, 2), (2, 0)].iter().all(|&(x, y)| {
        let [a, b, c] = corners.map(|corner| robust::Coord { x: corner[x], y: corner[y] });
        robust::orient2d(a, b, c) == 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_slivers_and_copies() {
        let point = |x: f32, y: f32| Vec3::new(x, y, 0.1);
        let (a, b, c) = (point(0.1, 0.0), point(1.1, 0.0), point(0.1, 1.0));
        let mut model = Model::named("test");
        model.add_object(
            "all",
            [
                Triangle::new(a, b, c),
                Triangle::new(c, a, b),
                Triangle::new(b, a, c),
                Triangle::new(a, a, b),
                // On a line, and next to it by the smallest step.
                Triangle::new(Vec3::ZERO, Vec3::ONE, Vec3::splat(3.0)),
                Triangle::new(Vec3::ZERO, Vec3::ONE, Vec3::new(3.0, 3.0, 3.000_000_2)),
                Triangle::new(Vec3::new(-0.0, 0.0, 0.0), a, b),
            ],
            0.5,
        );
        let census = Census::of(&model);
        assert_eq!(census, Census { vertices: 7, degenerate: 2, duplicate: 2 });
        assert_eq!(census.to_string(), "7 vertices; 2 triangles without area, 2 duplicate");
    }
}
