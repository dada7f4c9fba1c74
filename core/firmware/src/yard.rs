//! The scene: crates in a yard, and the turn of a range finder among them.

use arboleda::{Ray, RayError, Triangle, Vec3};

/// Squares along each side of the floor, 4 m each.
const FLOOR: usize = 4;
/// Corner and side of each crate, in metres: three stacks and a few single ones.
const CRATES: [(Vec3, f32); 14] = [
    (Vec3::new(3.0, 0.0, 2.0), 1.0),
    (Vec3::new(4.0, 0.0, 2.0), 1.0),
    (Vec3::new(3.5, 1.0, 2.0), 1.0),
    (Vec3::new(-5.0, 0.0, -4.0), 1.5),
    (Vec3::new(-5.0, 0.0, -2.5), 1.5),
    (Vec3::new(-5.0, 1.5, -3.25), 1.5),
    (Vec3::new(-6.5, 0.0, -3.25), 1.5),
    (Vec3::new(2.0, 0.0, -6.0), 0.5),
    (Vec3::new(2.5, 0.0, -6.0), 0.5),
    (Vec3::new(2.25, 0.5, -6.0), 0.5),
    (Vec3::new(-2.0, 0.0, 4.0), 0.75),
    (Vec3::new(-6.0, 0.0, 5.0), 2.0),
    (Vec3::new(6.0, 0.0, -2.0), 0.75),
    (Vec3::new(0.0, 0.0, -7.0), 1.0),
];
/// Number of triangles of the yard.
pub const TRIANGLES: usize = 2 * FLOOR * FLOOR + 12 * CRATES.len();

/// Height of the range finder above the middle of the yard.
const EYE: Vec3 = Vec3::new(0.0, 0.375, 0.0);
/// Bearings of a quarter turn, as unit vectors: sides of right triangles of whole numbers, over the longest one.
const QUARTER: [(f32, f32, f32); 11] = [
    (1.0, 0.0, 1.0),
    (24.0, 7.0, 25.0),
    (12.0, 5.0, 13.0),
    (15.0, 8.0, 17.0),
    (4.0, 3.0, 5.0),
    (21.0, 20.0, 29.0),
    (20.0, 21.0, 29.0),
    (3.0, 4.0, 5.0),
    (8.0, 15.0, 17.0),
    (5.0, 12.0, 13.0),
    (7.0, 24.0, 25.0),
];
/// Number of rays of a turn.
pub const RAYS: usize = 4 * QUARTER.len();

/// Makes the triangles of the floor and of the crates.
pub fn triangles() -> [Triangle; TRIANGLES] {
    let mut triangles = [Triangle::new(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO); TRIANGLES];
    let mut slots = triangles.iter_mut();
    let mut square = |corner: Vec3, u: Vec3, v: Vec3| {
        for side in [corner + u, corner + v] {
            if let Some(slot) = slots.next() {
                *slot = Triangle::new(corner, side, corner + u + v);
            }
        }
    };
    for at in 0..FLOOR * FLOOR {
        let (x, z) = ((at % FLOOR) as f32 * 4.0 - 8.0, (at / FLOOR) as f32 * 4.0 - 8.0);
        square(Vec3::new(x, 0.0, z), Vec3::X * 4.0, Vec3::Z * 4.0);
    }
    for (corner, side) in CRATES {
        let [x, y, z] = [Vec3::X * side, Vec3::Y * side, Vec3::Z * side];
        for (u, v, w) in [(x, y, z), (y, z, x), (z, x, y)] {
            square(corner, u, v);
            square(corner + w, u, v);
        }
    }
    triangles
}

/// Makes the rays of a turn. Directions have length 1, so `t` is in metres.
pub fn rays() -> impl Iterator<Item = Result<Ray, RayError>> {
    (0..RAYS).map(|number| {
        let (x, z, length) = QUARTER[number % QUARTER.len()];
        let (x, z) = match number / QUARTER.len() {
            0 => (x, z),
            1 => (-z, x),
            2 => (-x, -z),
            _ => (z, -x),
        };
        Ray::new(EYE, Vec3::new(x / length, 0.0, z / length))
    })
}
