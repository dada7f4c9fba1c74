//! Stream of photons: all segments of a range of photons, chunk by chunk, on all processors.
//!
//! ```text
//! photons 0 .. 1023 | 1024 .. 2047 | ...      chunks, of a size that does not depend on threads
//!     begin             begin                 makes the state of a chunk
//!     visit             visit                 receives each segment, in the order of waves
//!     finish            finish                completes the state
//!        \--- in the order of the chunks ---/
//!                  end                        receives the states, one after the other
//! ```
//!
//! The photons of a chunk are traced in waves: first the rays of all photons from the lights, then the rays of all
//! surviving photons after one bounce, and so on. Where a wave has fewer photons than a chunk, another chunk joins it:
//!
//! ```text
//! wave 0 | chunk 0, bounce 0                    |
//! wave 1 | chunk 0, bounce 1 | chunk 1, bounce 0    |
//! wave 2 | chunk 0, bounce 2 | chunk 1, bounce 1 | chunk 2, bounce 0 |
//! ```
//!
//! Runs of chunks go in parallel; what `end` receives does not depend on the number of threads, nor on the runs.

use std::ops::Range;

use arboleda::{Counters, RayIndex, SimdLevel};
use rayon::prelude::*;

use super::shot::{Balance, Counting};
use super::trace::{Segment, Tracer};
use super::wave::{self, Wave};

/// Number of photons in a chunk. The digest depends on it. A chunk is large enough that its scheduling costs nothing,
/// and small enough that a wave stays in the cache.
pub const CHUNK: u64 = 1024;
/// Most chunks that share waves on one thread. At their end the last waves are short.
///
/// # Measured
/// Time of a shot on figure 4(b) and the city:
///
/// - runs of 32 chunks: within 4%, which is the noise; but few runs for many threads;
/// - waves of at least 512 or 2,048 photons in place of a chunk's: within 2%; of 4,096 and 8,192: up to 4% more.
const MOST_CHUNKS_IN_A_RUN: u64 = 8;

/// Work on the segments of a stream of photons. Implement `visit` or `visit_part`.
pub(crate) trait Visitor: Sync {
    /// State of a chunk.
    type State: Send;
    /// Chunks whose states are kept before they are handed on. By default 2^14: 2 MB of small states.
    fn chunks_at_once(&self) -> u64 {
        1 << 14
    }
    /// Begins a chunk.
    fn begin(&self) -> Self::State;
    /// Receives a segment. Segments come in the order of waves and, in a wave, of photons.
    fn visit(&self, _: &mut Self::State, _: &Segment) {}
    /// Receives the segments of a wave; by default, `visit` receives one after the other.
    #[inline]
    fn visit_part(&self, state: &mut Self::State, part: &wave::WavePart<'_>) {
        for segment in part.segments() {
            self.visit(state, &segment);
        }
    }
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
    let chunk_at = |chunk: u64| {
        let first = photons.start + chunk * CHUNK;
        first..photons.end.min(first.saturating_add(CHUNK))
    };
    let emitter = tracer.emitter();
    let count = if emitter.is_dark() { 0 } else { photons.end.saturating_sub(photons.start) };
    let mut all = Tally::default();
    let chunks = count.div_ceil(CHUNK);
    let at_once = visitor.chunks_at_once();
    for first in (0..chunks).step_by(at_once as usize) {
        let end_of_these = chunks.min(first + at_once);
        // At least four runs a thread, where there are enough chunks.
        let (these, threads) = (end_of_these - first, rayon::current_num_threads() as u64);
        let in_a_run = (these / (4 * threads)).clamp(1, MOST_CHUNKS_IN_A_RUN);
        let runs: Vec<_> = (0..these.div_ceil(in_a_run))
            .into_par_iter()
            .map(|run| {
                let first = first + run * in_a_run;
                let run = first..end_of_these.min(first + in_a_run);
                trace_run(tracer, run.map(chunk_at), index, counting, progress, visitor)
            })
            .collect();
        for (tally, states) in runs {
            all.join(&tally);
            states.into_iter().for_each(&mut end);
        }
    }
    all.balance.total_flux = emitter.total_flux();
    all
}

/// Photons of a chunk that are under way.
struct Chunk<S> {
    /// Place of the chunk in its run.
    place: usize,
    photons: Range<u64>,
    /// Number of its photons in the wave.
    count: usize,
    state: S,
}

/// Traces a run of chunks, wave by wave. Returns the states of the chunks, in their order.
fn trace_run<I: RayIndex + ?Sized, V: Visitor>(
    tracer: &Tracer<'_>,
    chunks: impl Iterator<Item = Range<u64>>,
    index: &I,
    counting: Counting,
    progress: &impl Fn(u64),
    visitor: &V,
) -> (Tally, Vec<V::State>) {
    let mut tally = Tally::default();
    let mut states = Vec::new();
    let mut wave = Wave::new(tracer, SimdLevel::detect());
    let mut under_way: Vec<Chunk<V::State>> = Vec::new();
    let mut waiting = chunks.enumerate();
    loop {
        // 1. Chunks join a short wave, in their order.
        while wave.len() < CHUNK as usize {
            let Some((place, photons)) = waiting.next() else { break };
            let first = wave.len();
            wave.emit(photons.clone(), &mut tally);
            let count = wave.len() - first;
            under_way.push(Chunk { place, photons, count, state: visitor.begin() });
            states.push(None);
        }
        if under_way.is_empty() {
            break;
        }

        // 2. The index answers, the roulette ends paths, and the visitor receives the segments.
        wave.trace(index, counting, &mut tally.counters);
        wave.play_roulette(&mut tally);
        let mut first = 0;
        for chunk in &mut under_way {
            visitor.visit_part(&mut chunk.state, &wave.part(first..first + chunk.count));
            first += chunk.count;
        }

        // 3. The other photons bounce. A chunk without photons is done.
        wave.bounce(&mut tally);
        let mut first = 0;
        for mut chunk in std::mem::take(&mut under_way) {
            chunk.count = wave.count_below(first, chunk.photons.end);
            first += chunk.count;
            if chunk.count > 0 {
                under_way.push(chunk);
            } else {
                visitor.finish(&mut chunk.state);
                progress(chunk.photons.end - chunk.photons.start);
                states[chunk.place] = Some(chunk.state);
            }
        }
    }
    (tally, states.into_iter().flatten().collect())
}

/// Counts of the photons of one chunk, or of several.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tally {
    pub balance: Balance,
    pub bounce_count: u64,
    pub counters: Counters,
}

impl Tally {
    pub fn join(&mut self, other: &Self) {
        self.balance.join(&other.balance);
        self.bounce_count += other.bounce_count;
        self.counters += other.counters;
    }
}
