//! Discs around receivers, their index, and their sums.
//!
//! ```text
//! chunks of photons, in parallel      segments -> index -> pairs (carrier, segment)
//! some chunks together                pairs sorted by carrier
//! carriers, in parallel               discs of the carrier x its segments -> sums
//! ```
//! A disc belongs to one carrier, so no two threads add to its sum, and the segments of a carrier stay in the cache.
//!
//! Large discs give a chunk very many pairs. Such a chunk adds its pairs to the sums itself, so that memory stays
//! bounded. Sums are of whole numbers, so they do not depend on when a pair is added.

use std::sync::{Mutex, PoisonError};

use arboleda::{BuildError, Hit, IndexKind, Options, OwnedIndex, Ray, RayIndex, Scene, Triangle};
use rayon::prelude::*;
use thiserror::Error;

use super::carriers::{Carrier, carriers};
use super::crossing::{Crossing, Flight, Reach, crossing};
use super::{Domain, TangentPlane};
use crate::density::estimate::{Estimate, Sums, disc_area};
use crate::density::receiver::visible::{Fan, VisiblePolygon};
use crate::density::receiver::{Receiver, hit_point, unit_normal};
use crate::density::source::PhotonSource;
use crate::photon::{Balance, Segment, Visitor};
use crate::{Threads, TimedIndex};

/// Hits that a segment's buffer holds at first. It grows where a segment crosses more carriers.
const HITS: usize = 64;
/// Number of pairs at which a chunk adds them itself: 2 MB. A usual chunk has a tenth.
const MOST_PAIRS: usize = 1 << 18;

/// Error of making discs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum DiscError {
    /// The index over the carriers cannot be built.
    #[error("the index over the discs cannot be built: {0}")]
    Unbuilt(BuildError),
    /// A disc reaches beyond the largest `f32`.
    #[error("a disc of this radius reaches beyond the range of 32-bit numbers")]
    TooLarge,
}

/// Discs around receivers, indexed, with a count for each.
pub struct Discs<'r> {
    receivers: &'r [Receiver],
    options: TangentPlane,
    carriers: Vec<Carrier>,
    index: OwnedIndex,
    /// Polygons of the receivers; empty for whole discs.
    polygons: Vec<VisiblePolygon<'r>>,
    sums: Vec<Sums>,
    /// Depth behind the surface at its end to which a segment is prolonged. Rounding may put discs there that lie in
    /// the plane of the surface.
    prolonged: f64,
}

impl<'r> Discs<'r> {
    /// Makes the discs and an index of the given kind over them, in the caller's pool.
    ///
    /// `scene` is the index over the model's triangles, for [`Domain::Visible`].
    ///
    /// # Errors
    /// [`DiscError`].
    pub fn new(
        receivers: &'r [Receiver],
        options: &TangentPlane,
        kind: IndexKind,
        scene: &(dyn RayIndex + Sync),
        fan: &'r Fan,
    ) -> Result<Self, DiscError> {
        let radius = f64::from(options.radius);
        let carriers = carriers(receivers, radius).ok_or(DiscError::TooLarge)?;
        let triangles: Vec<Triangle> = carriers.iter().map(|carrier| carrier.triangle).collect();
        let index = build(kind, &Scene::new(&triangles)).map_err(DiscError::Unbuilt)?;
        let polygons = options.polygons(receivers, scene, fan);
        // A carrier reaches at most 3.1 radii from its discs' centres.
        let slack = |receiver: &Receiver| receiver.slack(4.0 * radius);
        let prolonged = receivers.iter().map(slack).fold(0.0, f64::max);
        let sums = vec![Sums::default(); receivers.len()];
        Ok(Self { receivers, options: *options, carriers, index, polygons, sums, prolonged })
    }

