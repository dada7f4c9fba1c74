//! Pairs of a ray and a triangle with a volume of exactly 0: at edges and corners, in the plane, without area.
//!
//! Pairs are made of small whole numbers, so that each intended 0 is exact. Then the axes change places, and each gets
//! a power of two of its own. That multiplies all volumes by a power of two, so zeros stay zeros, and neither a hit nor
//! its weights change, however far apart the exponents are. The kernel decides with whole numbers where exponents lie
//! close together, and with long sums where they do not; the pairs reach both.

use arboleda::{Ray, Triangle, Vec3};

use crate::random::{Random, power_of_two};

/// A way in which a volume is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zeros {
    /// Any coordinates of a small lattice.
    Lattice,
    /// Through a corner, or beside one on the line of an edge.
    Corner,
    /// Through a point of an edge, or of the line on which it lies.
    Edge,
    /// The ray lies in the triangle's plane.
    Coplanar,
    /// Two or three corners are one point.
    EqualCorners,
    /// Corners on a line.
    Collinear,
    /// Along an axis or across one, at coordinates of the corners.
    ZeroComponents,
    /// The ray begins in the triangle's plane: `t` is 0.
    FromThePlane,
    /// Down on the lines of a height field whose step is no power of two.
    HeightField,
}

impl Zeros {
    /// All of them.
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

    /// Tells whether there are hits at all.
    pub fn hits(self) -> bool {
        !matches!(self, Self::Coplanar | Self::EqualCorners | Self::Collinear)
    }

    /// A line and a triangle.
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

/// Origin, direction, corners.
type Candidate = (Vec3, Vec3, [Vec3; 3]);

/// Another order of the axes, and a power of two for each.
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

fn lattice(random: &mut Random) -> Candidate {
    let corners = [(); 3].map(|()| random.lattice(3));
    let origin = random.lattice(5);
    let target = random.pick(&corners) + random.lattice(1);
    (origin, target - origin, corners)
}

/// Through the first corner, moved by eighths towards the second.
fn through(random: &mut Random, eighths: i32) -> Candidate {
    let mut corners = corners(random, 9);
    let [from, to, _] = corners;
    let target = from + (to - from) * (eighths as f32 / 8.0);
    let direction = random.lattice(9);
    random.shuffle(&mut corners);
    (target - direction * random.whole(-9, 9) as f32, direction, corners)
}

fn coplanar(random: &mut Random) -> Candidate {
    let [base, p, q] = corners(random, 9);
    let eighth = |random: &mut Random| random.whole(-2, 10) as f32 / 8.0;
    let origin = base + p * eighth(random) + q * eighth(random);
    let direction = p * random.whole(-2, 2) as f32 + q * random.whole(-2, 2) as f32;
    (origin, direction, [base, base + p, base + q])
}

fn equal_corners(random: &mut Random) -> Candidate {
    let eighths = random.whole(0, 8);
    let (origin, direction, mut corners) = through(random, eighths);
    corners[1] = corners[0];
    if random.once_in(2) {
        corners[2] = corners[0];
    }
    random.shuffle(&mut corners);
    (origin, direction, corners)
}

fn collinear(random: &mut Random) -> Candidate {
    let [a, step, _] = corners(random, 5);
    let at = |random: &mut Random| a + step * random.whole(-3, 3) as f32;
    let corners = [at(random), at(random), at(random)];
    let direction = random.lattice(9);
    let target = if random.once_in(4) { random.lattice(9) } else { at(random) };
    (target - direction * random.whole(-9, 9) as f32, direction, corners)
}

fn zero_components(random: &mut Random) -> Candidate {
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

fn from_the_plane(random: &mut Random) -> Candidate {
    let [base, p, q] = corners(random, 9);
    let first = random.whole(-1, 8);
    let second = random.whole(0, 8 - first);
    let origin = base + p * (first as f32 / 8.0) + q * (second as f32 / 8.0);
    (origin, random.lattice(9), [base, base + p, base + q])
}

fn height_field(random: &mut Random) -> Candidate {
    const STEP: f32 = 0.1;
    let (i, k) = (random.whole(0, 250), random.whole(0, 250));
    let line = |i: i32| i as f32 * STEP;
    let vertex =
        |i: i32, k: i32, random: &mut Random| Vec3::new(line(i), random.signed() * 4.0, line(k));
    let near = vertex(i, k, random);
    let far = vertex(i + 1, k + 1, random);
    let side = if random.once_in(2) { [i + 1, k] } else { [i, k + 1] };
    let corners = [near, vertex(side[0], side[1], random), far];
    // At a corner, or on a line through one.
    let (p, q) = (random.pick(&corners), random.pick(&corners));
    let between = (line(k) + line(k + 1)) / 2.0;
    let z = random.pick(&[p.z, q.z, between]);
    (Vec3::new(p.x, 50.0, z), Vec3::NEG_Y, corners)
}
