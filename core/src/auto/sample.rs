//! Rays to try indices on, where the caller has none.
//!
//! ```text
//! even:  -->|box|-->        a line through two points on the faces of the scene's box, from outside
//! odd:   __/__              from a point on a triangle, cosine-distributed to one of its sides
//! ```
//! Like photons: light comes from outside, and bounces where it meets surfaces. Triangles are taken by area
//! and by number in turns, so that neither a floor nor a detail is left out. Only `+ - * / sqrt`, so the rays
//! are the same bits everywhere.

use crate::geometry::{Aabb, Ray, Triangle};
use crate::{Scene, Vec3};

/// Rays of a sample: a few milliseconds, little beside the builds.
const COUNT: u32 = 1024;
/// A bounce begins this share of the box's diagonal above the triangle.
const ABOVE: f32 = 1e-5;

/// Shows the rays of the scene's sample; none for an empty scene. Cost: twice through the triangles.
pub(super) fn for_each_ray(scene: &Scene<'_>, mut show: impl FnMut(&Ray)) {
    let triangles = scene.triangles();
    let bounds = triangles.iter().fold(Aabb::EMPTY, |all, t| all.union(t.bounds()));
    if bounds.is_empty() {
        return;
    }
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    // 1. From outside.
    for _ in 0..COUNT / 2 {
        let (from, to) = (on_face(&bounds, &mut random), on_face(&bounds, &mut random));
        // Half a way back, to begin outside; a NaN or an infinity makes no ray.
        let direction = to - from;
        if let Ok(ray) = Ray::new(from - direction * 0.5, direction) {
            show(&ray);
        }
    }
    // 2. From triangles: evenly by number and by area, each a stride apart.
    let whole: f64 = triangles.iter().map(area).sum();
    let number_step = triangles.len() as f64 / f64::from(COUNT / 4);
    let area_step = whole / f64::from(COUNT / 4);
    let above = libm::sqrt(bounds.diagonal_squared()) as f32 * ABOVE;
    let (mut next_number, mut next_area) = (0.5 * number_step, 0.5 * area_step);
    let mut area_sum = 0.0;
    for (number, triangle) in triangles.iter().enumerate() {
        area_sum += area(triangle);
        let mut due = 0;
        while next_number < (number + 1) as f64 {
            next_number += number_step;
            due += 1;
        }
        while area_step > 0.0 && next_area < area_sum {
            next_area += area_step;
            due += 1;
        }
        for _ in 0..due {
            if let Some(ray) = bounce(triangle, above, &mut random) {
                show(&ray);
            }
        }
    }
}

/// A point on the faces of a box, evenly by area.
fn on_face(bounds: &Aabb, random: &mut Random) -> Vec3 {
    let [x, y, z] = bounds.extent();
    let faces = [y * z, z * x, x * y];
    let mut left = f64::from(random.uniform()) * (faces[0] + faces[1] + faces[2]);
    let mut across = 0;
    for face in &faces[..2] {
        if left >= *face {
            left -= face;
            across += 1;
        } else {
            break;
        }
    }
    let mut shares = [random.uniform(), random.uniform(), random.uniform()];
    for (axis, share) in shares.iter_mut().enumerate() {
        if axis == across {
            *share = if *share < 0.5 { 0.0 } else { 1.0 };
        }
    }
    // Not `hi - lo`, which may overflow.
    let shares = Vec3::from_array(shares);
    bounds.lo * (Vec3::ONE - shares) + bounds.hi * shares
}

/// A ray from a point of the triangle, to one of its sides.
fn bounce(triangle: &Triangle, above: f32, random: &mut Random) -> Option<Ray> {
    let (u, v) = (random.uniform(), random.uniform());
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    let normal = triangle.normal().try_normalize()?;
    let normal = if random.uniform() < 0.5 { -normal } else { normal };
    let direction = normal + random.on_sphere();
    Ray::new(triangle.at(u, v) + normal * above, direction).ok()
}

fn area(triangle: &Triangle) -> f64 {
    let normal = triangle.normal().to_array().map(f64::from);
    let area = libm::sqrt(normal.iter().map(|n| n * n).sum());
    if area.is_finite() { area } else { 0.0 }
}

/// SplitMix64.
///
/// # Source
/// G. L. Steele, D. Lea, C. H. Flood, *Fast Splittable Pseudorandom Number Generators*, 2014.
struct Random(u64);

impl Random {
    /// From 0 to 1, without 1.
    fn uniform(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 40) as f32 / 16_777_216.0
    }

    /// A point on the unit sphere, by drawing from the cube until it lies in the ball.
    fn on_sphere(&mut self) -> Vec3 {
        for _ in 0..64 {
            let point = Vec3::new(self.uniform(), self.uniform(), self.uniform()) * 2.0 - Vec3::ONE;
            let square = point.length_squared();
            if square > 0.01 && square <= 1.0 {
                return point / libm::sqrtf(square);
            }
        }
        Vec3::Z
    }
}
