//! Final gathering: irradiance at a point from the radiance of the surfaces that the point sees.
//!
//! ```text
//!     \   |   /       rays with a cosine distribution around the normal; at the end of each, an estimate
//!       \ | /
//!   ------x------     at the point, an estimate from photons straight from the lights
//! ```
//! `E = direct + pi * mean radiance at the ends`, where the radiance is the colour times the estimate there, over pi.
//! The noise of the estimates at the ends averages out, so that indirect light is smooth. A ray that hits nothing adds
//! nothing, and neither does what a surface emits, because that is part of the direct light.
//!
//! Random numbers are functions of the seed and of the point's number in the picture.
//!
//! # Source
//! H. W. Jensen, *Global Illumination using Photon Maps*, 1996, section 5; the direct light by photons is ours.

use arboleda::Ray;
use rayon::prelude::*;

use super::batch;
use crate::density::{
    Bounces, Estimate, EstimateWork, EstimatorError, LightField, PhotonSource, Receiver, rounded,
};
use crate::photon::PhotonRandom;
use crate::scene::Model;

/// About the number of ends that are estimated at once: 300 MB of discs.
const ENDS_AT_ONCE: usize = 2_000_000;

/// Final gathering of a pass.
pub(super) struct Gathering<'s> {
    direct: LightField<'s>,
    rays: u32,
    /// Number of the next point.
    next: u64,
}

/// End of a ray.
struct End {
    /// Point from which the ray was cast, among those that are gathered together.
    point: usize,
    triangle: u32,
    receiver: Receiver,
}

/// Sums over the rays of a point.
#[derive(Clone, Copy, Default)]
struct Gathered {
    exitance: [f64; 3],
    /// Sum over the rays of the square of the mean of the three channels.
    squares: f64,
    count: u32,
}

impl<'s> Gathering<'s> {
    /// Prepares gathering by `rays` rays a point, 2 or more, in a field of direct light. `point` is the number of the
    /// first point.
    pub fn new(direct: LightField<'s>, rays: u32, point: u64) -> Self {
        Self { direct, rays, next: point }
    }

    /// Returns the source of direct light, of the photons of a source. Their paths end at their first hit, because
    /// later segments do not count.
    pub fn direct(source: &PhotonSource<'s>) -> PhotonSource<'s> {
        PhotonSource { bounces: Bounces::Direct, max_bounces: 0, ..source.clone() }
    }

    /// Returns the field of direct light.
    pub fn into_direct(self) -> LightField<'s> {
        self.direct
    }

    /// Estimates the irradiance at the next points of the picture, in their order, in the caller's pool. `field` is the
    /// light at the ends.
    ///
    /// The count is that of all photons that were found, and the radius that of the direct estimate. The standard error
    /// is the root of the sum of two squares: the direct estimate's, and that of the mean over the rays.
    ///
    /// # Errors
    /// [`EstimatorError::Disc`].
    pub fn estimates(
        &mut self,
        field: &LightField<'s>,
        points: &[Receiver],
        photons: &(impl Fn(u64) + Sync),
        estimates: &(impl Fn(u64) + Sync),
    ) -> Result<(Vec<Estimate>, EstimateWork), EstimatorError> {
        // The balance is that of whole paths, without points too.
        if points.is_empty() {
            return field.estimates(points, photons, estimates);
        }
        let model = field.source().model;
        let (mut all, mut work) = self.direct.estimates(points, photons, estimates)?;
        let at_once = (ENDS_AT_ONCE / self.rays as usize).max(1);
        for (points, direct) in points.chunks(at_once).zip(all.chunks_mut(at_once)) {
            // 1. The rays, and the estimates at their ends.
            let ends = self.ends(field.source(), points);
            let receivers: Vec<Receiver> = ends.iter().map(|end| end.receiver).collect();
            let (found, more) = field.estimates(&receivers, photons, estimates)?;
            work = work.and(&more);
            self.next += points.len() as u64;

            // 2. The sums of each point.
            let mut sums = vec![Gathered::default(); points.len()];
            for (end, estimate) in ends.iter().zip(&found) {
                sums[end.point].add(model, end.triangle, estimate);
            }
            for (estimate, sum) in direct.iter_mut().zip(&sums) {
                sum.add_to(estimate, self.rays);
            }
        }
        Ok((all, work))
    }

