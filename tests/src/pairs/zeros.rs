//! Pairs of a ray and a triangle with a volume of exactly 0: at edges and corners, in the plane, without area.
//!
//! 1. A pair has small whole coordinates, so that each intended 0 is exact.
//! 2. The axes are permuted, and each is scaled by a power of two of its own. That multiplies all volumes by the same
//!    power of two, so zeros, hits and weights stay the same.
//!
//! The kernel decides by whole numbers if the exponents are close together, and by long sums otherwise. The pairs reach
//! both.

use arboleda::{Ray, Triangle, Vec3};

use crate::random::{Random, power_of_two};

/// Family of pairs by the reason why a volume is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zeros {
    /// Pairs with coordinates of a small lattice.
    Lattice,
    /// Rays through a corner, or beside it on the line of an edge.
    Corner,
    /// Rays through a point of an edge, or of its line.
    Edge,
    /// Rays in the triangle's plane.
    Coplanar,
    /// Triangles with two or three equal corners.
    EqualCorners,
    /// Triangles with collinear corners.
    Collinear,
    /// Rays along one or two axes, at coordinates of the corners.
    ZeroComponents,
    /// Rays that begin in the triangle's plane, so that `t` is 0.
    FromThePlane,
    /// Rays straight down on the lines of a height field whose step is not a power of two.
    HeightField,
}

impl Zeros {
    /// All families.
    pub const ALL: [Self; 9] = [
        Self::Lattice,
        Self::Corner,
        Self::Edge,
        Self::Coplanar,
        Self::EqualCorners,
        Self::Collinear,
        Self::ZeroComponents,
        Self::FromThePlane,
        Self::HeightField,
    ];

    /// Tells whether the family has hits.
    pub fn hits(self) -> bool {
        !matches!(self, Self::Coplanar | Self::EqualCorners | Self::Collinear)
    }

    /// Draws a line and a triangle of the family.
    pub fn pair(self, random: &mut Random) -> (Ray, Triangle) {
        loop {
            let (origin, direction, corners) = match self {
                Self::Lattice => lattice(random),
                Self::Corner => {
                    let eighths = random.pick(&[0, 0, 0, -1]);
                    through(random, eighths)
                }
                Self::Edge => {
                    let eighths = random.whole(-2, 10);
                    through(random, eighths)
                }
                Self::Coplanar => coplanar(random),
                Self::EqualCorners => equal_corners(random),
                Self::Collinear => collinear(random),
                Self::ZeroComponents => zero_components(random),
                Self::FromThePlane => from_the_plane(random),
                Self::HeightField => height_field(random),
            };
            let change = Change::any(random);
            let [a, b, c] = corners.map(|corner| change.point(corner));
            let (origin, direction) = (change.point(origin), change.direction(direction));
            let (back, ahead) = (f32::NEG_INFINITY, f32::INFINITY);
            if let Ok(line) = Ray::with_interval(origin, direction, back, ahead) {
                return (line, Triangle::new(a, b, c));
            }
        }
    }
}

/// Origin, direction and corners of a pair.
type Parts = (Vec3, Vec3, [Vec3; 3]);

/// Change of coordinates: a permutation of the axes and a power of two for each.
struct Change {
    first: usize,
    exponents: [i32; 3],
    length: i32,
}

impl Change {
    fn any(random: &mut Random) -> Self {
        let all = random.whole(-60, 60);
        let apart = random.pick(&[0, 0, 3, 30]);
        let exponents = [(); 3].map(|()| all + random.whole(-apart, apart));
        Self { first: random.below(3), exponents, length: random.whole(-30, 30) }
    }

    fn point(&self, p: Vec3) -> Vec3 {
        self.scaled(p, 0)
    }

    fn direction(&self, d: Vec3) -> Vec3 {
        self.scaled(d, self.length)
    }

    fn scaled(&self, p: Vec3, more: i32) -> Vec3 {
        let at = |axis: usize| {
            let factor = power_of_two(self.exponents[axis] + more);
            (f64::from(p[(axis + self.first) % 3]) * factor) as f32
        };
        Vec3::new(at(0), at(1), at(2))
    }
}

