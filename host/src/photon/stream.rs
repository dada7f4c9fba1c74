//! Stream of photons: all segments of a range of photons, chunk by chunk, on all processors.
//!
//! ```text
//! photons 0 .. 1023 | 1024 .. 2047 | ...      chunks, of a size that does not depend on threads
//!     begin             begin                 a state of the chunk
//!     visit             visit                 each segment, in the order of waves
//!        \--- in the order of the chunks ---/
//!                  end                        the states, one after the other
//! ```
//!
//! The photons of a chunk are traced in waves: first the rays of all photons from the lights, then the rays of all
//! surviving photons after one bounce, and so on. The index thus answers many rays at once.
//!
//! Chunks run in parallel; what `end` receives does not depend on the number of threads.

use std::ops::Range;

use arboleda::{BATCH_SCRATCH, Counters, Hit, RayIndex};
use rayon::prelude::*;

use super::balance::Balance;
use super::shoot::Counting;
use super::trace::{Path, PathEnd, Segment, Tracer};

/// Number of photons in a chunk. The digest depends on it. A chunk is large enough that its scheduling costs nothing,
/// and small enough that a wave stays in the cache.
pub const CHUNK: u64 = 1024;

/// Work on the segments of a stream of photons.
pub(crate) trait Visitor: Sync {
    /// State of a chunk.
    type State: Send;
    /// Chunks whose states are kept before they are handed on. By default 2^14: 2 MB of small states.
    const CHUNKS_AT_ONCE: u64 = 1 << 14;
    /// Begins a chunk.
    fn begin(&self) -> Self::State;
    /// Receives a segment. Segments come in the order of waves and, in a wave, of photons.
    fn visit(&self, state: &mut Self::State, segment: &Segment);
    /// Ends a chunk, still in parallel.
    fn finish(&self, _: &mut Self::State) {}
}

/// Streams a range of photons through an index over the model's triangles. Chunks begin at the first photon.
///
/// `progress` is called from any thread after each chunk, with the chunk's number of photons. `end` receives the states
/// of the chunks in their order. Returns the sums of all chunks. A model without lights has no photons.
pub(crate) fn stream<I: RayIndex + Sync + ?Sized, V: Visitor>(
    tracer: &Tracer<'_>,
    photons: Range<u64>,
    index: &I,
    counting: Counting,
    progress: &(impl Fn(u64) + Sync),
    visitor: &V,
    mut end: impl FnMut(V::State),
) -> Tally {
    let trace_chunk = |chunk: u64| {
        let first = photons.start + chunk * CHUNK;
        let last = photons.end.min(first.saturating_add(CHUNK));
        let mut tally = Tally::default();
        let mut state = visitor.begin();
        tally.add_photons(tracer, first..last, index, counting, |segment| {
            visitor.visit(&mut state, segment);
        });
        visitor.finish(&mut state);
        progress(last - first);
        (tally, state)
    };
    let emitter = tracer.emitter();
    let count = if emitter.is_dark() { 0 } else { photons.end.saturating_sub(photons.start) };
    let mut all = Tally::default();
    let chunks = count.div_ceil(CHUNK);
    for first in (0..chunks).step_by(V::CHUNKS_AT_ONCE as usize) {
        let some = first..chunks.min(first + V::CHUNKS_AT_ONCE);
        let states: Vec<_> = some.into_par_iter().map(trace_chunk).collect();
        for (tally, state) in states {
            all.join(&tally);
            end(state);
        }
    }
    all.balance.total_flux = emitter.total_flux();
    all
}

/// Counts of the photons of one chunk, or of several.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tally {
    pub balance: Balance,
    pub bounce_count: u64,
    pub counters: Counters,
}

impl Tally {
    /// Traces a range of photons wave by wave.
    #[inline]
    fn add_photons<I: RayIndex + ?Sized>(
        &mut self,
        tracer: &Tracer<'_>,
        photons: Range<u64>,
        index: &I,
        counting: Counting,
        mut visit: impl FnMut(&Segment),
    ) {
        let mut paths = Vec::new();
        self.balance.emitted += photons.end - photons.start;
        for photon in photons {
            match tracer.emit(photon) {
                Some(Ok(path)) => paths.push(path),
                // `None` does not occur, because a dark model shoots no photons.
                Some(Err(_)) | None => self.balance.end(PathEnd::Refused),
            }
        }
        let (mut rays, mut hits) = (Vec::new(), Vec::new());
        let mut scratch = vec![0; BATCH_SCRATCH];
        while !paths.is_empty() {
            rays.clear();
            rays.extend(paths.iter().map(Path::ray).copied());
            hits.clear();
            hits.resize(rays.len(), Hit::NONE);
            match counting {
                Counting::Off => index.closest_hits_in(&rays, &mut hits, &mut scratch),
                Counting::On => {
                    for (ray, slot) in rays.iter().zip(&mut hits) {
                        let hit = index.closest_hit_counted(ray, &mut self.counters);
                        *slot = hit.unwrap_or(Hit::NONE);
                    }
                }
            }
            let mut hits = hits.iter();
            paths.retain_mut(|path| {
                let hit = hits.next().filter(|hit| !hit.is_none());
                let segment = path.segment(hit.copied());
                self.balance.rays += 1;
                self.balance.hits += u64::from(hit.is_some());
                visit(&segment);
                let end = tracer.bounce(path, segment.hit);
                if let Some(end) = end {
                    self.bounce_count += u64::from(segment.bounce);
                    self.balance.end(end);
                }
                end.is_none()
            });
        }
    }

    pub fn join(&mut self, other: &Self) {
        self.balance.join(&other.balance);
        self.bounce_count += other.bounce_count;
        self.counters += other.counters;
    }
}