    /// Casts the rays of points, and finds their ends.
    fn ends(&self, source: &PhotonSource<'_>, points: &[Receiver]) -> Vec<End> {
        /// Points whose rays are answered together.
        const SOME: usize = 64;
        let (seed, model) = (!source.seed, source.model);
        let of_some = |scratch: &mut Vec<u8>, (chunk, some): (usize, &[Receiver])| {
            let mut rays: Vec<(usize, Ray)> = Vec::new();
            for (point, receiver) in (chunk * SOME..).zip(some) {
                // The complement of the seed is not the key of photons.
                let mut random = PhotonRandom::new(seed, self.next + point as u64);
                let cast = (0..self.rays).filter_map(|_| receiver.ray_from(&mut random));
                rays.extend(cast.map(|ray| (point, ray)));
            }
            let hits = batch::closest_hits(source.index, &rays, scratch);
            let ends = rays.iter().zip(hits).filter_map(|((point, ray), hit)| {
                let triangle = model.triangles.get(hit.triangle.0 as usize)?;
                let receiver = Receiver::at_hit(triangle, &hit, ray.direction())?;
                Some(End { point: *point, triangle: hit.triangle.0, receiver })
            });
            ends.collect::<Vec<_>>()
        };
        let chunks = points.par_chunks(SOME).enumerate();
        let mut ends: Vec<End> = chunks.map_init(batch::scratch, of_some).flatten_iter().collect();
        // Ends of one plane that are near each other share the carriers of their discs. The sort is stable, so their
        // order is a function of the points.
        let side = f64::from(self.direct.estimator().radius());
        ends.par_sort_by_cached_key(|end| (end.receiver.normal_bits(), cell(&end.receiver, side)));
        ends
    }
}

/// Returns the number of the cell of a position in a grid, in Morton's order. Cells that follow each other are near
/// each other.
fn cell(receiver: &Receiver, side: f64) -> u64 {
    /// Bits of a coordinate.
    const BITS: u32 = 21;
    let middle = f64::from(1_u32 << (BITS - 1));
    // Cells beyond the grid are those at its border.
    let place =
        |x: f32| ((f64::from(x) / side).floor() + middle).clamp(0.0, 2.0 * middle - 1.0) as u64;
    let [x, y, z] = receiver.position().to_array().map(place);
    (0..BITS).fold(0, |code, bit| {
        code | (x >> bit & 1) << (3 * bit)
            | (y >> bit & 1) << (3 * bit + 1)
            | (z >> bit & 1) << (3 * bit + 2)
    })
}

impl Gathered {
    fn add(&mut self, model: &Model, triangle: u32, estimate: &Estimate) {
        let exitance = estimate.exitance(model.colour(triangle));
        for (sum, exitance) in self.exitance.iter_mut().zip(exitance) {
            *sum += exitance;
        }
        let mean = (exitance[0] + exitance[1] + exitance[2]) / 3.0;
        self.squares += mean * mean;
        self.count = self.count.saturating_add(estimate.count);
    }

    /// Adds the gathered light to an estimate of the direct light.
    fn add_to(&self, estimate: &mut Estimate, rays: u32) {
        // The radiance is the exitance over pi, and the irradiance pi times the mean of the radiance.
        let rays = f64::from(rays);
        for (value, exitance) in estimate.irradiance.iter_mut().zip(self.exitance) {
            *value = rounded(f64::from(*value) + exitance / rays);
        }
        let mean = (self.exitance[0] + self.exitance[1] + self.exitance[2]) / 3.0 / rays;
        let variance = (self.squares / rays - mean * mean).max(0.0) / (rays - 1.0).max(1.0);
        let direct = f64::from(estimate.standard_error);
        estimate.standard_error = rounded((direct * direct + variance).sqrt());
        estimate.count = estimate.count.saturating_add(self.count);
    }
}
