//! Discs around receivers, their index, and their counts.

use arboleda::{BuildError, Hit, IndexKind, Options, OwnedIndex, Ray, RayIndex, Scene, Triangle};
use rayon::prelude::*;
use thiserror::Error;

use super::carriers::{Carrier, carriers};
use super::crossing::{Crossing, Flight, Reach, crossing};
use super::{Domain, TangentPlane};
use crate::density::Kernel;
use crate::density::estimate::{Estimate, SharedSums, disc_area};
use crate::density::receiver::{Receiver, hit_point, unit_normal};
use crate::density::source::{Balance, PhotonSource};
use crate::density::visible::{Fan, VisiblePolygon};
use crate::photon::{Segment, Visitor};
use crate::scene::Model;
use crate::{Threads, TimedIndex};

/// Hits that a segment's buffer holds at first. It grows where a segment crosses more carriers.
const HITS: usize = 64;

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
    sums: SharedSums,
    /// Length by which a segment is prolonged, over the cosine at its end: discs in the plane of the surface may lie
    /// behind it by rounding.
    prolonged: f64,
}

impl<'r> Discs<'r> {
    /// Makes the discs and an index of the given kind over them, in the caller's pool.
    ///
    /// `scene` is the index over the model's triangles, for [`Domain::Visible`]. If the photons are `uniform`, with
    /// weights of 1, and so is the kernel, a disc takes 4 bytes for its sum, else 36.
    ///
    /// # Errors
    /// [`DiscError`].
    pub fn new(
        receivers: &'r [Receiver],
        options: &TangentPlane,
        uniform: bool,
        kind: IndexKind,
        scene: &(dyn RayIndex + Sync),
        fan: &'r Fan,
    ) -> Result<Self, DiscError> {
        let radius = f64::from(options.radius);
        let carriers = carriers(receivers, radius).ok_or(DiscError::TooLarge)?;
        let triangles: Vec<Triangle> = carriers.iter().map(|carrier| carrier.triangle).collect();
        let index = build(kind, &Scene::new(&triangles)).map_err(DiscError::Unbuilt)?;
        let polygons = match options.domain {
            Domain::Disc => Vec::new(),
            Domain::Visible => {
                let lift = f64::from(options.beyond) * radius;
                let polygon = |receiver: &Receiver| fan.polygon(receiver, radius, lift, scene);
                receivers.par_iter().map(polygon).collect()
            }
        };
        // A carrier reaches at most 3.1 radii from its discs' centres.
        let slack = |receiver: &Receiver| receiver.slack(4.0 * radius);
        let prolonged = receivers.iter().map(slack).fold(0.0, f64::max);
        let uniform = uniform && options.kernel == Kernel::Constant;
        let sums = SharedSums::new(receivers.len(), uniform);
        Ok(Self { receivers, options: *options, carriers, index, polygons, sums, prolonged })
    }

    /// Counts the photons of a source that cross each disc, in the caller's pool. The photons are streamed; `progress`
    /// is called from any thread with numbers of photons. May be called again with other photons.
    pub fn count(&self, source: &PhotonSource<'_>, progress: &(impl Fn(u64) + Sync)) -> Balance {
        let index = self.index.index();
        let counter = Counter { discs: self, index: index.as_ray_index(), source };
        source.stream(progress, &counter, |_| {})
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
            + self.sums.bytes()
    }

    /// Makes the estimate of a receiver from photons of `photon_flux` watts each.
    pub fn estimate(&self, receiver: usize, photon_flux: f64) -> Estimate {
        let radius = f64::from(self.options.radius);
        let polygon = self.polygons.get(receiver);
        let area =
            polygon.map_or(disc_area(radius * radius), |polygon| polygon.area(self.options.kernel));
        self.sums.get(receiver).estimate(photon_flux, area, radius)
    }

    fn reach(&self, receiver: &Receiver) -> Reach {
        let radius = f64::from(self.options.radius);
        Reach {
            radius_squared: radius * radius,
            beyond: f64::from(self.options.beyond) * radius,
            slack: receiver.slack(radius),
        }
    }

    /// Adds a segment to the disc of a receiver, if it crosses the disc.
    #[inline]
    fn offer(&self, at: usize, flight: &Flight, weight: [f32; 3]) {
        let Some(receiver) = self.receivers.get(at) else { return };
        let reach = self.reach(receiver);
        let Some(Crossing { offset, distance_squared }) = crossing(receiver, flight, &reach) else {
            return;
        };
        if self.polygons.get(at).is_none_or(|polygon| polygon.contains(offset)) {
            let share = distance_squared / reach.radius_squared;
            self.sums.add(at, weight, self.options.kernel.weight(share));
        }
    }

    /// Adds a segment to every disc that it crosses, without the index: the reference for tests.
    #[cfg(test)]
    pub(super) fn offer_to_all(&self, segment: &Segment, model: &Model) {
        let end = segment.hit.map(|hit| hit_point(&model.triangles[hit.triangle.0 as usize], &hit));
        let flight = Flight::new(segment, end);
        (0..self.receivers.len()).for_each(|at| self.offer(at, &flight, segment.weight));
    }

    /// Returns the count of a receiver.
    #[cfg(test)]
    pub(super) fn count_of(&self, receiver: usize) -> u32 {
        self.sums.get(receiver).count()
    }
}

/// Builds an index over the carriers with the caller's pool.
fn build(kind: IndexKind, scene: &Scene<'_>) -> Result<OwnedIndex, BuildError> {
    let built = TimedIndex::build_with(kind, scene, &Options::default(), &Threads::default())?;
    Ok(built.into_index())
}

/// Counts the segments of a source.
struct Counter<'c> {
    discs: &'c Discs<'c>,
    index: &'c (dyn RayIndex + Sync),
    source: &'c PhotonSource<'c>,
}

impl Visitor for Counter<'_> {
    /// Memory for the carriers that a segment meets.
    type State = Vec<Hit>;

    const CHUNKS_AT_ONCE: u64 = 1 << 10;

    fn begin(&self) -> Vec<Hit> {
        vec![Hit::NONE; HITS]
    }

    fn visit(&self, met: &mut Vec<Hit>, segment: &Segment) {
        if !self.source.bounces.includes(segment.bounce) {
            return;
        }
        let model = self.source.model;
        let end = segment.hit.and_then(|hit| {
            let triangle = model.triangles.get(hit.triangle.0 as usize)?;
            Some((triangle, hit, hit_point(triangle, &hit)))
        });
        let flight = Flight::new(segment, end.map(|(_, _, point)| point));
        let Some(ray) = self.prolonged(segment, end.map(|(triangle, hit, _)| (triangle, hit.t)))
        else {
            return;
        };
        let met = loop {
            let answer = self.index.all_hits(&ray, met);
            if !answer.truncated {
                break answer.hits;
            }
            met.resize(met.len() * 4, Hit::NONE);
        };
        for hit in met {
            let Some(carrier) = self.discs.carriers.get(hit.triangle.0 as usize) else { continue };
            for disc in carrier.discs.clone() {
                self.discs.offer(disc as usize, &flight, segment.weight);
            }
        }
    }

    fn finish(&self, met: &mut Vec<Hit>) {
        *met = Vec::new();
    }
}

impl Counter<'_> {
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
