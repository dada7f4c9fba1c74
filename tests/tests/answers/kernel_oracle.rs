//! Tests of the exact kernel against exact integers, on pairs chosen to be hard.
//!
//! - Hard pairs: 1.2 million in release builds, 30,000 in debug builds.
//! - Pairs with volumes of exactly 0: a million more in release builds.
//! - Each pair is tested as a line and as a half-line; every bit of `t`, `u` and `v` must agree.
//! - Each family must have enough hits and misses, so that a constant answer cannot pass.

use arboleda::kinds::WideBvh;
use arboleda::{
    Block, Index, Intersection, Options, Ray, Scene, SimdLevel, Triangle, Vec3, intersect,
};
use arboleda_tests::pairs::zeros::Zeros;
use arboleda_tests::pairs::{self, Family};
use arboleda_tests::random::Random;
use arboleda_tests::{oracle, parallel};

const PAIRS_PER_FAMILY: usize = if cfg!(debug_assertions) { 2_000 } else { 80_000 };
const ZEROS_PER_WAY: usize = if cfg!(debug_assertions) { 2_000 } else { 112_000 };
const CHUNK: usize = 1_000;

/// Reciprocal of the least share of hits, and of misses, in a family.
const LEAST_SHARE: usize = 20;

fn bits(hit: Option<Intersection>) -> Option<[u32; 3]> {
    hit.map(|hit| [hit.t, hit.u, hit.v].map(f32::to_bits))
}

/// Memory of wide BVHs of one triangle, whose SIMD filters precede the kernel.
struct Lanes {
    arena: Vec<Block>,
    scratch: Vec<Block>,
}

impl Lanes {
    fn new() -> Self {
        let scratch = Index::<WideBvh>::scratch_capacity(1, &Options::default());
        let scratch = vec![Block::ZERO; Block::count(scratch)];
        Self { arena: vec![Block::ZERO; 32], scratch }
    }

    /// Returns the hit, and whether the ray is occluded, at the processor's SIMD level and at the compiled one.
    fn intersect(&mut self, ray: &Ray, triangle: Triangle) -> [(Option<Intersection>, bool); 2] {
        let triangles = [triangle];
        let (arena, scratch) = (Block::bytes(&mut self.arena), Block::bytes(&mut self.scratch));
        let scene = Scene::new(&triangles);
        let index = Index::<WideBvh>::build(&scene, &Options::default(), arena, scratch);
        let index = index.expect("room for one triangle");
        [index, index.with_simd_level(SimdLevel::COMPILED)].map(|index| {
            let hit = index.closest_hit(ray);
            (hit.map(|hit| Intersection { t: hit.t, u: hit.u, v: hit.v }), index.occluded(ray))
        })
    }
}

/// Family of pairs.
trait Pairs: Copy + PartialEq + std::fmt::Debug + Send + Sync {
    const PAIRS: usize;

    fn pair(self, random: &mut Random) -> (Ray, Triangle);

    fn hits(self) -> bool;
}

impl Pairs for Family {
    const PAIRS: usize = PAIRS_PER_FAMILY;

    fn pair(self, random: &mut Random) -> (Ray, Triangle) {
        Family::pair(self, random)
    }

    fn hits(self) -> bool {
        true
    }
}

impl Pairs for Zeros {
    const PAIRS: usize = ZEROS_PER_WAY;

    fn pair(self, random: &mut Random) -> (Ray, Triangle) {
        Zeros::pair(self, random)
    }

    fn hits(self) -> bool {
        Zeros::hits(self)
    }
}

struct Outcome<P> {
    pairs: P,
    hits: usize,
    wrong: Vec<String>,
}

impl<P: Pairs> Outcome<P> {
    /// Compares the kernel, and the wide BVH at both SIMD levels, with the oracle.
    fn check(
        &mut self,
        lanes: &mut Lanes,
        ray: &Ray,
        triangle: Triangle,
        exact: Option<Intersection>,
    ) {
        let hit = intersect(ray, &triangle);
        let found = [(hit, hit.is_some())].into_iter().chain(lanes.intersect(ray, triangle));
        for (way, (found, occluded)) in found.enumerate() {
            if bits(found) != bits(exact) || occluded != exact.is_some() {
                let pairs = self.pairs;
                self.wrong.push(format!(
                    "{pairs:?}: {ray:?} {triangle:?}\n  exact {exact:?}\n  way {way} {found:?}, \
                     occluded {occluded}"
                ));
            }
        }
    }
}

