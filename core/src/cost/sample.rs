//! Rays to try indices on, where the caller has none.
//!
//! ```text
//! two thirds:  --|-->box|-->   all lines that meet the box, evenly: most pass by what is in it
//! one third:   -------> __     light from outside the box that would reach a point on the front of a triangle
//! ```
//! Triangles are taken evenly by area, points and directions from one sequence that fills the cube evenly, so a few
//! hundred rays are enough. Only `+ - * / sqrt`, so the rays are the same bits everywhere.

use crate::Vec3;
use crate::geometry::{Aabb, Ray, Triangle};

/// Of each so many rays one is light that reaches a triangle.
///
/// Measured by how much more than the best density the automatic density of grids costs on the rays of 3,000 photons.
/// With a third it is at most 3% on the built-in scenes but one: 45% in one grid over both clusters of figure 3, whose
/// light does not send photons through the space between. On 512 of these photons' rays, given, it is 4% at most.
///
/// What lost, with one grid over the scene: lines alone, 60 times as much where the clusters of figure 3 are 1,000
/// times their size apart; half lines, half light, and light alone, 51% on figure 2, where most photons hit nothing;
/// light that reaches triangles by number, and its bounces, 39% on figure 4(d), where the floor has few triangles;
/// lines, and for half of the rays bounces from triangles, 64 in all and drawn at random, 52% on figure 2 and 35% on
/// figure 4(d). Bounces of the light beside it changed little.
const ONE_OF: u32 = 3;

/// Shows about `count` rays for some triangles; none for no triangles. Cost: three times through the triangles.
pub(crate) fn for_each_ray(
    triangles: impl Iterator<Item = Triangle> + Clone,
    count: u32,
    mut show: impl FnMut(&Ray),
) {
    let bounds = triangles.clone().fold(Aabb::EMPTY, |all, t| all.union(t.bounds()));
    if bounds.is_empty() {
        return;
    }
    let mut points = QuasirandomPoints::default();
    let beyond = libm::sqrt(bounds.diagonal_squared()) as f32;
    let mut show_from_outside = |at: Vec3, direction: Vec3| {
        // A NaN or an infinity makes no ray.
        if let Some(direction) = direction.try_normalize()
            && let Ok(ray) = Ray::new(at - direction * beyond, direction)
        {
            show(&ray);
        }
    };
    // 1. Lines through the box.
    let arriving = count / ONE_OF;
    for _ in arriving..count {
        let [face, a, b, z, turn] = points.next();
        let (at, inwards) = on_face(&bounds, face, a, b);
        show_from_outside(at, inwards + on_sphere(z, turn));
    }
    // 2. Light that reaches triangles, evenly by area.
    let whole: f64 = triangles.clone().map(|triangle| area(&triangle)).sum();
    let step = whole / f64::from(arriving);
    let mut next = 0.5 * step;
    let mut sum = 0.0;
    for triangle in triangles {
        sum += area(&triangle);
        while step > 0.0 && next < sum {
            next += step;
            let [_, u, v, z, turn] = points.next();
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            if let Some(normal) = triangle.normal().try_normalize() {
                show_from_outside(triangle.at(u, v), -(normal + on_sphere(z, turn)));
            }
        }
    }
}

/// A point on the faces of a box, evenly by area, and the direction from there into the box.
fn on_face(bounds: &Aabb, face: f32, a: f32, b: f32) -> (Vec3, Vec3) {
    let [x, y, z] = bounds.extent();
    let mut left = f64::from(face) * 2.0 * (y * z + z * x + x * y);
    let faces = [
        (y * z, Vec3::new(0.0, a, b), Vec3::X),
        (y * z, Vec3::new(1.0, a, b), Vec3::NEG_X),
        (z * x, Vec3::new(a, 0.0, b), Vec3::Y),
        (z * x, Vec3::new(a, 1.0, b), Vec3::NEG_Y),
        (x * y, Vec3::new(a, b, 0.0), Vec3::Z),
    ];
    let (mut shares, mut inwards) = (Vec3::new(a, b, 1.0), Vec3::NEG_Z);
    for (area, at, normal) in faces {
        if left < area {
            (shares, inwards) = (at, normal);
            break;
        }
        left -= area;
    }
    // Not `hi - lo`, which may overflow.
    (bounds.lo * (Vec3::ONE - shares) + bounds.hi * shares, inwards)
}

fn area(triangle: &Triangle) -> f64 {
    let normal = triangle.normal().to_array().map(f64::from);
    let area = libm::sqrt(normal.iter().map(|n| n * n).sum());
    if area.is_finite() { area } else { 0.0 }
}

/// A point on the unit sphere, evenly for even `z` and `turn` from 0 to 1; a little off, to do without a cosine.
///
/// # Source
/// Bhaskara I, Mahabhaskariya, 7th century: cos(pi x) is about (1 - 4 x^2) / (1 + x^2) from -1/2 to 1/2, within 0.002.
fn on_sphere(z: f32, turn: f32) -> Vec3 {
    let z = 1.0 - 2.0 * z;
    let (x, side) = if turn < 0.5 { (2.0 * turn - 0.5, 1.0) } else { (2.0 * turn - 1.5, -1.0) };
    let cosine = (1.0 - 4.0 * x * x) / (1.0 + x * x);
    let sine = libm::sqrtf(1.0 - cosine * cosine) * if x < 0.0 { -1.0 } else { 1.0 };
    let radius = libm::sqrtf(1.0 - z * z) * side;
    Vec3::new(radius * cosine, radius * sine, z)
}

/// QuasirandomPoints of the cube of five dimensions, each where the others have left the most room.
///
/// # Source
/// M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018: steps by the powers of 1/p with
/// p^6 = p + 1, here as fractions of 2^32.
#[derive(Default)]
struct QuasirandomPoints([u32; 5]);

const STEPS: [u32; 5] = [0xe19b_01ab, 0xc6d1_d6c9, 0xaf36_d01f, 0x9a69_443f, 0x8814_03b9];

impl QuasirandomPoints {
    /// The next point; each coordinate from 0 to 1, without 1.
    fn next(&mut self) -> [f32; 5] {
        for (coordinate, step) in self.0.iter_mut().zip(STEPS) {
            *coordinate = coordinate.wrapping_add(step);
        }
        self.0.map(|coordinate| (coordinate >> 8) as f32 / 16_777_216.0)
    }
}
