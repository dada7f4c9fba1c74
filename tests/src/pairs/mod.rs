//! Pairs of a ray and a triangle that are hard to decide.
//!
//! Each [`Family`] is hard in one way. Points lie on a lattice, so that a ray can pass exactly *through* an edge, or
//! are moved by one ulp, so that it barely misses. Each family has both hits and misses; the tests check their shares.

pub mod zeros;

use arboleda::{Ray, Triangle, Vec3};

use crate::oracle;
use crate::random::{Random, power_of_two};

/// Family of pairs that are hard in the same way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Pairs of whole coordinates, with many exact zeros.
    Lattice,
    /// Triangles a few ulps wide.
    Sliver,
    /// Rays through a point of an edge, or one ulp beside it.
    Edge,
    /// Rays through a corner, or one ulp beside it.
    Corner,
    /// Rays along a coordinate axis, at coordinates of the corners.
    AxisParallel,
    /// Rays in the triangle's plane, or out of it by ulps.
    Coplanar,
    /// Rays from far away.
    FarOrigin,
    /// Pairs with magnitudes from 1e-30 to 1e30.
    MixedScales,
    /// Pairs with coordinates of a few times the smallest float.
    Subnormal,
    /// Rays whose interval ends at the hit, or one ulp before or after it.
    IntervalEnd,
    /// Directions from the smallest to the largest floats, with which `t` overflows and underflows.
    DirectionScale,
    /// Pairs with `t`, `u` or `v` half-way between two floats, or very close to it.
    Tie,
    /// Rays so near a corner that one weight is tiny.
    NearCorner,
    /// Random pairs, which are hard at the end of the interval.
    Anywhere,
    /// Rays that begin so near that `t` is a few times the smallest float, or is rounded to 0.
    Touching,
}

impl Family {
    /// All families.
    pub const ALL: [Self; 15] = [
        Self::Lattice,
        Self::Sliver,
        Self::Edge,
        Self::Corner,
        Self::AxisParallel,
        Self::Coplanar,
        Self::FarOrigin,
        Self::MixedScales,
        Self::Subnormal,
        Self::IntervalEnd,
        Self::DirectionScale,
        Self::Tie,
        Self::NearCorner,
        Self::Anywhere,
        Self::Touching,
    ];

    /// Draws a pair of the family.
    pub fn pair(self, random: &mut Random) -> (Ray, Triangle) {
        loop {
            let (origin, direction, triangle) = match self {
                Self::Lattice => lattice(random),
                Self::Sliver => sliver(random),
                Self::Edge => through(random, false),
                Self::Corner => through(random, true),
                Self::AxisParallel => axis_parallel(random),
                Self::Coplanar => coplanar(random),
                Self::FarOrigin => far_origin(random),
                Self::MixedScales => mixed_scales(random),
                Self::Subnormal => subnormal(random),
                Self::DirectionScale => direction_scale(random),
                Self::Tie => tie(random),
                Self::NearCorner => near_corner(random),
                Self::Anywhere => anywhere(random),
                Self::Touching => touching(random),
                Self::IntervalEnd => {
                    if let Some(pair) = interval_end(random) {
                        return pair;
                    }
                    continue;
                }
            };
            // The ray is a whole line, so hits behind the origin count.
            let (back, ahead) = (f32::NEG_INFINITY, f32::INFINITY);
            if let Ok(ray) = Ray::with_interval(origin, direction, back, ahead)
                && triangle.is_finite()
            {
                return (ray, triangle);
            }
        }
    }
}

/// Returns the half of a line on which a hit at `t` lies; without a hit, the half ahead.
///
/// # Panics
/// Never for the ray of a pair.
pub fn half_line(line: &Ray, t: Option<f32>) -> Ray {
    let (mut direction, mut from, mut to) = (line.direction(), line.t_min(), line.t_max());
    if t.is_some_and(|t| t < 0.0) {
        (direction, from, to) = (-direction, -to, -from);
    }
    Ray::with_interval(line.origin(), direction, from.max(0.0), to.max(0.0)).expect("half a line")
}

