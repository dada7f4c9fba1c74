//! Rays in special position, which meet planes, edges and corners exactly.
//!
//! Workload, with any kind of index; each byte of the input is one choice:
//!
//! - up to ten triangles on a small lattice, some with equal corners, some copies, some with a side in common, some in
//!   a coordinate plane;
//! - up to eight rays at the triangles: along an axis, along a side, in the plane, through a corner or a point of a
//!   side, with components that are zero, from a corner, with an interval that ends at the hit;
//! - changes: a coordinate moved by an ulp, and the scene scaled and moved by powers of two;
//! - pairs of the families of `pairs`.
//!
//! Constraints: finite corners and valid rays. The kernel decides each pair as exact integers do, and the index answers
//! as the linear scan does, bit for bit.
#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use arboleda::{IndexKind, Intersection, Level, Options, Ray, Triangle, Vec3, intersect};
use arboleda_tests::checks::index_equals_linear;
use arboleda_tests::oracle;
use arboleda_tests::pairs::Family;
use arboleda_tests::random::{Random, power_of_two};
use libfuzzer_sys::fuzz_target;

#[derive(Debug)]
struct Case {
    kind: IndexKind,
    triangles: Vec<Triangle>,
    rays: Vec<Ray>,
    options: Options,
}

/// Line from a point along a direction.
type Line = (Vec3, Vec3);

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(input: &mut Unstructured<'a>) -> arbitrary::Result<Self> {
        let kind = *input.choose(IndexKind::ALL)?;
        let options = Options {
            leaf_capacity: input.int_in_range(1..=4_u32)?,
            level: *input.choose(&[Level::Automatic, Level::AtMost(3), Level::AtMost(5)])?,
            ..Options::default()
        };
        let place = Place::arbitrary(input)?;
        // 1. Triangles, each of which may depend on the previous one.
        let mut triangles: Vec<Triangle> = Vec::new();
        for _ in 0..input.int_in_range(1..=10_u8)? {
            let before = triangles.last().copied().unwrap_or_default();
            triangles.push(triangle(input, before)?);
        }
        // 2. Lines, each at one of the triangles.
        let mut lines: Vec<(Triangle, Line)> = Vec::new();
        for _ in 0..input.int_in_range(1..=8_u8)? {
            let target = *input.choose(&triangles)?;
            lines.push((target, line(input, target)?));
        }
        // 3. Scaling and moving; a coordinate may be moved by an ulp, and lines become rays.
        let mut rays = Vec::new();
        for (target, (origin, direction)) in lines {
            let (mut origin, direction) = (place.point(origin), place.direction(direction));
            match input.int_in_range(0..=11_u8)? {
                axis @ 0..=2 => origin[usize::from(axis)] = origin[usize::from(axis)].next_up(),
                axis @ 3..=5 => {
                    let axis = usize::from(axis - 3);
                    origin[axis] = origin[axis].next_down();
                }
                _ => {}
            }
            rays.extend(with_interval(input, (origin, direction), &place.triangle(target))?);
        }
        let mut triangles: Vec<Triangle> = triangles.iter().map(|&t| place.triangle(t)).collect();
        triangles.retain(Triangle::is_finite);
        // 4. Pairs of the families.
        for _ in 0..input.int_in_range(0..=2_u8)? {
            let family = *input.choose(&Family::ALL)?;
            let (ray, triangle) = family.pair(&mut Random::new(u64::from(u16::arbitrary(input)?)));
            rays.push(ray);
            triangles.push(triangle);
        }
        Ok(Self { kind, triangles, rays, options })
    }
}

/// Scale and position of the lattice.
struct Place {
    exponent: i32,
    /// Exponent of the directions' scale, relative to that of points.
    stretch: i32,
    step: Vec3,
}

impl Place {
    fn arbitrary(input: &mut Unstructured<'_>) -> arbitrary::Result<Self> {
        Ok(Self {
            exponent: *input.choose(&[0, 0, 0, -1, 3, -20, 60, -75, 120, -149])?,
            stretch: *input.choose(&[0, 0, 0, 1, -3, 70, -70, 120])?,
            step: *input.choose(&[
                Vec3::ZERO,
                Vec3::ZERO,
                Vec3::new(1024.0, 0.0, 0.0),
                Vec3::new(-96.0, 65_536.0, 7.0),
            ])?,
        })
    }

    fn point(&self, point: Vec3) -> Vec3 {
        scaled(point + self.step, self.exponent)
    }

    fn direction(&self, direction: Vec3) -> Vec3 {
        scaled(direction, self.exponent + self.stretch)
    }

    fn triangle(&self, triangle: Triangle) -> Triangle {
        Triangle::new(self.point(triangle.a), self.point(triangle.b), self.point(triangle.c))
    }
}

fn scaled(point: Vec3, exponent: i32) -> Vec3 {
    let factor = power_of_two(exponent);
    Vec3::from_array(point.to_array().map(|x| (f64::from(x) * factor) as f32))
}

