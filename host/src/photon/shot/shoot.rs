//! Shooting of many photons on all processors: counts of each triangle, and a digest of all hits.
//!
//! The result does not depend on the number of threads: sums are of integers, and hits are hashed in the order of waves
//! and, in a wave, of photons.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use arboleda::{Hit, RayIndex, SimdLevel, Triangle};

use super::digest_tree::{DigestNode, DigestTree, Event};
use super::{Balance, RangeSums, Shot};
use crate::photon::lanes::{LANES, SideLanes};
use crate::photon::stream::{CHUNK, Tally, Visitor, stream};
use crate::photon::surface::Side;
use crate::photon::trace::{DEFAULT_MAX_BOUNCES, Segment, Tracer};
use crate::photon::wave::WavePart;
use crate::scene::Model;

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
/// the number of photons; without a light there are none.
///
/// If the kind of index is known, pass the index itself and not a `dyn RayIndex`, so that the query is inlined into the
/// loop.
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
///     triangles: vec![floor].into(), reflectance: vec![0.5].into(), lights: vec![light], ..Model::default()
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
    in_pool(options, || {
        let start = Instant::now();
        let RangeSums { balance, bounce_count, hits, counters, digests } =
            shoot_here(model, index, options, 0..options.photons, progress);
        Shot {
            balance,
            bounce_count,
            hit_counts: hits.iter().map(|[front, back]| front + back).collect(),
            front_hit_counts: hits.iter().map(|sides| sides[Side::Front as usize]).collect(),
            counters: (options.counting == Counting::On).then_some(counters),
            digest: digests.digest(),
            seconds: start.elapsed().as_secs_f64(),
            thread_count: rayon::current_num_threads(),
        }
    })
}

/// Shoots a range of the photons, as [`shoot`] does. The sums of all photons, joined in order, are those of the shot.
///
/// # Panics
/// If the range ends beyond the photons of the options.
pub fn shoot_range<I: RayIndex + Sync + ?Sized>(
    model: &Model,
    index: &I,
    options: &ShootOptions,
    photons: Range<u64>,
    progress: &(impl Fn(u64) + Sync),
) -> RangeSums {
    assert!(photons.end <= options.photons, "photons that are not of the job");
    in_pool(options, || shoot_here(model, index, options, photons, progress))
}

/// Runs work on the threads of the options, else on those of the caller's pool.
fn in_pool<T: Send>(options: &ShootOptions, work: impl FnOnce() -> T + Send) -> T {
    let pool = options.threads.and_then(|threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build().ok()
    });
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// Shoots a range of photons on the threads of the caller's pool.
fn shoot_here<I: RayIndex + Sync + ?Sized>(
    model: &Model,
    index: &I,
    options: &ShootOptions,
    photons: Range<u64>,
    progress: &(impl Fn(u64) + Sync),
) -> RangeSums {
    let tracer = Tracer::new(model, options.seed, options.max_bounces);
    // One table for all threads, because a table for each thread would take more memory than the scene. Sums of
    // integers do not depend on the order.
    let hits = Mutex::new(vec![[0; 2]; model.triangles.len()]);
    let mut digests = DigestTree::new(options.photons);
    let mut all = Tally::default();
    for (run, is_cut) in cut_at_chunks(&photons, options.photons) {
        let visitor = ShotVisitor {
            triangles: &model.triangles,
            hits: &hits,
            level: SimdLevel::detect(),
            is_cut,
        };
        let mut chunk = run.start / CHUNK;
        let tally =
            stream(&tracer, run.clone(), index, options.counting, progress, &visitor, |hits| {
                match hits {
                    ChunkHits::Hashed(digest) => digests.push(DigestNode::Chunk { chunk, digest }),
                    ChunkHits::Kept(events) => {
                        digests.push(DigestNode::Cut { photons: run.clone(), events });
                    }
                    ChunkHits::Open(_) => unreachable!("the chunk was finished"),
                }
                chunk += 1;
            });
        all.join(&tally);
    }
    RangeSums {
        // A range without photons had no stream to say it.
        balance: Balance { total_flux: tracer.emitter().total_flux(), ..all.balance },
        bounce_count: all.bounce_count,
        hits: hits.into_inner().unwrap_or_else(PoisonError::into_inner),
        counters: all.counters,
        digests,
    }
}

/// Cuts a range of `all` photons into parts of chunks at its ends, and a run of whole chunks between them. Tells of each
/// whether it is part of a chunk.
fn cut_at_chunks(
    photons: &Range<u64>,
    all: u64,
) -> impl Iterator<Item = (Range<u64>, bool)> + use<> {
    let Range { start, end } = *photons;
    let first = start.next_multiple_of(CHUNK).min(end);
    // The last chunk of all may be shorter.
    let last = if end == all { end } else { (end - end % CHUNK).max(first) };
    let runs = [(start..first, true), (first..last, false), (last..end, true)];
    runs.into_iter().filter(|(run, _)| !run.is_empty())
}