    /// Counts the photons of a source that cross each disc, in the caller's pool. The photons are streamed; `progress`
    /// is called from any thread with numbers of photons. May be called again with other photons.
    pub fn count(
        &mut self,
        source: &PhotonSource<'_>,
        progress: &(impl Fn(u64) + Sync),
    ) -> Balance {
        // The sums are taken out while threads share the rest. A thread that holds them waits for no other.
        let sums = Mutex::new(std::mem::take(&mut self.sums));
        let locked = || sums.lock().unwrap_or_else(PoisonError::into_inner);
        let index = self.index.index();
        let finder = Finder { discs: self, index: index.as_ray_index(), source, sums: &sums };
        let mut waiting = Vec::new();
        let balance = source.stream(progress, &finder, |met| {
            waiting.push(met);
            if waiting.len() as u64 == finder.chunks_at_once() {
                self.add(&mut locked(), &waiting);
                waiting.clear();
            }
        });
        self.add(&mut locked(), &waiting);
        self.sums = sums.into_inner().unwrap_or_else(PoisonError::into_inner);
        balance
    }

    /// Adds the segments of some chunks to the sums of the discs that they cross.
    fn add(&self, sums: &mut [Sums], chunks: &[Met]) {
        /// Carriers of one task.
        const SOME: usize = 64;
        // 1. The segments of each carrier, by a counting sort.
        let mut ends = vec![0_usize; self.carriers.len() + 1];
        for &(carrier, _) in chunks.iter().flat_map(|met| &met.pairs) {
            ends[carrier as usize + 1] += 1;
        }
        for carrier in 1..ends.len() {
            ends[carrier] += ends[carrier - 1];
        }
        let total = ends[self.carriers.len()];
        let mut places = ends.clone();
        let mut sorted = vec![(0_u32, 0_u32); total];
        for (chunk, met) in (0..).zip(chunks) {
            for &(carrier, flight) in &met.pairs {
                let place = &mut places[carrier as usize];
                sorted[*place] = (chunk, flight);
                *place += 1;
            }
        }

        // 2. The discs of each carrier. Its sums are no other carrier's.
        let mut tasks = Vec::new();
        let mut rest = sums;
        for (number, carriers) in self.carriers.chunks(SOME).enumerate() {
            let discs = carriers.iter().map(|carrier| carrier.discs.len()).sum();
            let (some, after) = rest.split_at_mut(discs);
            tasks.push((number * SOME, carriers, some));
            rest = after;
        }
        tasks.into_par_iter().for_each(|(first, carriers, mut sums)| {
            for (number, carrier) in (first..).zip(carriers) {
                let (own, after) = sums.split_at_mut(carrier.discs.len());
                let met = &sorted[ends[number]..ends[number + 1]];
                let flights: Vec<&(Flight, [f32; 3])> = met
                    .iter()
                    .map(|&(chunk, flight)| &chunks[chunk as usize].flights[flight as usize])
                    .collect();
                for (disc, sum) in carrier.discs.clone().zip(own) {
                    self.add_to_disc(disc as usize, sum, &flights);
                }
                sums = after;
            }
        });
    }

    /// Returns the number of carriers, on which the cost of a segment depends.
    pub fn carrier_count(&self) -> usize {
        self.carriers.len()
    }

    /// Returns the bytes of the carriers, their index, and the sums.
    pub fn bytes(&self) -> usize {
        self.index.as_bytes().len()
            + size_of_val(self.carriers.as_slice())
            + size_of_val(self.polygons.as_slice())
            + size_of_val(self.sums.as_slice())
    }

    /// Makes the estimate of a receiver from photons of `photon_flux` watts each.
    pub fn estimate(&self, receiver: usize, photon_flux: f64) -> Estimate {
        let area = self.options.area(self.polygons.get(receiver));
        self.options.estimate(&self.sums[receiver], area, photon_flux)
    }

    /// Takes the sums of the receivers out, in their order; counting begins anew.
    pub(in crate::density) fn take_sums(&mut self) -> Vec<Sums> {
        let none = vec![Sums::default(); self.receivers.len()];
        std::mem::replace(&mut self.sums, none)
    }

    /// Returns the sums of the receivers, in their order, and the areas in which photons count.
    pub(in crate::density) fn into_sums(self) -> (Vec<Sums>, Vec<f64>) {
        let areas = self.options.areas(self.receivers.len(), &self.polygons);
        (self.sums, areas)
    }