fn lattice(input: &mut Unstructured<'_>) -> arbitrary::Result<Vec3> {
    let mut whole = || input.int_in_range(-4..=4_i8).map(f32::from);
    Ok(Vec3::new(whole()?, whole()?, whole()?))
}

fn triangle(input: &mut Unstructured<'_>, before: Triangle) -> arbitrary::Result<Triangle> {
    Ok(match input.int_in_range(0..=7_u8)? {
        0 => {
            let (a, b) = (lattice(input)?, lattice(input)?);
            *input.choose(&[
                Triangle::new(a, a, b),
                Triangle::new(a, b, b),
                Triangle::new(a, b, a),
            ])?
        }
        1 => Triangle::new(before.a, before.a, before.a),
        2 => before,
        3 => Triangle::new(before.c, before.b, lattice(input)?),
        4 => Triangle::new(before.a, lattice(input)?, lattice(input)?),
        5 => {
            let axis = input.choose_index(3)?;
            let mut corners = [lattice(input)?, lattice(input)?, lattice(input)?];
            let level = corners[0][axis];
            for corner in &mut corners {
                corner[axis] = level;
            }
            Triangle::new(corners[0], corners[1], corners[2])
        }
        _ => Triangle::new(lattice(input)?, lattice(input)?, lattice(input)?),
    })
}

fn line(input: &mut Unstructured<'_>, target: Triangle) -> arbitrary::Result<Line> {
    let corners = [target.a, target.b, target.c];
    let first = input.choose_index(3)?;
    let [p, q, r] = [0, 1, 2].map(|next| corners[(first + next) % 3]);
    let quarters =
        |input: &mut Unstructured<'_>| input.int_in_range(-1..=5_i8).map(|n| f32::from(n) / 4.0);
    let steps = |input: &mut Unstructured<'_>| input.int_in_range(-3..=3_i8).map(f32::from);
    Ok(match input.int_in_range(0..=6_u8)? {
        // Along an axis, through a corner or a point of a side.
        0 => {
            let mut direction = Vec3::ZERO;
            direction[input.choose_index(3)?] = *input.choose(&[1.0, -1.0, 3.0])?;
            let at = p + (q - p) * quarters(input)?;
            (at - direction * steps(input)?, direction)
        }
        // Along a side.
        1 => (p + (q - p) * steps(input)?, *input.choose(&[q - p, p - q])?),
        // In the plane.
        2 => {
            let origin = p + (q - p) * quarters(input)? + (r - p) * quarters(input)?;
            (origin, (q - p) * steps(input)? + (r - p) * steps(input)?)
        }
        // Through a point of a side.
        3 => {
            let (at, direction) = (p + (q - p) * quarters(input)?, lattice(input)?);
            (at - direction * steps(input)?, direction)
        }
        // From a corner.
        4 => (p, lattice(input)?),
        // Parallel to a coordinate plane.
        5 => {
            let (origin, mut direction) = (lattice(input)?, lattice(input)?);
            direction[input.choose_index(3)?] = *input.choose(&[0.0, -0.0])?;
            (origin, direction)
        }
        // From a point of the lattice to a corner.
        _ => {
            let origin = lattice(input)?;
            (origin, p - origin)
        }
    })
}

/// Makes a ray of a line, if it is valid; its interval may end at the hit of the triangle.
fn with_interval(
    input: &mut Unstructured<'_>,
    (origin, direction): Line,
    target: &Triangle,
) -> arbitrary::Result<Option<Ray>> {
    let whole = Ray::with_interval(origin, direction, f32::NEG_INFINITY, f32::INFINITY);
    let choice = input.int_in_range(0..=7_u8)?;
    let Ok(whole) = whole else { return Ok(None) };
    let met = (choice > 3 && target.is_finite())
        .then(|| oracle::hit::intersect(&whole, target))
        .flatten()
        .map_or(0.5, |hit| hit.t);
    let (from, to) = match choice {
        0 => (0.0, f32::INFINITY),
        1 => (f32::NEG_INFINITY, f32::INFINITY),
        2 => (0.0, 1.0),
        3 => (-1.0, 0.0),
        4 => (met, met),
        5 => (f32::NEG_INFINITY, met),
        6 => (met.next_up(), f32::INFINITY),
        _ => (f32::NEG_INFINITY, met.next_down()),
    };
    Ok(Ray::with_interval(origin, direction, from, to).ok())
}

fuzz_target!(|case: Case| {
    let bits = |hit: Intersection| [hit.t, hit.u, hit.v].map(f32::to_bits);
    for ray in &case.rays {
        for triangle in &case.triangles {
            let found = intersect(ray, triangle);
            let exact = oracle::hit::intersect(ray, triangle);
            assert_eq!(
                found.map(bits),
                exact.map(bits),
                "found {found:?}, exact {exact:?}, of {ray:?}, {triangle:?}"
            );
        }
    }
    index_equals_linear(case.kind, &case.triangles, &case.rays, &case.options);
});
