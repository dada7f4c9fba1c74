//! Sample of rays, for scenes without rays of the caller.
//!
//! ```text
//! two thirds:  --|-->box|-->   lines through the box, evenly: most pass by what is in it
//! one third:   -------> __     light from outside the box towards a point on the front of a triangle
//! ```
//! 1. Lines: a point on the faces of the box, evenly by area, and a direction from there into the box, by the cosine.
//! 2. Light: a point on the triangles, evenly by area, and a direction towards its front, by the cosine.
//! 3. Both kinds of ray begin outside the box.
//!
//! Points and directions come from one low-discrepancy (quasirandom) sequence, so a few hundred rays are enough. Only
//! `+ - * / sqrt` are used, so the rays are the same bits on every machine.

use crate::Vec3;
use crate::geometry::{Aabb, Ray, Triangle};

/// Divisor: one ray of `ONE_OF` is light that reaches a triangle.
///
/// # Measured
/// The measure is how much more the automatic density of grids costs than the best density, on the rays of 3,000
/// photons.
/// - With a third of light, at most 3% on the built-in scenes, but for one: 45% in one grid over both clusters of
///   figure 3, whose light does not send photons through the space between.
/// - On 512 of these photons' rays, given by the caller, at most 4%.
/// - Bounces of the light in addition changed little.
///
/// # What lost
/// With one grid over the scene:
/// - Lines alone: 60 times as much where the clusters of figure 3 are 1,000 times their size apart.
/// - Half lines, half light: 51% on figure 2, where most photons hit nothing.
/// - Light alone: 51% on figure 2.
/// - Light that reaches triangles evenly by number, and its bounces: 39% on figure 4(d), where the floor has few
///   triangles.
/// - Lines, and for half of the rays bounces from triangles, 64 in all and drawn at random: 52% on figure 2 and 35% on
///   figure 4(d).
const ONE_OF: u32 = 3;

/// Shows about `count` rays for some triangles; none for no triangles. Cost: three passes over the triangles.
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
        // A direction or an origin that is NaN or infinite makes no ray, and is passed over.
        if let Some(direction) = direction.try_normalize()
            && let Ok(ray) = Ray::new(at - direction * beyond, direction)
        {
            show(&ray);
        }
    };
    // 1. Lines through the box, begun `beyond` before the face.
    let arriving = count / ONE_OF;
    for _ in arriving..count {
        let [face, a, b, z, turn] = points.next();
        let (at, inwards) = on_face(&bounds, face, a, b);
        show_from_outside(at, inwards + on_sphere(z, turn));
    }
    // 2. Light: every `step` of the summed area, a point of the triangle that the sum has reached.
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

/// Maps three numbers from 0 to 1 to a point on the faces of a box, evenly by area. Returns the point, and the
/// direction from there into the box.
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
    // Interpolated, because `hi - lo` may overflow.
    (bounds.lo * (Vec3::ONE - shares) + bounds.hi * shares, inwards)
}

fn area(triangle: &Triangle) -> f64 {
    let normal = triangle.normal().to_array().map(f64::from);
    let area = libm::sqrt(normal.iter().map(|n| n * n).sum());
    if area.is_finite() { area } else { 0.0 }
}

/// Maps two numbers from 0 to 1 to a point on the unit sphere, evenly. The cosine is approximated.
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

/// Quasirandom sequence of points in the unit cube of five dimensions. Each point lies where the previous ones have
/// left the most room.
///
///
/// # Source
/// M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018: steps by the powers of 1/p with
/// p^6 = p + 1, here as fractions of 2^32.
#[derive(Default)]
struct QuasirandomPoints([u32; 5]);

/// Step of each coordinate, as a fraction of 2^32.
const STEPS: [u32; 5] = [0xe19b_01ab, 0xc6d1_d6c9, 0xaf36_d01f, 0x9a69_443f, 0x8814_03b9];

impl QuasirandomPoints {
    /// Returns the next point; each coordinate from 0 to 1, without 1.
    fn next(&mut self) -> [f32; 5] {
        for (coordinate, step) in self.0.iter_mut().zip(STEPS) {
            *coordinate = coordinate.wrapping_add(step);
        }
        self.0.map(|coordinate| (coordinate >> 8) as f32 / 16_777_216.0)
    }
}