    fn reach(&self, receiver: &Receiver) -> Reach {
        let radius = f64::from(self.options.radius);
        Reach {
            radius_squared: radius * radius,
            beyond: f64::from(self.options.beyond) * radius,
            slack: receiver.slack(radius),
        }
    }

    /// Adds the segments of one chunk to the sums of the discs that they cross, in this thread, and forgets them.
    fn add_alone(&self, sums: &mut [Sums], met: &mut Met) {
        met.pairs.sort_unstable();
        for pairs in met.pairs.chunk_by(|a, b| a.0 == b.0) {
            let Some(carrier) = pairs.first().and_then(|&(at, _)| self.carriers.get(at as usize))
            else {
                continue;
            };
            let flights: Vec<_> =
                pairs.iter().map(|&(_, flight)| &met.flights[flight as usize]).collect();
            for disc in carrier.discs.clone() {
                self.add_to_disc(disc as usize, &mut sums[disc as usize], &flights);
            }
        }
        met.pairs.clear();
        met.flights.clear();
    }

    /// Adds the segments that cross the disc of a receiver to its sum.
    #[inline]
    fn add_to_disc(&self, at: usize, sum: &mut Sums, flights: &[&(Flight, [f32; 3])]) {
        let receiver = &self.receivers[at];
        let reach = self.reach(receiver);
        let polygon = self.polygons.get(at);
        for (flight, weight) in flights {
            let Some(Crossing { offset, distance_squared }) = crossing(receiver, flight, &reach)
            else {
                continue;
            };
            if polygon.is_none_or(|polygon| polygon.contains(offset)) {
                let share = distance_squared / reach.radius_squared;
                sum.add(*weight, self.options.kernel.weight(share));
            }
        }
    }

    /// Adds segments to every disc that they cross, without the index: the reference for tests.
    #[cfg(test)]
    pub(super) fn add_to_all(&mut self, segments: &[Segment], model: &crate::scene::Model) {
        let end = |segment: &Segment| {
            segment.hit.map(|hit| hit_point(&model.triangles[hit.triangle.0 as usize], &hit))
        };
        let flights: Vec<(Flight, [f32; 3])> = segments
            .iter()
            .map(|segment| (Flight::new(segment, end(segment)), segment.weight))
            .collect();
        let flights: Vec<_> = flights.iter().collect();
        let mut sums = std::mem::take(&mut self.sums);
        let discs = sums.par_iter_mut().enumerate();
        discs.for_each(|(at, sum)| self.add_to_disc(at, sum, &flights));
        self.sums = sums;
    }

    /// Returns the count of a receiver.
    #[cfg(test)]
    pub(super) fn count_of(&self, receiver: usize) -> u32 {
        self.sums[receiver].count()
    }
}

impl TangentPlane {
    /// Finds the parts of the receivers' discs that count, in the caller's pool; none for whole discs.
    pub(in crate::density) fn polygons<'f>(
        &self,
        receivers: &[Receiver],
        scene: &(dyn RayIndex + Sync),
        fan: &'f Fan,
    ) -> Vec<VisiblePolygon<'f>> {
        let radius = f64::from(self.radius);
        match self.domain {
            Domain::Disc => Vec::new(),
            Domain::Visible => {
                let lift = f64::from(self.beyond) * radius;
                let polygon = |receiver: &Receiver| fan.polygon(receiver, radius, lift, scene);
                receivers.par_iter().map(polygon).collect()
            }
        }
    }

    /// Computes the area of a disc, or that of the polygon in which photons count.
    fn area(&self, polygon: Option<&VisiblePolygon<'_>>) -> f64 {
        let radius = f64::from(self.radius);
        polygon.map_or(disc_area(radius * radius), |polygon| polygon.area(self.kernel))
    }

    /// Computes the areas at `count` receivers with these polygons; none for whole discs.
    pub(in crate::density) fn areas(
        &self,
        count: usize,
        polygons: &[VisiblePolygon<'_>],
    ) -> Vec<f64> {
        (0..count).into_par_iter().map(|at| self.area(polygons.get(at))).collect()
    }

    /// Makes the estimate of sums over photons of `photon_flux` watts each, which were counted in an area.
    pub(in crate::density) fn estimate(
        &self,
        sums: &Sums,
        area: f64,
        photon_flux: f64,
    ) -> Estimate {
        sums.estimate(photon_flux, area, f64::from(self.radius))
    }
}

