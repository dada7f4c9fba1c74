//! Shooting of many photons on all processors: counts of each triangle, and a digest of all hits.
//!
//! The result does not depend on the number of threads: sums are of integers, and hits are hashed in the order of waves
//! and, in a wave, of photons.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use arboleda::{Hit, RayIndex};

use super::digest::Digest;
use super::shot::Shot;
use super::side::Side;
use super::stream::{Visitor, stream};
use super::trace::{DEFAULT_MAX_BOUNCES, Segment, Tracer};
use crate::scene::Model;

/// Bytes of a hashed hit: photon, bounce, triangle, `t`, `u`, `v`, little-endian.
const EVENT_BYTES: usize = 8 + 5 * 4;
/// Hits that are hashed at once: 28 KiB. From 8 KiB, BLAKE3 uses whole vectors.
const EVENTS_AT_ONCE: usize = 1024;

/// Choice whether the index counts nodes and tests, which costs a little time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Counting {
    /// Do not count.
    #[default]
    Off,
    /// Sum the [`Counters`](arboleda::Counters) of all rays.
    On,
}

/// Options of shooting photons.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShootOptions {
    /// Number of photons.
    pub photons: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of threads. `None` uses the caller's pool, by default one thread on each processor.
    pub threads: Option<usize>,
    /// Most bounces of a photon. The photon is cut off where it would bounce once more.
    pub max_bounces: u32,
    /// Choice whether the index counts.
    pub counting: Counting,
}

impl Default for ShootOptions {
    /// Returns options for a million photons on all processors.
    fn default() -> Self {
        Self {
            photons: 1_000_000,
            seed: 1,
            threads: None,
            max_bounces: DEFAULT_MAX_BOUNCES,
            counting: Counting::Off,
        }
    }
}

/// Shoots photons through an index over the model's triangles.
///
/// `progress` is called from any thread after each chunk, with the chunk's number of photons. The sum of all calls is
/// the number of photons. If the kind of index is known, pass the index itself and not a `dyn RayIndex`, so that the
/// query is inlined into the loop.
///
/// If the system refuses the requested threads, the caller's pool is used, with the same result.
///
/// # Examples
/// ```
/// use arboleda::{Block, Index, Options, Triangle, Vec3};
/// use arboleda::kinds::Linear;
/// use arboleda_host::photon::{ShootOptions, shoot};
/// use arboleda_host::scene::{AreaLight, Model};
///
/// let floor = Triangle::new(Vec3::ZERO, Vec3::X * 9.0, Vec3::Y * 9.0);
/// let light = AreaLight { corner: Vec3::Z, edge_u: Vec3::Y, edge_v: Vec3::X, flux: 100.0 };
/// let model = Model {
///     triangles: vec![floor], reflectance: vec![0.5], lights: vec![light], ..Model::default()
/// };
/// let (mut arena, mut scratch) = ([Block::ZERO; 64], [Block::ZERO; 64]);
/// let index = Index::<Linear>::build(&model.scene(), &Options::default(),
///     Block::bytes(&mut arena), Block::bytes(&mut scratch))?;
/// let options = ShootOptions { photons: 10_000, ..ShootOptions::default() };
/// let shot = shoot(&model, &index, &options, &|_| {});
/// assert_eq!(shot.balance.absorbed + shot.balance.escaped, 10_000);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn shoot<I: RayIndex + Sync + ?Sized>(
    model: &Model,
    index: &I,
    options: &ShootOptions,
    progress: &(impl Fn(u64) + Sync),
) -> Shot {
    let pool = options.threads.and_then(|threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build().ok()
    });
    match pool {
        Some(pool) => pool.install(|| shoot_here(model, index, options, progress)),
        None => shoot_here(model, index, options, progress),
    }
}

/// Shoots photons on the threads of the caller's pool.
fn shoot_here<I: RayIndex + Sync + ?Sized>(
    model: &Model,
    index: &I,
    options: &ShootOptions,
    progress: &(impl Fn(u64) + Sync),
) -> Shot {
    let start = Instant::now();
    let tracer = Tracer::new(model, options.seed, options.max_bounces);
    // One table for all threads, because a table for each thread would take more memory than the scene. Sums of
    // integers do not depend on the order, so relaxed ordering suffices.
    let hit_counts: Vec<[AtomicU64; 2]> =
        model.triangles.iter().map(|_| [const { AtomicU64::new(0) }; 2]).collect();

    // 1. The hashes of chunks are hashed in the order of chunks.
    let mut digests = blake3::Hasher::new();
    let visitor = ShotVisitor { model, hit_counts: &hit_counts };
    let (photons, counting) = (0..options.photons, options.counting);
    let all = stream(&tracer, photons, index, counting, progress, &visitor, |events| {
        digests.update(&events.finish());
    });

    // 2. The counts of both sides of each triangle are summed.
    let sides = |side: Side| {
        hit_counts.iter().map(move |counts| counts[side as usize].load(Ordering::Relaxed))
    };
    let front_hit_counts: Vec<u64> = sides(Side::Front).collect();
    let both = front_hit_counts.iter().zip(sides(Side::Back)).map(|(front, back)| front + back);
    Shot {
        balance: all.balance,
        bounce_count: all.bounce_count,
        hit_counts: both.collect(),
        front_hit_counts,
        counters: (options.counting == Counting::On).then_some(all.counters),
        digest: Digest(*digests.finalize().as_bytes()),
        seconds: start.elapsed().as_secs_f64(),
        thread_count: rayon::current_num_threads(),
    }
}

/// Counts the hits of each side of each triangle, and hashes the hits of each chunk.
struct ShotVisitor<'s> {
    model: &'s Model,
    hit_counts: &'s [[AtomicU64; 2]],
}

impl Visitor for ShotVisitor<'_> {
    type State = EventHasher;

    fn begin(&self) -> EventHasher {
        EventHasher::new()
    }

    #[inline]
    fn visit(&self, events: &mut EventHasher, segment: &Segment) {
        let Some(hit) = &segment.hit else { return };
        events.add(segment, hit);
        let id = hit.triangle.0 as usize;
        if let (Some(triangle), Some(sides)) =
            (self.model.triangles.get(id), self.hit_counts.get(id))
        {
            let side = Side::met(triangle, &segment.ray);
            sides[side as usize].fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Hasher of a chunk's hits, in the order in which they are added.
struct EventHasher {
    hasher: blake3::Hasher,
    waiting: Vec<u8>,
}

impl EventHasher {
    fn new() -> Self {
        Self {
            hasher: blake3::Hasher::new(),
            waiting: Vec::with_capacity(EVENTS_AT_ONCE * EVENT_BYTES),
        }
    }

    #[inline]
    fn add(&mut self, segment: &Segment, hit: &Hit) {
        let words = [
            segment.photon as u32,
            (segment.photon >> 32) as u32,
            segment.bounce,
            hit.triangle.0,
            hit.t.to_bits(),
            hit.u.to_bits(),
            hit.v.to_bits(),
        ];
        let mut event = [0; EVENT_BYTES];
        for (field, word) in event.chunks_exact_mut(4).zip(words) {
            field.copy_from_slice(&word.to_le_bytes());
        }
        if self.waiting.len() == EVENTS_AT_ONCE * EVENT_BYTES {
            self.flush();
        }
        self.waiting.extend_from_slice(&event);
    }

    fn flush(&mut self) {
        self.hasher.update(&self.waiting);
        self.waiting.clear();
    }

    fn finish(mut self) -> [u8; 32] {
        self.flush();
        *self.hasher.finalize().as_bytes()
    }
}
