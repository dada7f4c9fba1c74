//! An index of your own in one file: slabs along the longest axis, each with eight triangles.
//!
//! ```text
//! words:  for each slab: lo | hi (bits of f32) | id id id id id id id id
//!                        box of the slab's triangles along the axis; the last slab may have fewer ids
//! ```
//! `Described` says what the index is, `LocalIndex` how it is built, traversed and checked. It decides nothing exactly:
//! it shows triangles to a query, which does. So it equals the linear scan with `==`, alone and in clusters.
//!
//! `cargo run -p arboleda --release --example custom_index`

use std::ops::ControlFlow;

use arboleda::custom::{Described, Group, Local, LocalIndex, Query, RaySpan, Span, Words};
use arboleda::kinds::{Clustered, Linear, Representation};
use arboleda::{Aabb, Block, BuildError, Counters, Index, Options, Ray, Scene, Statistics};
use arboleda::{Triangle, Vec3};

/// The index.
enum Slabs {}

/// Triangles in a slab.
const CAPACITY: usize = 8;
/// Words of a slab: its two planes and its ids.
const STRIDE: usize = 2 + CAPACITY;

impl Described for Slabs {
    const NAME: &'static str = "slabs";
    const HIERARCHY_NAME: &'static str = "slabs-hierarchy";
    const FORMAT: u32 = 100;
}

impl LocalIndex for Slabs {
    fn scratch_bytes(triangle_count: usize, _: &Options) -> usize {
        triangle_count.saturating_mul(size_of::<u32>())
    }

    fn build(
        group: &Group<'_>,
        _: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let axis = longest_axis(&group.bounds);
        let side = |id: u32| match group.triangles.get(id) {
            Some(triangle) => {
                let bounds = triangle.bounds();
                (bounds.lo.to_array()[axis], bounds.hi.to_array()[axis])
            }
            None => (0.0, 0.0), // never: the ids are those of the group
        };

        // 1. Sort the ids by their lower side, then by themselves, so that the bytes are the same everywhere.
        let given = scratch.len();
        let needed = Self::scratch_bytes(group.ids.len(), &Options::DEFAULT);
        let scratch = scratch.get_mut(..needed).and_then(|s| bytemuck::try_cast_slice_mut(s).ok());
        let ids: &mut [u32] = scratch.ok_or(BuildError::ScratchFull { needed, given })?;
        ids.copy_from_slice(group.ids);
        let levels = u64::from(usize::BITS - ids.len().leading_zeros());
        words.spend(ids.len() as u64 * levels)?;
        ids.sort_unstable_by(|&a, &b| side(a).0.total_cmp(&side(b).0).then(a.cmp(&b)));

        // 2. Write the slabs.
        for slab in ids.chunks(CAPACITY) {
            let sides = || slab.iter().map(|&id| side(id));
            let lo = sides().fold(f32::INFINITY, |lo, (side, _)| lo.min(side));
            let hi = sides().fold(f32::NEG_INFINITY, |hi, (_, side)| hi.max(side));
            words.extend(&[lo.to_bits(), hi.to_bits()]);
            words.extend(slab);
        }
        Ok(())
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let axis = longest_axis(&local.bounds);
        for (number, slab) in local.words.chunks(STRIDE).enumerate() {
            let [lo, hi, ids @ ..] = slab else { break };
            let [lo, hi] = [*lo, *hi].map(f32::from_bits);
            // `between` is never too narrow; a slab behind the closest hit so far need not be entered.
            let part = ray.between(axis, lo, hi, span);
            if part.is_empty() || part.from > ray.last(query.last_t()) {
                continue;
            }
            query.enter();
            local.test((number * STRIDE + 2) as u32, ids.len() as u32, ray, query)?;
        }
        ControlFlow::Continue(())
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let mut statistics = Statistics::default();
        for (number, slab) in local.words.chunks(STRIDE).enumerate() {
            let count = slab.len().checked_sub(2)? as u32;
            if !local.are_ids((number * STRIDE + 2) as u32, count) {
                return None;
            }
            statistics.add_leaf(count, 1);
        }
        Some(statistics)
    }
}

/// The axis along which a box is longest: 0, 1 or 2.
fn longest_axis(bounds: &Aabb) -> usize {
    let [x, y, z] = bounds.extent();
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Compares slabs, alone and in clusters, with the linear scan, and opens their bytes again.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Two crowds of 500 triangles, far from each other.
    let mut random = 1_u32;
    let mut number = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as f32 / (1 << 24) as f32
    };
    let mut triangles = Vec::new();
    for crowd in [0.0, 300.0] {
        for _ in 0..500 {
            let a = Vec3::new(crowd + 20.0 * number(), 5.0 * number(), 5.0 * number());
            triangles.push(Triangle::new(a, a + Vec3::X, a + Vec3::new(0.0, 1.0, number())));
        }
    }
    let mut rays = Vec::new();
    for triangle in &triangles {
        let target = triangle.a + Vec3::splat(0.2);
        let origin = Vec3::new(160.0 * number(), 80.0 * number() - 40.0, 40.0);
        rays.push(Ray::new(origin, target - origin)?);
    }

    let [mut scan, mut alone, mut clustered] = [(); 3].map(|()| vec![Block::ZERO; 4096]);
    let linear = build::<Linear>(&triangles, &mut scan)?;
    compare(&build::<Slabs>(&triangles, &mut alone)?, &linear, &rays)?;
    compare(&build::<Clustered<Slabs>>(&triangles, &mut clustered)?, &linear, &rays)
}

/// Builds an index of any kind in `arena`.
fn build<'a, R: Representation>(
    triangles: &'a [Triangle],
    arena: &'a mut [Block],
) -> Result<Index<'a, R>, BuildError> {
    let (scene, options) = (Scene::new(triangles), Options::DEFAULT);
    let bytes = Index::<R>::scratch_capacity(triangles.len(), &options);
    let mut scratch = vec![Block::ZERO; Block::count(bytes)];
    Index::build(&scene, &options, Block::bytes(arena), Block::bytes(&mut scratch))
}

/// Asks both about every ray, and opens the bytes of the first.
fn compare<R: Representation>(
    index: &Index<'_, R>,
    linear: &Index<'_, Linear>,
    rays: &[Ray],
) -> Result<(), Box<dyn std::error::Error>> {
    let opened = Index::<R>::from_bytes(index.as_bytes())?;
    let (mut counters, mut hit_count) = (Counters::default(), 0);
    for ray in rays {
        let hit = opened.closest_hit_counted(ray, &mut counters);
        assert_eq!(hit, linear.closest_hit(ray));
        assert_eq!(opened.occluded(ray), hit.is_some());
        hit_count += usize::from(hit.is_some());
    }
    let tests = counters.triangle_tests as f64 / rays.len() as f64;
    println!(
        "{}: {} clusters, {hit_count} hits of {} rays, as the linear scan; {tests:.1} tests a ray",
        R::NAME,
        index.cluster_count(),
        rays.len()
    );
    assert!(0 < hit_count && tests < 1000.0);
    Ok(())
}