/// Builds an index over the carriers with the caller's pool.
fn build(kind: IndexKind, scene: &Scene<'_>) -> Result<OwnedIndex, BuildError> {
    let built = TimedIndex::build_with(kind, scene, &Options::default(), &Threads::default())?;
    Ok(built.into_index())
}

/// Segments of a chunk that may cross discs, and the carriers that they meet.
#[derive(Default)]
struct Met {
    flights: Vec<(Flight, [f32; 3])>,
    /// Carrier, and the place in `flights`.
    pairs: Vec<(u32, u32)>,
    /// Memory for the hits of a segment.
    hits: Vec<Hit>,
}

/// Finds the carriers that the segments of a source meet.
struct Finder<'c> {
    discs: &'c Discs<'c>,
    index: &'c (dyn RayIndex + Sync),
    source: &'c PhotonSource<'c>,
    sums: &'c Mutex<Vec<Sums>>,
}

impl Visitor for Finder<'_> {
    type State = Met;

    /// For each of up to 16 threads 8,192 photons, some 3 MB: their segments, and 8 bytes for each carrier that a segment
    /// meets.
    fn chunks_at_once(&self) -> u64 {
        (8 * rayon::current_num_threads() as u64).min(128)
    }

    fn begin(&self) -> Met {
        Met { hits: vec![Hit::NONE; HITS], ..Met::default() }
    }

    fn visit(&self, met: &mut Met, segment: &Segment) {
        if !self.source.bounces.includes(segment.bounce) {
            return;
        }
        let model = self.source.model;
        let end = segment.hit.and_then(|hit| {
            let triangle = model.triangles.get(hit.triangle.0 as usize)?;
            Some((triangle, hit))
        });
        let Some(ray) = self.prolonged(segment, end.map(|(triangle, hit)| (triangle, hit.t)))
        else {
            return;
        };
        let hits = loop {
            let answer = self.index.all_hits(&ray, &mut met.hits);
            if !answer.truncated {
                break answer.hits.len();
            }
            met.hits.resize(met.hits.len() * 4, Hit::NONE);
        };
        if hits > 0 {
            let flight = met.flights.len() as u32;
            let point = end.map(|(triangle, hit)| hit_point(triangle, &hit));
            met.flights.push((Flight::new(segment, point), segment.weight));
            met.pairs.extend(met.hits[..hits].iter().map(|hit| (hit.triangle.0, flight)));
            if met.pairs.len() >= MOST_PAIRS {
                let mut sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
                self.discs.add_alone(&mut sums, met);
            }
        }
    }

    fn finish(&self, met: &mut Met) {
        met.hits = Vec::new();
    }
}

impl Finder<'_> {
    /// Makes the ray of a segment, prolonged beyond its end so far that it meets the carriers of all discs that it may
    /// cross.
    fn prolonged(&self, segment: &Segment, end: Option<(&Triangle, f32)>) -> Option<Ray> {
        let ray = &segment.ray;
        let Some((triangle, t)) = end else { return Some(*ray) };
        // Discs before which a segment may end are anywhere on its extension.
        if self.discs.options.beyond > 0.0 {
            return Some(*ray);
        }
        let normal = unit_normal(triangle)?;
        let cosine = normal.dot(ray.direction().into()).abs();
        // 2^-20 is far more than the error of `t`; a cosine of 0 prolongs the segment to the end.
        let t = f64::from(t);
        let last = t + t / f64::from(1 << 20) + self.discs.prolonged / cosine;
        let last = if last.is_finite() { last as f32 } else { f32::INFINITY };
        Ray::with_interval(ray.origin(), ray.direction(), 0.0, last).ok()
    }
}