/// Origin, direction and triangle of a pair, which may be invalid.
type Candidate = (Vec3, Vec3, Triangle);

/// Moves one coordinate of a point by one ulp.
fn nudge(point: &mut Vec3, random: &mut Random) {
    let coordinate = &mut point[random.below(3)];
    *coordinate = if random.once_in(2) { coordinate.next_up() } else { coordinate.next_down() };
}

fn scaled(point: Vec3, exponent: i32) -> Vec3 {
    let factor = power_of_two(exponent);
    Vec3::from_array(point.to_array().map(|c| (f64::from(c) * factor) as f32))
}

/// Draws a point between three corners, in `f64`.
fn inside(corners: [Vec3; 3], random: &mut Random) -> [f64; 3] {
    let mut weights = [random.unit(), random.unit(), random.unit()].map(f64::from);
    if random.once_in(4) {
        weights[random.below(3)] = 0.0;
    }
    let sum = weights.iter().sum::<f64>() + 1e-30;
    let at = |axis: usize| {
        let terms = corners.iter().zip(weights).map(|(c, w)| f64::from(c[axis]) * (w / sum));
        terms.sum()
    };
    [at(0), at(1), at(2)]
}

fn towards(origin: Vec3, target: [f64; 3]) -> Vec3 {
    let along = |axis: usize| (target[axis] - f64::from(origin[axis])) as f32;
    Vec3::new(along(0), along(1), along(2))
}

fn lattice(random: &mut Random) -> Candidate {
    let reach = random.pick(&[1, 2, 4]);
    let triangle =
        Triangle::new(random.lattice(reach), random.lattice(reach), random.lattice(reach));
    // Rays aim at a corner or an average of the corners; otherwise nearly all would miss.
    let target = match random.below(3) {
        0 => triangle.a,
        1 => triangle.a + triangle.b + triangle.c - random.lattice(reach) - random.lattice(reach),
        _ => (triangle.a + triangle.b) * 0.5,
    };
    let origin = random.lattice(2 * reach);
    (origin, target - origin, triangle)
}

fn sliver(random: &mut Random) -> Candidate {
    let (a, b) = (random.point(), random.point());
    let share = random.signed() * 2.0;
    let mut c = a + (b - a) * share;
    for _ in 0..random.below(6) {
        nudge(&mut c, random);
    }
    let target = inside([a, b, c], random);
    // The origin is near, so the rounding of the direction moves the line by less than the sliver's width.
    let near = scaled(random.point(), -random.whole(0, 20));
    let origin = near + Vec3::from_array(target.map(|c| c as f32));
    (origin, towards(origin, target), Triangle::new(a, b, c))
}

/// Draws a ray exactly through a corner or a point of an edge, or one ulp beside it.
fn through(random: &mut Random, corner: bool) -> Candidate {
    let corners = [(); 3].map(|()| random.lattice(16) * 4.0);
    let first = random.below(3);
    let (p, q) = (corners[first], corners[(first + 1) % 3]);
    let quarters = if corner { 0 } else { random.whole(0, 4) };
    let target = p + (q - p) * (quarters as f32 / 4.0);
    let mut direction = random.lattice(8);
    let mut origin = target - direction * random.whole(-9, 9) as f32;
    let mut triangle = Triangle::new(corners[0], corners[1], corners[2]);
    if random.once_in(3) {
        nudge(&mut origin, random);
    } else if random.once_in(3) {
        nudge(&mut direction, random);
    } else if random.once_in(4) {
        nudge(&mut triangle.b, random);
    }
    let (exponent, lengths) = (random.whole(-60, 60), random.whole(-30, 30));
    let at = |point| scaled(point, exponent);
    let triangle = Triangle::new(at(triangle.a), at(triangle.b), at(triangle.c));
    (at(origin), scaled(direction, lengths), triangle)
}

fn axis_parallel(random: &mut Random) -> Candidate {
    let corners = [(); 3].map(|()| random.point());
    let mut origin = random.point();
    let target = inside(corners, random);
    for axis in 0..3 {
        origin[axis] = match random.below(3) {
            0 => random.pick(&corners)[axis],
            _ => target[axis] as f32,
        };
    }
    let mut direction = Vec3::ZERO;
    direction[random.below(3)] = random.magnitude(-10, 10);
    (origin, direction, Triangle::new(corners[0], corners[1], corners[2]))
}

