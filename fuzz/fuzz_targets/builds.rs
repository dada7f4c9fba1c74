//! Builds of scenes that planes separate badly.
//!
//! Workload: up to three crowds, together some hundred triangles in any order; any kind of index, any options. A crowd
//! is copies, concentric triangles, slivers, fans, needles, small among large, or triangles that planes separate well.
//! Each crowd is scaled, stretched, flattened and moved. Each byte of the input is one choice.
//!
//! Constraints: with automatic level and resolution, at most 80 `n log2 n` counted steps; with given ones, at most the
//! limit of steps, or an error that says so. The built index answers as the linear scan does. A wide BVH has the same
//! bytes if it is built in slices.
#![no_main]

use arbitrary::{Arbitrary, Unstructured};
use arboleda::{
    Block, BuildError, BvhBuild, Hit, IndexKind, Level, Options, Resolution, Scene, SlicedBuild,
    Triangle, Vec3,
};
use arboleda_tests::build::Built;
use arboleda_tests::checks::{all_hits, bits, work};
use arboleda_tests::random::Random;
use arboleda_tests::scenes::crowds::{self, Crowd};
use arboleda_tests::{rays, scenes};
use libfuzzer_sys::fuzz_target;

/// Most steps of a build with a given level or resolution.
///
/// A ray from far away enters all cells and is decided exactly in each. That takes some ten microseconds a cell, and
/// many times that under sanitizers.
///
/// # Measured
/// - With 300,000 steps one run took half a minute.
const MOST_STEPS_OF_GIVEN: u64 = 10_000;

/// Ordinary scenes, which are drawn beside the crowds.
const ORDINARY: &[Crowd] = &[|count| scenes::soup(count, 3), |count| scenes::lattice(count, 3, 8)];

#[derive(Debug)]
struct Case {
    kind: IndexKind,
    triangles: Vec<Triangle>,
    options: Options,
    seed: u64,
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(input: &mut Unstructured<'a>) -> arbitrary::Result<Self> {
        let kind = *input.choose(IndexKind::ALL)?;
        let options = options(input)?;
        let seed = u64::from(u8::arbitrary(input)?);
        let mut triangles = Vec::new();
        for _ in 0..input.int_in_range(1..=3_u8)? {
            triangles.extend(part(input)?);
        }
        match input.int_in_range(0..=3_u8)? {
            0 => triangles.reverse(),
            1 => Random::new(seed).shuffle(&mut triangles),
            _ => {}
        }
        Ok(Self { kind, triangles, options, seed })
    }
}

fn options(input: &mut Unstructured<'_>) -> arbitrary::Result<Options> {
    // Half of the cases have default options.
    if input.int_in_range(0..=1_u8)? == 0 {
        return Ok(Options::default());
    }
    let level = match input.int_in_range(0..=31_u32)? {
        given @ 0..=20 => Level::AtMost(given),
        _ => Level::Automatic,
    };
    let resolution = match input.int_in_range(0..=7_u8)? {
        0 => Resolution::CellsPerTriangle(*input.choose(&[0.01, 1.0, 64.0, 1024.0])?),
        1 => Resolution::Cells([1 << input.int_in_range(0..=4_u32)?, 3, 1]),
        2 => Resolution::Cells([input.int_in_range(1..=40_u32)?; 3]),
        _ => Resolution::Automatic,
    };
    Ok(Options {
        leaf_capacity: input.int_in_range(1..=40_u32)?,
        level,
        least_side: *input.choose(&[0.0, 1.0 / 3.0, 1.0])?,
        proximity: *input.choose(&[0.0, 1e-6, 0.25, 0.5, 2.0, 1e6, f32::MAX])?,
        size_classes: input.int_in_range(1..=4_u32)?,
        resolution,
        bvh_build: *input.choose(&[BvhBuild::Binned, BvhBuild::Insertion])?,
        ..Options::default()
    })
}

/// Draws one crowd, scaled and moved.
fn part(input: &mut Unstructured<'_>) -> arbitrary::Result<Vec<Triangle>> {
    let choice = input.choose_index(crowds::ALL.len() + ORDINARY.len())?;
    let crowd = match crowds::ALL.get(choice) {
        Some(&(_, crowd)) => crowd,
        None => ORDINARY[choice - crowds::ALL.len()],
    };
    // The counts are far apart, so that a mutation changes the scene much.
    let count = *input.choose(&[1, 2, 3, 7, 12, 13, 25, 50, 75, 100])?;
    let factor = |input: &mut Unstructured<'_>| {
        input
            .choose(&[1.0, 1.0, 1.0, 0.0, -1.0, 1e-3, 1e3, 1e-6, 1e-20, 1e-42, 1e20, 1e35])
            .copied()
    };
    let mut stretch = Vec3::splat(factor(input)?);
    stretch[input.choose_index(3)?] *= factor(input)?;
    let mut step = Vec3::ZERO;
    step[input.choose_index(3)?] = *input.choose(&[0.0, 0.0, 0.5, -3.0, 100.0, 1e6, 1e30])?;
    let at = |p: Vec3| p * stretch + step;
    let triangles = crowd(count).into_iter();
    let moved = triangles.map(|t| Triangle::new(at(t.a), at(t.b), at(t.c)));
    Ok(moved.filter(Triangle::is_finite).collect())
}

/// The bytes of a build in slices of 1, 2, 4, ... looks, as the seed says.
fn in_slices(triangles: &[Triangle], options: &Options, room: usize, seed: u64) -> Vec<u8> {
    let mut arena = vec![Block::ZERO; Block::count(room)];
    let mut scratch =
        vec![Block::ZERO; Block::count(SlicedBuild::scratch_capacity(triangles.len()))];
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    let scene = Scene::new(triangles);
    let mut build = SlicedBuild::new(&scene, options, arena, scratch).expect("there is memory");
    while !build.step(1 << (seed % 16)).expect("it was built at once") {}
    build.finish().expect("it is done").as_bytes().to_vec()
}

fuzz_target!(|case: Case| {
    let Case { kind, triangles, options, seed } = case;
    let is_found = work::is_found(&options);
    let most = if is_found { work::most_steps(triangles.len()) } else { MOST_STEPS_OF_GIVEN };
    let limited = Options { work_limit: Some(most), ..options };
    let built = match Built::new(kind, &Scene::new(&triangles), &limited) {
        Ok(built) => built,
        Err(BuildError::TooMuchWork { limit }) if !is_found && limit == most => return,
        Err(error) => panic!("{}: {error}, for {} triangles", kind.name(), triangles.len()),
    };
    if kind == IndexKind::WideBvh {
        let sliced = in_slices(&triangles, &limited, built.bytes().len(), seed);
        assert!(sliced == built.bytes(), "{} triangles in slices", triangles.len());
    }
    let index = built.index();
    if let Err(error) = index.check() {
        panic!("{} breaks its own invariants: {error}", kind.name());
    }
    // Only two rays are compared, because an exact zero in a crowd is one for hundreds of triangles.
    for ray in rays::around(&triangles, 2, seed) {
        let expected = all_hits(&triangles, &ray);
        let closest = index.closest_hit(&ray);
        assert_eq!(closest.as_ref().map(bits), expected.first().map(bits), "{ray:?}");
        let mut buffer = vec![Hit::NONE; expected.len() + 1];
        let found = index.all_hits(&ray, &mut buffer).hits;
        assert!(found.iter().map(bits).eq(expected.iter().map(bits)), "{ray:?}");
    }
});
