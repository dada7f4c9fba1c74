//! Comparison of every index with tests of all triangles.
//!
//! Workload: up to 24 triangles and 8 rays, with any options. All are on a small lattice, with shared planes, edges and
//! corners and rays along faces; or all are raw floats of any magnitude.
//!
//! Constraints: corners are finite, rays are valid, and levels stay below 6 so that a run is short. All sizes must be
//! exact and all answers equal, bit for bit.
#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use arboleda::{Level, Options, Ray, Triangle, Vec3};
use arboleda_tests::checks::every_index_equals_linear;
use libfuzzer_sys::fuzz_target;

#[derive(Debug)]
struct Case {
    triangles: Vec<Triangle>,
    rays: Vec<Ray>,
    options: Options,
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(input: &mut Unstructured<'a>) -> arbitrary::Result<Self> {
        let lattice = bool::arbitrary(input)?;
        let number = |input: &mut Unstructured<'a>| {
            Ok(if lattice {
                f32::from(input.int_in_range(-4..=4_i8)?)
            } else {
                f32::arbitrary(input)?
            })
        };
        let point = |input: &mut Unstructured<'a>| {
            Ok::<_, arbitrary::Error>(Vec3::new(number(input)?, number(input)?, number(input)?))
        };
        let level = input.int_in_range(0..=6)?;
        let options = Options {
            leaf_capacity: input.int_in_range(1..=6)?,
            level: if level == 6 { Level::Automatic } else { Level::AtMost(level) },
            proximity: f32::from(input.int_in_range(0..=8_u8)?) * 0.25,
            size_classes: input.int_in_range(1..=4)?,
            ..Options::default()
        };
        let mut rays = Vec::new();
        for _ in 0..input.int_in_range(1..=8)? {
            let (origin, direction) = (point(input)?, point(input)?);
            let (t_min, t_max) = *input.choose(&[
                (0.0, f32::INFINITY),
                (f32::NEG_INFINITY, f32::INFINITY),
                (0.0, 1.0),
                (1.0, 1.0),
            ])?;
            rays.extend(Ray::with_interval(origin, direction, t_min, t_max));
        }
        let mut triangles = Vec::new();
        for _ in 0..input.int_in_range(0..=24)? {
            let triangle = Triangle::new(point(input)?, point(input)?, point(input)?);
            triangles.extend(triangle.is_finite().then_some(triangle));
        }
        Ok(Self { triangles, rays, options })
    }
}

fuzz_target!(|case: Case| every_index_equals_linear(&case.triangles, &case.rays, &case.options));