fn coplanar(random: &mut Random) -> Candidate {
    let base = random.lattice(8);
    let (p, q) = (random.lattice(8) * 4.0, random.lattice(8) * 4.0);
    let quarter = |random: &mut Random| random.whole(-1, 4) as f32 / 4.0;
    let mut origin = base + p * quarter(random) + q * quarter(random);
    let mut direction = p * random.whole(-2, 2) as f32 + q * random.whole(-2, 2) as f32;
    if !random.once_in(3) {
        nudge(&mut direction, random);
    }
    if random.once_in(3) {
        nudge(&mut origin, random);
    }
    (origin, direction, Triangle::new(base, base + p, base + q))
}

fn far_origin(random: &mut Random) -> Candidate {
    let exponent = random.whole(-20, 20);
    let corners = [(); 3].map(|()| scaled(random.point(), exponent));
    let triangle = Triangle::new(corners[0], corners[1], corners[2]);
    if random.once_in(2) {
        // The line passes the target at a distance of some ulps of the origin, about the width of the triangle.
        let distance = exponent + random.whole(18, 26);
        let origin = scaled(random.point(), distance);
        let target = inside(corners, random);
        return (origin, towards(origin, target), triangle);
    }
    // The line passes exactly through (0, 0, 0), however far its origin.
    let direction = random.lattice(7);
    let origin = scaled(direction, random.whole(20, 120)) * -1.0;
    (origin, direction, triangle)
}

fn mixed_scales(random: &mut Random) -> Candidate {
    let any = |random: &mut Random| {
        let mut number = || random.magnitude(-100, 100);
        Vec3::new(number(), number(), number())
    };
    let mut corners = [(); 3].map(|()| any(random));
    let mut origin = any(random);
    // Coordinates are often similar on one axis; otherwise the largest number alone would decide.
    for _ in 0..random.below(3) {
        let (axis, value) = (random.below(3), random.magnitude(-100, 100));
        for corner in &mut corners {
            corner[axis] = value * random.signed();
        }
        origin[axis] = value * random.signed();
    }
    let target = inside(corners, random);
    (origin, towards(origin, target), Triangle::new(corners[0], corners[1], corners[2]))
}

fn subnormal(random: &mut Random) -> Candidate {
    let (origin, direction, triangle) = lattice(random);
    let at = |point| scaled(point, -149);
    let triangle = Triangle::new(at(triangle.a), at(triangle.b), at(triangle.c));
    (at(origin), scaled(direction, random.pick(&[-149, -140, -20, 0])), triangle)
}

fn direction_scale(random: &mut Random) -> Candidate {
    let (origin, direction, triangle) = through(random, false);
    let far = random.whole(0, 50);
    let at = |point| scaled(point, far);
    let triangle = Triangle::new(at(triangle.a), at(triangle.b), at(triangle.c));
    // The direction's components lie between 2^-30 and 2^33 before scaling.
    (at(origin), scaled(direction, random.whole(-119, 94)), triangle)
}