/// Counts the hits of each side of each triangle, and hashes the hits of each chunk.
struct ShotVisitor<'s> {
    triangles: &'s [Triangle],
    /// Hits on the front and on the back of each triangle.
    ///
    /// # What lost
    /// Atomic counters, incremented at each hit. Together with finding the sides one by one, they took a fifth of the
    /// time of a shot.
    hits: &'s Mutex<Vec<[u64; 2]>>,
    level: SimdLevel,
    /// True if the photons are not a whole chunk. Then their hits are kept, because the whole chunk is to be hashed.
    is_cut: bool,
}

impl Visitor for ShotVisitor<'_> {
    type State = ChunkHits;

    fn begin(&self) -> ChunkHits {
        ChunkHits::Open(Box::new(OpenChunk {
            hasher: blake3::Hasher::new(),
            events: Vec::with_capacity(EVENTS_AT_ONCE),
            keeps: self.is_cut,
            sides: Vec::new(),
            lanes: SideLanes::new(self.level),
        }))
    }

    fn visit_part(&self, chunk: &mut ChunkHits, part: &WavePart<'_>) {
        let ChunkHits::Open(chunk) = chunk else { return };
        for first in (0..part.hit_count()).step_by(LANES) {
            let some = first..part.hit_count().min(first + LANES);
            chunk.hash(part.hits(some.clone()));
            chunk.find_sides(self.triangles, || part.hits(some.clone()));
        }
    }

    fn finish(&self, chunk: &mut ChunkHits) {
        if let ChunkHits::Open(open) = chunk {
            let mut hits = self.hits.lock().unwrap_or_else(PoisonError::into_inner);
            for &(id, side) in &open.sides {
                if let Some(sides) = hits.get_mut(id as usize) {
                    sides[side as usize] += 1;
                }
            }
            drop(hits);
            *chunk = open.end();
        }
    }
}

/// Hits of a chunk. Those of a chunk under way take some 40 KiB, so only the digest of a finished one is kept.
enum ChunkHits {
    Open(Box<OpenChunk>),
    Hashed([u8; 32]),
    /// Hits of a chunk that was cut.
    Kept(Vec<Event>),
}

/// Hits of a chunk under way.
struct OpenChunk {
    hasher: blake3::Hasher,
    /// Hits that are not hashed yet, little-endian.
    events: Vec<Event>,
    /// True if hits are kept, and not hashed.
    keeps: bool,
    /// Triangle and side of each hit.
    sides: Vec<(u32, Side)>,
    lanes: Box<SideLanes>,
}

impl OpenChunk {
    /// Hashes hits, in their order.
    #[inline]
    fn hash(&mut self, hits: impl Iterator<Item = (Segment, Hit)>) {
        if self.events.len() + LANES > EVENTS_AT_ONCE && !self.keeps {
            self.flush();
        }
        self.events.extend(hits.map(|(segment, hit)| {
            let words = [
                segment.photon as u32,
                (segment.photon >> 32) as u32,
                segment.bounce,
                hit.triangle.0,
                hit.t.to_bits(),
                hit.u.to_bits(),
                hit.v.to_bits(),
            ];
            words.map(u32::to_le)
        }));
    }

    fn flush(&mut self) {
        self.hasher.update(bytemuck::cast_slice(&self.events));
        self.events.clear();
    }

    fn end(&mut self) -> ChunkHits {
        if self.keeps {
            let events = self.events.drain(..).map(|event| event.map(u32::from_le));
            return ChunkHits::Kept(events.collect());
        }
        self.flush();
        ChunkHits::Hashed(*self.hasher.finalize().as_bytes())
    }

    /// Finds the sides of up to [`LANES`] hits. Triangles that the model does not have are omitted.
    #[inline]
    fn find_sides<H: Iterator<Item = (Segment, Hit)>>(
        &mut self,
        triangles: &[Triangle],
        hits: impl Fn() -> H,
    ) {
        let known = || {
            hits().filter_map(|(segment, hit)| {
                Some((triangles.get(hit.triangle.0 as usize)?, segment.ray, hit))
            })
        };
        for (lane, (triangle, ray, _)) in (0..LANES).zip(known()) {
            self.lanes.put(lane, triangle, &ray);
        }
        self.lanes.compute();
        for (lane, (triangle, ray, hit)) in (0..LANES).zip(known()) {
            let side = self.lanes.side(lane, triangle, &ray, &hit);
            self.sides.push((hit.triangle.0, side));
        }
    }
}