fn corners(random: &mut Random, reach: i32) -> [Vec3; 3] {
    [(); 3].map(|()| random.lattice(reach) * 8.0)
}

fn lattice(random: &mut Random) -> Parts {
    let corners = [(); 3].map(|()| random.lattice(3));
    let origin = random.lattice(5);
    let target = random.pick(&corners) + random.lattice(1);
    (origin, target - origin, corners)
}

/// Draws a ray through the first corner, moved by eighths of the edge towards the second.
fn through(random: &mut Random, eighths: i32) -> Parts {
    let mut corners = corners(random, 9);
    let [from, to, _] = corners;
    let target = from + (to - from) * (eighths as f32 / 8.0);
    let direction = random.lattice(9);
    random.shuffle(&mut corners);
    (target - direction * random.whole(-9, 9) as f32, direction, corners)
}

fn coplanar(random: &mut Random) -> Parts {
    let [base, p, q] = corners(random, 9);
    let eighth = |random: &mut Random| random.whole(-2, 10) as f32 / 8.0;
    let origin = base + p * eighth(random) + q * eighth(random);
    let direction = p * random.whole(-2, 2) as f32 + q * random.whole(-2, 2) as f32;
    (origin, direction, [base, base + p, base + q])
}

fn equal_corners(random: &mut Random) -> Parts {
    let eighths = random.whole(0, 8);
    let (origin, direction, mut corners) = through(random, eighths);
    corners[1] = corners[0];
    if random.once_in(2) {
        corners[2] = corners[0];
    }
    random.shuffle(&mut corners);
    (origin, direction, corners)
}

fn collinear(random: &mut Random) -> Parts {
    let [a, step, _] = corners(random, 5);
    let at = |random: &mut Random| a + step * random.whole(-3, 3) as f32;
    let corners = [at(random), at(random), at(random)];
    let direction = random.lattice(9);
    let target = if random.once_in(4) { random.lattice(9) } else { at(random) };
    (target - direction * random.whole(-9, 9) as f32, direction, corners)
}

fn zero_components(random: &mut Random) -> Parts {
    let corners = corners(random, 3);
    let mut direction = Vec3::ZERO;
    direction[random.below(3)] = random.whole(-9, 9) as f32;
    if random.once_in(3) {
        direction[random.below(3)] = random.whole(-9, 9) as f32;
    }
    let mut origin = random.lattice(30);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            let [p, q] = [random.pick(&corners)[axis], random.pick(&corners)[axis]];
            origin[axis] = (p + q) / 2.0;
        }
    }
    (origin, direction, corners)
}

fn from_the_plane(random: &mut Random) -> Parts {
    let [base, p, q] = corners(random, 9);
    let first = random.whole(-1, 8);
    let second = random.whole(0, 8 - first);
    let origin = base + p * (first as f32 / 8.0) + q * (second as f32 / 8.0);
    (origin, random.lattice(9), [base, base + p, base + q])
}

fn height_field(random: &mut Random) -> Parts {
    const STEP: f32 = 0.1;
    let (i, k) = (random.whole(0, 250), random.whole(0, 250));
    let line = |i: i32| i as f32 * STEP;
    let vertex =
        |i: i32, k: i32, random: &mut Random| Vec3::new(line(i), random.signed() * 4.0, line(k));
    let near = vertex(i, k, random);
    let far = vertex(i + 1, k + 1, random);
    let side = if random.once_in(2) { [i + 1, k] } else { [i, k + 1] };
    let corners = [near, vertex(side[0], side[1], random), far];
    // The ray passes through a corner, or a line of the grid through one.
    let (p, q) = (random.pick(&corners), random.pick(&corners));
    let between = (line(k) + line(k + 1)) / 2.0;
    let z = random.pick(&[p.z, q.z, between]);
    (Vec3::new(p.x, 50.0, z), Vec3::NEG_Y, corners)
}