fn tie(random: &mut Random) -> Candidate {
    // 2^24 + 1, the distance between 2^24 and -1, is half-way between two floats.
    const LARGE: f32 = 16_777_216.0;
    let odd = |random: &mut Random| (2 * random.whole(-500, 500) + 1) as f32;
    let hair = random.pick(&[0.0, 0.0, power_of_two(-60) as f32, -power_of_two(-100) as f32]);
    let (origin, direction, triangle) = if random.once_in(2) {
        // A tie of t: the triangle is a slope that begins at the half-way point.
        let height = LARGE + 2.0 * random.whole(0, 1000) as f32;
        let slope = 2.0 * random.whole(0, 1) as f32;
        let triangle = Triangle::new(
            Vec3::new(0.0, -1.0, height),
            Vec3::new(1.0, 0.0, height + slope),
            Vec3::new(-1.0, 3.0, height - slope),
        );
        (Vec3::new(hair, -1.0, odd(random)), Vec3::Z, triangle)
    } else {
        // A tie of u or v: the triangle is 2^25 wide, and the ray passes an odd number from its middle.
        let corners = [
            Vec3::new(-LARGE, 0.0, 0.0),
            Vec3::new(LARGE, 0.0, 0.0),
            Vec3::new(random.pick(&[0.0, -LARGE, LARGE]), LARGE, 0.0),
        ];
        let first = random.below(3);
        let [a, b, c] = [first, first + 1, first + 2].map(|i| corners[i % 3]);
        let odd_height = odd(random);
        let above = random.pick(&[hair, hair, odd_height]);
        (Vec3::new(odd(random), above, -1.0), Vec3::Z, Triangle::new(a, b, c))
    };
    let turn = random.below(3);
    let at = |p: Vec3| Vec3::from_array([p[turn], p[(turn + 1) % 3], p[(turn + 2) % 3]]);
    (at(origin), at(direction), Triangle::new(at(triangle.a), at(triangle.b), at(triangle.c)))
}

fn near_corner(random: &mut Random) -> Candidate {
    let (p, q) = (random.lattice(9), random.lattice(9));
    let corners = [Vec3::ZERO, p, q];
    let first = random.below(3);
    let [a, b, c] = [first, first + 1, first + 2].map(|i| corners[i % 3]);
    let share = |random: &mut Random| (1.0 + random.unit()) * random.pick(&[0.0, 1.0, 1.0, -1.0]);
    let target = p * share(random) + q * share(random);
    let axis = random.below(3);
    let mut origin = scaled(target, random.whole(-130, -10));
    origin[axis] = random.whole(-9, 9) as f32;
    let mut direction = Vec3::ZERO;
    direction[axis] = random.pick(&[1.0, -1.0, 3.0]);
    (origin, direction, Triangle::new(a, b, c))
}

fn anywhere(random: &mut Random) -> Candidate {
    let corners = [(); 3].map(|()| random.point());
    let origin = random.point() * 4.0;
    let target = inside(if random.once_in(4) { [random.point(); 3] } else { corners }, random);
    (origin, towards(origin, target), Triangle::new(corners[0], corners[1], corners[2]))
}

fn touching(random: &mut Random) -> Candidate {
    // Near corner a of a large triangle, the bounds of other roundings do not cover the rounding of `t`.
    let size = power_of_two(random.whole(0, 22)) as f32;
    let mut corners = [(); 3].map(|()| random.lattice(8) * size);
    let (mut origin, mut direction) = (random.lattice(3) * size, random.lattice(8));
    if random.once_in(2) {
        (origin, direction) = (corners[0], Vec3::ZERO);
    }
    let axis = random.below(3);
    for corner in &mut corners {
        corner[axis] = 0.0;
    }
    let steps = random.whole(-20, 20);
    direction[axis] = random.whole(1, 8) as f32;
    origin[axis] = steps as f32 * f32::from_bits(1);
    (origin, direction, Triangle::new(corners[0], corners[1], corners[2]))
}

/// Draws a pair whose interval ends at the hit; `None` for a line that misses, or a bound that is NaN.
fn interval_end(random: &mut Random) -> Option<(Ray, Triangle)> {
    let family = random.pick(&[
        Family::Lattice,
        Family::Edge,
        Family::FarOrigin,
        Family::DirectionScale,
        Family::Tie,
        Family::Sliver,
        Family::Anywhere,
        Family::Anywhere,
        Family::Touching,
    ]);
    let (line, triangle) = family.pair(random);
    let t = oracle::hit::intersect(&line, &triangle)?.t;
    let bound = random.pick(&[t, t.next_up(), t.next_down()]);
    let (t_min, t_max) = match random.below(3) {
        0 => (bound, f32::INFINITY),
        1 => (f32::NEG_INFINITY, bound),
        _ => (bound, bound),
    };
    let ray = Ray::with_interval(line.origin(), line.direction(), t_min, t_max).ok()?;
    Some((ray, triangle))
}
