//! Timed tests of rays and triangles that the floating-point filters cannot decide: they take about as long as others.
//!
//! Times are compared as ratios in one run. Each ratio was 20 to 100 when expansions decided all such pairs. The limits
//! leave a margin for a busy machine.

use std::hint::black_box;
use std::time::{Duration, Instant};

use arboleda::{AnyIndex, IndexKind, Options, Ray, Scene, Triangle, Vec3};
use arboleda_tests::build::Built;
use arboleda_tests::random::Random;

const SIDE: i32 = 96;
const STEP: f32 = 0.1;
const ABOVE: f32 = 50.0;
const RAYS: usize = 200;
const ROUNDS: usize = 60;

fn height_field() -> Vec<Triangle> {
    let vertex = |i: i32, k: i32| {
        let height = Random::new(i as u64 * 1_000 + k as u64).unit();
        Vec3::new(i as f32 * STEP, height * 0.3, k as f32 * STEP)
    };
    let cells = (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| (i, k)));
    let halves = cells.flat_map(|(i, k)| {
        let [near, far] = [vertex(i, k), vertex(i + 1, k + 1)];
        [vertex(i + 1, k), vertex(i, k + 1)].map(|side| Triangle::new(near, side, far))
    });
    halves.collect()
}

fn rays(mut ray: impl FnMut(&mut Random) -> (Vec3, Vec3)) -> Vec<Ray> {
    let mut random = Random::new(5);
    let rays = (0..RAYS).map(|_| {
        let (origin, direction) = ray(&mut random);
        Ray::new(origin, direction).expect("a valid ray")
    });
    rays.collect()
}

fn tilted() -> Vec<Ray> {
    let size = SIDE as f32 * STEP;
    rays(|random| {
        let origin = Vec3::new(random.unit() * size, ABOVE, random.unit() * size);
        (origin, Vec3::new(random.signed() * 0.02, -1.0, random.signed() * 0.02))
    })
}

fn on_grid_lines() -> Vec<Ray> {
    rays(|random| {
        let mut line = || random.whole(0, SIDE) as f32 * STEP;
        (Vec3::new(line(), ABOVE, line()), Vec3::NEG_Y)
    })
}

/// Vertical up to rounding: the cosine of a right angle is no zero. Such rays were 9 times as long when lanes refused them.
fn nearly_vertical() -> Vec<Ray> {
    let rest = std::f64::consts::FRAC_PI_2.cos() as f32;
    assert!(rest != 0.0);
    let vertical = |ray: Ray| Ray::new(ray.origin(), Vec3::new(rest, -1.0, rest));
    tilted().into_iter().map(|ray| vertical(ray).expect("a valid ray")).collect()
}

/// Measures the ratio of two times, each the least of several rounds.
fn ratio(mut first: impl FnMut(), mut second: impl FnMut()) -> f64 {
    let mut least = [Duration::MAX; 2];
    let timed = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        start.elapsed()
    };
    for _ in 0..ROUNDS {
        least = [least[0].min(timed(&mut first)), least[1].min(timed(&mut second))];
    }
    least[0].as_secs_f64() / least[1].as_secs_f64()
}

fn ask(index: &AnyIndex<'_>, rays: &[Ray]) {
    for ray in rays {
        black_box((index.closest_hit(ray), index.occluded(ray)));
    }
}

fn is_at_most(limit: f64, what: &str, kind: IndexKind, ratio: f64) {
    println!("{} {what}: {ratio:.1}", kind.name());
    assert!(ratio <= limit, "{}, {what}: {ratio:.1} times as long", kind.name());
}

const KINDS: [IndexKind; 4] =
    [IndexKind::WideBvh, IndexKind::LeanBvh, IndexKind::Bvh, IndexKind::KdTree];

/// Asserts that rays take at most `limit` times as long as tilted ones, through every kind.
fn take_at_most(limit: f64, what: &str, rays: &[Ray]) {
    let (triangles, tilted) = (height_field(), tilted());
    for kind in KINDS {
        let built = Built::new(kind, &Scene::new(&triangles), &Options::default());
        let built = built.expect("it is built");
        let index = built.index();
        is_at_most(limit, what, kind, ratio(|| ask(&index, rays), || ask(&index, &tilted)));
    }
}

#[test]
fn rays_on_grid_lines_take_little_longer_than_others() {
    take_at_most(8.0, "on grid lines", &on_grid_lines());
}

#[test]
fn rays_that_are_vertical_up_to_rounding_take_no_longer_than_others() {
    take_at_most(3.0, "vertical up to rounding", &nearly_vertical());
}

#[test]
fn triangles_without_area_take_no_time() {
    let proper = height_field();
    let mut spoilt = proper.clone();
    for triangle in spoilt.iter_mut().step_by(7) {
        triangle.b = triangle.a;
        triangle.c = triangle.a;
    }
    for triangle in spoilt.iter_mut().skip(3).step_by(7) {
        triangle.c = triangle.b;
    }
    let tilted = tilted();
    for kind in KINDS {
        let build = |triangles| Built::new(kind, &Scene::new(triangles), &Options::default());
        let [spoilt, proper] =
            [&spoilt[..], &proper[..]].map(|triangles| build(triangles).expect("it is built"));
        let (without, with) = (spoilt.index(), proper.index());
        let ratio = ratio(|| ask(&without, &tilted), || ask(&with, &tilted));
        is_at_most(4.0, "with triangles without area", kind, ratio);
    }
}
