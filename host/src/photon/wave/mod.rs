//! Wave of photons: those that are under way at the same time, so that the index answers many rays at once.
//!
//! ```text
//! emit ->+-> trace -> play_roulette -> part: segments, hits -> bounce -+
//!        ^                                                             |
//!        +------------ survivors, in the same order <------------------+
//! ```
//!
//! Photons stay in the order in which they were emitted.

#[cfg(test)]
mod tests;

use std::ops::Range;

use arboleda::{BATCH_SCRATCH, Counters, Hit, Ray, RayIndex, SimdLevel};

use crate::photon::lanes::{BounceLanes, EmissionLanes, LANES};
use crate::photon::random::{PhotonRandom, Place};
use crate::photon::shot::{Balance, Counting};
use crate::photon::stream::Tally;
use crate::photon::trace::{Path, PathEnd, Segment, Tracer};

/// Photons under way: a photon and a ray for each.
pub(in crate::photon) struct Wave<'t, 'm> {
    tracer: &'t Tracer<'m>,
    photons: Vec<WavePhoton>,
    rays: Vec<Ray>,
    /// Closest hits of the rays, after `trace`.
    hits: Vec<Hit>,
    /// Memory for batches of rays.
    scratch: Vec<u8>,
    /// Places in the wave of the photons that hit a triangle, and of those that survived the roulette.
    hit_places: Vec<u32>,
    survivors: Vec<u32>,
    emission: Box<EmissionLanes>,
    bounces: Box<BounceLanes>,
}

/// Photon under way, without its ray.
#[derive(Clone, Copy)]
struct WavePhoton {
    place: Place,
    weight: [f32; 3],
    bounce: u32,
}

impl<'t, 'm> Wave<'t, 'm> {
    pub fn new(tracer: &'t Tracer<'m>, level: SimdLevel) -> Self {
        Self {
            tracer,
            photons: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            scratch: vec![0; BATCH_SCRATCH],
            hit_places: Vec::new(),
            survivors: Vec::new(),
            emission: EmissionLanes::new(level, tracer.seed()),
            bounces: BounceLanes::new(level, tracer.seed()),
        }
    }

    /// Returns the number of photons.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    /// Counts the photons from index `first` on with a number below `end`.
    pub fn count_below(&self, first: usize, end: u64) -> usize {
        self.photons[first..].partition_point(|photon| photon.place.photon < end)
    }

    /// Adds photons at their emission.
    pub fn emit(&mut self, numbers: Range<u64>, tally: &mut Tally) {
        let count = numbers.end.saturating_sub(numbers.start) as usize;
        tally.balance.emitted += count as u64;
        self.photons.reserve(count);
        self.rays.reserve(count);
        for first in numbers.clone().step_by(LANES) {
            self.emission.compute(self.tracer.emitter(), first);
            for lane in 0..LANES.min((numbers.end - first) as usize) {
                let one_by_one = || {
                    let path = self.tracer.emit(first + lane as u64)?.ok()?;
                    Some((path.ray, path.weight, *path.random.place()))
                };
                if let Some((ray, weight, place)) = self.emission.photon(lane).or_else(one_by_one) {
                    self.rays.push(ray);
                    self.photons.push(WavePhoton { place, weight, bounce: 0 });
                } else {
                    tally.balance.end(PathEnd::Refused);
                }
            }
        }
    }

    /// Finds the closest hits of all rays.
    pub fn trace<I: RayIndex + ?Sized>(
        &mut self,
        index: &I,
        counting: Counting,
        counters: &mut Counters,
    ) {
        self.hits.resize(self.rays.len(), Hit::NONE);
        match counting {
            Counting::Off => {
                index.closest_hits_in(&self.rays, &mut self.hits, &mut self.scratch);
            }
            Counting::On => {
                for (ray, slot) in self.rays.iter().zip(&mut self.hits) {
                    *slot = index.closest_hit_counted(ray, counters).unwrap_or(Hit::NONE);
                }
            }
        }
    }

