//! Scenes that no plane separates: coincident triangles, triangles around one point, slivers.
//!
//! Each scene is a function of its number of triangles. The scenes come from reports of builds that did not end.

use arboleda::{Triangle, Vec3};

use crate::random::Random;
use crate::scenes;

/// Function that makes a scene of a number of triangles.
pub type Crowd = fn(usize) -> Vec<Triangle>;

/// All crowds, with their names.
pub const ALL: &[(&str, Crowd)] = &[
    ("copies", scenes::coincident),
    ("concentric", concentric),
    ("planes through a point", planes_through_a_point),
    ("slivers", slivers),
    ("slanted slivers", slanted_slivers),
    ("fan", fan),
    ("grid written often", grid_written_often),
    ("large and small", large_and_small),
    ("needle and dust", needle_and_dust),
];

/// Makes triangles of one centre in one plane, with sizes from 1 to 1.01.
pub fn concentric(count: usize) -> Vec<Triangle> {
    let size = |place: usize| 1.0 + 0.01 * place as f32 / count as f32;
    let triangle = |size: f32| {
        let [a, b, c] = [(-1.0, -0.6), (1.0, -0.6), (0.0, 1.2)];
        let at = |(x, y): (f32, f32)| Vec3::new(size * x, size * y, 0.25 * size * (x + y));
        Triangle::new(at(a), at(b), at(c))
    };
    (0..count).map(|place| triangle(size(place))).collect()
}

/// Makes triangles of one centre, each in a plane of its own.
pub fn planes_through_a_point(count: usize) -> Vec<Triangle> {
    let mut random = Random::new(5);
    let mut triangle = || {
        let (u, v) = (random.point(), random.point());
        Triangle::new(u, v, -(u + v))
    };
    (0..count).map(|_| triangle()).collect()
}

/// Makes a cylinder of length 1,000 and width 0.1 along x.
pub fn slivers(count: usize) -> Vec<Triangle> {
    let on_circle = |place: usize, x: f32| {
        let angle = core::f64::consts::TAU * place as f64 / (count / 2).max(1) as f64;
        Vec3::new(x, 0.05 * angle.cos() as f32, 0.05 * angle.sin() as f32)
    };
    let triangle = |place: usize| {
        let (side, upper) = (place / 2, place % 2 == 1);
        let (near, far) = (if upper { 1000.0 } else { 0.0 }, if upper { 0.0 } else { 1000.0 });
        Triangle::new(on_circle(side, near), on_circle(side + 1, near), on_circle(side, far))
    };
    (0..count).map(triangle).collect()
}

/// Makes the cylinder of [`slivers`] along the diagonal of the axes.
pub fn slanted_slivers(count: usize) -> Vec<Triangle> {
    let turn = |p: Vec3| {
        let (along, u, v) = (Vec3::new(0.57, 0.58, 0.582), Vec3::new(0.7, -0.7, 0.0), Vec3::Z);
        p.x * along + p.y * u + p.z * v
    };
    let turned = |t: &Triangle| Triangle::new(turn(t.a), turn(t.b), turn(t.c));
    slivers(count).iter().map(turned).collect()
}

/// Makes a flat convex polygon, divided from its first corner.
pub fn fan(count: usize) -> Vec<Triangle> {
    let corner = |place: usize| {
        let angle = core::f64::consts::TAU * place as f64 / (count + 2) as f64;
        Vec3::new(angle.cos() as f32, angle.sin() as f32, 0.0)
    };
    let triangle = |place| Triangle::new(corner(0), corner(place + 1), corner(place + 2));
    (0..count).map(triangle).collect()
}

/// Makes copies of a flat grid of 20 by 20 squares until there are `count` triangles.
pub fn grid_written_often(count: usize) -> Vec<Triangle> {
    scenes::flat(20, 2).into_iter().cycle().take(count).collect()
}

/// Makes large triangles through the whole scene, and as many tiny ones in one corner.
pub fn large_and_small(count: usize) -> Vec<Triangle> {
    let mut triangles = planes_through_a_point(count / 2);
    let tiny = scenes::soup(count - count / 2, 7);
    triangles.extend(scenes::moved(&tiny, 1e-4, Vec3::splat(0.3)));
    triangles
}

/// Makes long needles and tiny triangles, alternately.
pub fn needle_and_dust(count: usize) -> Vec<Triangle> {
    let mut random = Random::new(9);
    let mut triangle = |place: usize| {
        let (at, thin) = (random.point(), random.point() * 1e-3);
        let long =
            if place.is_multiple_of(2) { random.point() * 100.0 } else { random.point() * 1e-3 };
        Triangle::new(at - long, at + long, at + thin)
    };
    (0..count).map(&mut triangle).collect()
}
