//! Rays that are hard for indices.

use arboleda::{Ray, Triangle, Vec3};

use crate::random::{Random, power_of_two};

/// Makes rays at a scene: along axes, along faces, through corners and edges, from inside, from far away, with
/// subnormal directions. Some are reversed, and intervals vary.
pub fn around(triangles: &[Triangle], count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let mut rays = Vec::with_capacity(count);
    while rays.len() < count {
        let (origin, direction) = line(triangles, &mut random);
        let direction = if random.once_in(3) { -direction } else { direction };
        let (t_min, t_max) = random.pick(&[
            (0.0, f32::INFINITY),
            (0.0, f32::INFINITY),
            (0.0, 1.0),
            (f32::NEG_INFINITY, f32::INFINITY),
            (0.5, 0.5),
            (-2.0, 1.0_f32.next_down()),
        ]);
        rays.extend(Ray::with_interval(origin, direction, t_min, t_max));
    }
    rays
}

fn line(triangles: &[Triangle], random: &mut Random) -> (Vec3, Vec3) {
    let place = random.below(triangles.len());
    let triangle = triangles.get(place).copied().unwrap_or_default();
    let corners = [triangle.a, triangle.b, triangle.c];
    let (p, q) = (random.pick(&corners), random.pick(&corners));
    let middle = p * 0.5 + q * 0.5; // halves first: the sum may overflow
    let target = random.pick(&[p, middle, triangle.at(0.3, 0.3)]);
    let reach = corners.iter().flat_map(|c| c.to_array()).fold(0.0, |a: f32, b| a.max(b.abs()));
    let reach = if reach > 0.0 { reach } else { 1.0 };
    match random.below(8) {
        // Along an axis, through a corner or a point of an edge.
        0 => (target - axis(random) * reach, axis(random)),
        // Along an edge, in the plane of the triangle.
        1 => (p - (q - p), q - p),
        // Through a corner or an edge, from a random point.
        2 | 3 => {
            let origin = random.point() * (reach * 0.9);
            (origin, towards(origin, target))
        }
        // From a corner or an edge, so that t is 0.
        4 => (target, random.point()),
        // From far away.
        5 => {
            let origin = random.point() * 1e30;
            (origin, towards(origin, target))
        }
        // A subnormal direction, or one that makes t overflow.
        6 => {
            let direction = random.lattice(3);
            let factor = random.pick(&[power_of_two(-149) as f32, 1e-42, 1e38]);
            (target - direction * (reach * 0.25), direction * factor)
        }
        // At whole coordinates, along a diagonal.
        _ => (random.lattice(6), random.lattice(2)),
    }
}

fn axis(random: &mut Random) -> Vec3 {
    random.pick(&[Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z])
}

/// Computes the direction from one point to another; a quarter of it if the difference overflows.
pub fn towards(origin: Vec3, target: Vec3) -> Vec3 {
    let step = target - origin;
    if step.is_finite() { step } else { target * 0.25 - origin * 0.25 }
}
