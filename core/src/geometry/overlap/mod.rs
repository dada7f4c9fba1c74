//! Conservative overlap test between a triangle and a box, by separating axes.
//!
//! A triangle and a box are apart if their projections are apart on a coordinate axis, on the triangle's normal, or on
//! the cross product of a coordinate axis and an edge. Here "apart" is claimed only if the gap exceeds a bound on the
//! rounding. So no triangle is left out of a cell that it touches, and a triangle that misses a cell by a hair may be
//! kept.
//!
//! # The bound
//! Coordinates relative to the box's centre are at most `M`, edges at most `E`, both in `f64` with one
//! rounding each (`r = 2^-53`). A projection on `axis x edge` has 2 products of such differences and a
//! subtraction: 4 roundings of terms up to `2 E M`, and the box's radius likewise: together below
//! `32 r E M`. On the normal, with components up to `2 E^2` after 4 roundings, 3 products and 2 sums:
//! below `128 r E^2 M`. The margins used are 2^-46 and 2^-44 of `E M` and `E^2 M`.
//!
//! # Source
//! T. Akenine-Möller, *Fast 3D Triangle-Box Overlap Testing*, 2001.

mod octant_filter;

pub(crate) use octant_filter::OctantFilter;

use super::Triangle;
use super::vector64::{Vector64, cross, difference, dot, larger, max_abs, widened};

/// Tells whether a triangle may share a point with the closed box `lo..=hi`. Never `false` if it does.
pub fn may_overlap(triangle: &Triangle, lo: Vector64, hi: Vector64) -> bool {
    let corners = [triangle.a, triangle.b, triangle.c].map(widened);
    let [a, b, c] = corners;
    // 1. Project on the coordinate axes: exact comparisons of given numbers.
    for axis in 0..3 {
        let (a, b, c) = (a[axis], b[axis], c[axis]);
        if (a < lo[axis] && b < lo[axis] && c < lo[axis])
            || (a > hi[axis] && b > hi[axis] && c > hi[axis])
        {
            return false;
        }
    }

    // 2. Move the box's centre to the origin. The radius is measured to the side that is farther from the rounded
    // centre, so that the box around that centre holds the given one.
    let mut centre = [0.0; 3];
    let mut radius = [0.0; 3];
    for axis in 0..3 {
        centre[axis] = (lo[axis] + hi[axis]) * 0.5;
        radius[axis] = larger(hi[axis] - centre[axis], centre[axis] - lo[axis]);
    }
    let [a, b, c] = corners.map(|corner| difference(corner, centre));
    let edges = [difference(b, a), difference(c, b), difference(a, c)];
    let reach = [a, b, c, radius].map(max_abs).into_iter().fold(0.0, larger);
    let edge = edges.map(max_abs).into_iter().fold(0.0, larger);

    // 3. Project on the cross products of a coordinate axis and an edge.
    let margin = edge * reach * 1.421_085_471_520_200_4e-14; // 2^-46
    for e in edges {
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let project = |p: Vector64| p[i] * e[j] - p[j] * e[i];
            let (p, q, r) = (project(a), project(b), project(c));
            let box_radius = radius[i] * e[j].abs() + radius[j] * e[i].abs() + margin;
            if larger(p, larger(q, r)) < -box_radius || smaller(p, smaller(q, r)) > box_radius {
                return false;
            }
        }
    }

    // 4. Project on the normal.
    let [e, f, _] = edges;
    let normal = cross(e, f);
    let margin = edge * edge * reach * 5.684_341_886_080_802e-14; // 2^-44
    dot(normal, a).abs() <= dot(normal.map(f64::abs), radius) + margin
}

fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn touching_counts_and_a_cut_corner_does_not() {
        let unit = ([0.0; 3], [1.0; 3]);
        let plane_x = |x: f32| {
            Triangle::new(Vec3::new(x, 0.2, 0.2), Vec3::new(x, 0.8, 0.2), Vec3::new(x, 0.2, 0.8))
        };
        assert!(may_overlap(&plane_x(1.0), unit.0, unit.1));
        assert!(!may_overlap(&plane_x(1.000_001), unit.0, unit.1));
        // Its box holds the corner (1, 1, 1), but it passes outside: x + y + z = 3.3.
        let outside = Triangle::new(
            Vec3::new(3.3, 0.0, 0.0),
            Vec3::new(0.0, 3.3, 0.0),
            Vec3::new(0.0, 0.0, 3.3),
        );
        assert!(!may_overlap(&outside, unit.0, unit.1));
    }
}