fn run<P: Pairs>(pairs: P, job: usize) -> Outcome<P> {
    let mut random = Random::new(job as u64);
    let mut lanes = Lanes::new();
    let mut outcome = Outcome { pairs, hits: 0, wrong: Vec::new() };
    for _ in 0..CHUNK {
        let (line, triangle) = pairs.pair(&mut random);
        let on_line = oracle::hit::intersect(&line, &triangle);
        outcome.hits += usize::from(on_line.is_some());
        // Lines are decided in f64 only, half-lines in SIMD lanes too.
        let ahead = pairs::half_line(&line, on_line.map(|hit| hit.t));
        let on_half = oracle::hit::intersect(&ahead, &triangle);
        outcome.check(&mut lanes, &ahead, triangle, on_half);
        outcome.check(&mut lanes, &line, triangle, on_line);
    }
    outcome
}

/// Runs all families.
///
/// # Panics
/// If a bit is wrong, or a family has too few hits or misses.
fn all_are_exact<P: Pairs>(ways: &[P]) {
    let jobs = ways.len() * P::PAIRS.div_ceil(CHUNK);
    let outcomes = parallel::map(jobs, |job| run(ways[job % ways.len()], job));
    let mut poor = Vec::new();
    for &way in ways {
        let of_way = || outcomes.iter().filter(|outcome| outcome.pairs == way);
        let pairs = of_way().count() * CHUNK;
        let hits: usize = of_way().map(|outcome| outcome.hits).sum();
        let wrong: usize = of_way().map(|outcome| outcome.wrong.len()).sum();
        println!("{way:?}: {pairs} pairs, {hits} hits, {wrong} wrong");
        let both = hits * LEAST_SHARE >= pairs && (pairs - hits) * LEAST_SHARE >= pairs;
        if way.hits() != both || !way.hits() && hits > 0 {
            poor.push(way);
        }
    }
    let wrong: Vec<&String> = outcomes.iter().flat_map(|outcome| &outcome.wrong).collect();
    let shown: Vec<&str> = wrong.iter().take(5).map(|text| text.as_str()).collect();
    assert!(wrong.is_empty(), "{} wrong, the first:\n{}", wrong.len(), shown.join("\n"));
    assert!(poor.is_empty(), "{poor:?} yield too few hits or misses to prove anything");
}

#[test]
fn every_hard_pair_is_decided_and_rounded_exactly() {
    all_are_exact(&Family::ALL);
}

#[test]
fn every_exact_zero_is_decided_and_rounded_exactly() {
    all_are_exact(&Zeros::ALL);
}

/// If `u` is below 2^-53, `1 - u` is not an `f64`. A weight `v` of 1 must still be lowered.
#[test]
fn weights_near_a_corner_do_not_sum_to_more_than_one() {
    for tiny in [f32::from_bits(1), 1e-40, 1e-30, 8.673_617_4e-19, 1e-9] {
        let triangle = Triangle::new(Vec3::Y, Vec3::X, Vec3::ZERO);
        let ray = Ray::new(Vec3::new(tiny, 0.0, -1.0), Vec3::Z).expect("a valid ray");
        let hit = intersect(&ray, &triangle).expect("on an edge");
        assert_eq!(hit.u, tiny);
        assert!(oracle::hit::weights_fit(hit.u, hit.v), "u {} v {}", hit.u, hit.v);
    }
}

/// A hit of a line depends neither on the order of the corners nor on the sign of the direction.
#[test]
fn a_hit_does_not_depend_on_the_order_of_corners() {
    let mut random = Random::new(7);
    for round in 0..PAIRS_PER_FAMILY {
        let family = Family::ALL[round % Family::ALL.len()];
        let (ray, Triangle { a, b, c }) = family.pair(&mut random);
        let t = |triangle| intersect(&ray, &triangle).map(|hit| hit.t.to_bits());
        let first = t(Triangle::new(a, b, c));
        for other in [Triangle::new(b, c, a), Triangle::new(c, b, a)] {
            assert_eq!(t(other), first, "{ray:?} {other:?}");
        }
    }
}