    /// Returns some photons of the wave, after the roulette.
    pub fn part(&self, some: Range<usize>) -> WavePart<'_> {
        let hits_before = |end: usize| self.hit_places.partition_point(|&at| (at as usize) < end);
        WavePart {
            photons: &self.photons,
            rays: &self.rays,
            hits: &self.hits,
            hit_places: &self.hit_places[hits_before(some.start)..hits_before(some.end)],
            places: some,
        }
    }

    /// Plays the roulette, and counts the photons whose paths end.
    pub fn play_roulette(&mut self, tally: &mut Tally) {
        let Self { tracer, hit_places, survivors, .. } = self;
        hit_places.resize(self.rays.len(), 0);
        survivors.resize(self.rays.len(), 0);
        let (mut survivor_count, mut hit_count, mut cut_off) = (0, 0, 0);
        for (at, (hit, photon)) in self.hits.iter().zip(&self.photons).enumerate() {
            // A draw is below 1, so a photon always survives a reflectance of 1, and never one of 0 or NaN. Without a
            // hit the reflectance is 0.
            let survives = photon.place.next_uniform() < tracer.reflectance(hit);
            let may_bounce = photon.bounce < tracer.max_bounces();
            // Without branches, which would be mispredicted for every third photon.
            hit_places[hit_count] = at as u32;
            hit_count += usize::from(!hit.is_none());
            survivors[survivor_count] = at as u32;
            survivor_count += usize::from(survives & may_bounce);
            cut_off += u64::from(survives & !may_bounce);
        }
        hit_places.truncate(hit_count);
        let hit_count = hit_count as u64;
        survivors.truncate(survivor_count);
        let ray_count = self.rays.len() as u64;
        let Balance { rays, hits, escaped, cut_off: all_cut_off, absorbed, .. } =
            &mut tally.balance;
        *rays += ray_count;
        *hits += hit_count;
        *escaped += ray_count - hit_count;
        *all_cut_off += cut_off;
        *absorbed += hit_count - survivor_count as u64 - cut_off;
    }

    /// Lets the survivors bounce. Only they remain.
    pub fn bounce(&mut self, tally: &mut Tally) {
        let Self { tracer, photons, rays, hits, survivors, bounces, .. } = self;
        let mut kept = 0;
        for group in survivors.chunks(LANES) {
            for (lane, &at) in (0..LANES).zip(group) {
                let at = at as usize;
                bounces.put(lane, tracer.triangles(), &rays[at], &hits[at], &photons[at].place);
            }
            bounces.compute();
            for (lane, &at) in (0..LANES).zip(group) {
                // `kept` is at most `at`, and the photons of later groups lie behind it.
                let (at, hit) = (at as usize, &hits[at as usize]);
                photons[kept] = photons[at];
                let photon = &mut photons[kept];
                if let Some(ray) = bounces.ray(lane, &mut photon.place) {
                    tracer.colour(hit, &mut photon.weight);
                    rays[kept] = ray;
                } else {
                    let WavePhoton { place, weight, bounce } = *photon;
                    let random = PhotonRandom::at(tracer.seed(), place);
                    let mut path = Path { bounce, ray: rays[at], weight, random };
                    if tracer.bounce(&mut path, Some(*hit)).is_some() {
                        tally.balance.end(PathEnd::Refused);
                        continue;
                    }
                    rays[kept] = path.ray;
                    (photon.place, photon.weight) = (*path.random.place(), path.weight);
                }
                photon.bounce += 1;
                kept += 1;
            }
        }
        tally.bounce_count += kept as u64;
        rays.truncate(kept);
        photons.truncate(kept);
    }
}

/// Some photons of a wave, with their segments.
pub(crate) struct WavePart<'w> {
    photons: &'w [WavePhoton],
    rays: &'w [Ray],
    hits: &'w [Hit],
    /// Places of the photons, and of those that hit a triangle.
    places: Range<usize>,
    hit_places: &'w [u32],
}

impl WavePart<'_> {
    /// Lists all segments, in the order of the photons.
    #[inline]
    pub fn segments(&self) -> impl Iterator<Item = Segment> {
        self.places.clone().map(|at| {
            let hit = self.hits[at];
            self.segment(at, (!hit.is_none()).then_some(hit))
        })
    }

    /// Returns the number of hits.
    pub fn hit_count(&self) -> usize {
        self.hit_places.len()
    }

    /// Lists the segments that end at a hit, and the hits, in the order of the photons.
    #[inline]
    pub fn hits(&self, some: Range<usize>) -> impl Iterator<Item = (Segment, Hit)> {
        self.hit_places[some].iter().map(|&at| {
            let hit = self.hits[at as usize];
            (self.segment(at as usize, Some(hit)), hit)
        })
    }

    #[inline]
    fn segment(&self, at: usize, hit: Option<Hit>) -> Segment {
        let WavePhoton { place, weight, bounce } = self.photons[at];
        Segment { photon: place.photon, bounce, ray: self.rays[at], hit, weight }
    }
}
