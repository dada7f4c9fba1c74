//! Path of one photon.
//!
//! ```text
//! emission -> closest_hit -+-> no hit: escaped
//!                ^         +-> roulette lost: absorbed
//!                |         +-> too many bounces: cut off
//!                +- bounce +
//! ```
//!
//! A photon survives a hit with a probability of the triangle's reflectance, so its flux stays constant. It bounces
//! into the side it came from, with a cosine distribution. A coloured triangle multiplies the weight of each colour by
//! that colour over the mean of the colours, so the path depends on the mean only.
//!
//! A path is a function of the model, the seed and the photon's number. It is the same with every index.
//!
//! # Source
//! J. Arvo, D. Kirk, *Particle Transport and Image Synthesis*, 1990, for the roulette; H. W. Jensen,
//! *Global Illumination using Photon Maps*, 1996.

use std::ops::Range;

use arboleda::{Hit, Ray, RayIndex, Triangle};

use super::emission::Emitter;
use super::random::PhotonRandom;
use super::surface::hemisphere::cosine_direction;
use super::surface::offset::Departure;
use crate::scene::Model;

/// Default of the most bounces. At a reflectance of 0.8, 6 photons in 10 million reach it.
pub const DEFAULT_MAX_BOUNCES: u32 = 64;

/// Straight segment of a photon's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The photon's number.
    pub photon: u64,
    /// Number of bounces before the segment; 0 for the segment from the light.
    pub bounce: u32,
    /// Ray of the segment. Its direction has unit length up to rounding.
    pub ray: Ray,
    /// Hit at the end of the segment; `None` if the photon leaves the scene.
    pub hit: Option<Hit>,
    /// Factors of red, green and blue by which the photon's flux is multiplied. All are 1 in a grey model.
    pub weight: [f32; 3],
}

/// Reason why a photon's path ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathEnd {
    /// The last triangle absorbed the photon.
    Absorbed,
    /// The last ray hit no triangle.
    Escaped,
    /// The photon reached the most bounces.
    CutOff,
    /// No valid ray begins at the last point: it is beyond the range of `f32`, or the side of the triangle is in doubt,
    /// or the model does not have the triangle.
    Refused,
}

/// Photon during tracing: its next ray and its random numbers.
#[derive(Clone, Debug)]
pub struct Path {
    pub(super) bounce: u32,
    pub(super) ray: Ray,
    pub(super) weight: [f32; 3],
    pub(super) random: PhotonRandom,
}

impl Path {
    /// Returns the next ray.
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// Makes the segment of the next ray, which ends at `hit`.
    pub fn segment(&self, hit: Option<Hit>) -> Segment {
        Segment {
            photon: self.random.place().photon,
            bounce: self.bounce,
            ray: self.ray,
            hit,
            weight: self.weight,
        }
    }
}

/// Tracer of a model's photons.
#[derive(Clone, Debug)]
pub struct Tracer<'m> {
    // Columns of the model, as slices.
    triangles: &'m [Triangle],
    reflectance: &'m [f32],
    colours: &'m [[f32; 3]],
    emitter: Emitter,
    seed: u64,
    max_bounces: u32,
}

impl<'m> Tracer<'m> {
    /// Creates a tracer. A path has at most `max_bounces + 1` segments.
    pub fn new(model: &'m Model, seed: u64, max_bounces: u32) -> Self {
        let Model { triangles, reflectance, colours, .. } = model;
        Self { triangles, reflectance, colours, emitter: Emitter::of(model), seed, max_bounces }
    }

    /// Returns the emitter of the model's lights.
    pub fn emitter(&self) -> &Emitter {
        &self.emitter
    }

    /// Returns the model's triangles.
    #[inline]
    pub(super) fn triangles(&self) -> &'m [Triangle] {
        self.triangles
    }

    /// Returns the seed of the random numbers.
    pub(super) fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns the most bounces of a path.
    pub(super) fn max_bounces(&self) -> u32 {
        self.max_bounces
    }

    /// Emits a photon; `None` if no light of the model can emit. Allocates nothing and never panics.
    pub fn emit(&self, photon: u64) -> Option<Result<Path, PathEnd>> {
        let mut random = PhotonRandom::new(self.seed, photon);
        let emission = self.emitter.emit(&mut random)?;
        let ray = Ray::new(emission.origin, emission.direction);
        let weight = emission.weight;
        let path = ray.map(|ray| Path { bounce: 0, ray, weight, random });
        Some(path.map_err(|_| PathEnd::Refused))
    }

    /// Lets a photon bounce at a hit, or returns why its path ends there. Allocates nothing and never panics.
    pub fn bounce(&self, path: &mut Path, hit: Option<Hit>) -> Option<PathEnd> {
        let Some(hit) = hit else {
            return Some(PathEnd::Escaped);
        };
        // A draw is below 1, so a photon always survives a reflectance of 1, and never one of 0 or NaN.
        let survives = path.random.uniform() < self.reflectance(&hit);
        if !survives {
            return Some(PathEnd::Absorbed);
        }
        if path.bounce >= self.max_bounces {
            return Some(PathEnd::CutOff);
        }

        let id = hit.triangle.0 as usize;
        let bounced = self.triangles.get(id).and_then(|triangle| {
            let departure = Departure::new(triangle, &hit, path.ray.direction())?;
            let direction = cosine_direction(departure.unit_normal(), &mut path.random);
            departure.ray(direction.rounded())
        });
        let Some(bounced) = bounced else {
            return Some(PathEnd::Refused);
        };
        path.ray = bounced;
        path.bounce += 1;
        self.colour(&hit, &mut path.weight);
        None
    }

    /// Returns the reflectance at a hit; 0 without a hit.
    #[inline]
    pub(super) fn reflectance(&self, hit: &Hit) -> f32 {
        // Read in any case, and selected after that: a branch would be mispredicted wherever photons escape.
        let (id, all) = (hit.triangle.0 as usize, self.reflectance);
        let is_known = id < all.len();
        let read = all.get(if is_known { id } else { 0 }).copied().unwrap_or(0.0);
        if is_known { read } else { 0.0 }
    }

    /// Multiplies a photon's weights by the colours of a triangle that reflects it.
    #[inline]
    pub(super) fn colour(&self, hit: &Hit, weights: &mut [f32; 3]) {
        if let Some(colour) = self.colours.get(hit.triangle.0 as usize) {
            let reflectance = self.reflectance(hit);
            for (weight, share) in weights.iter_mut().zip(colour) {
                *weight *= share / reflectance;
            }
        }
    }

    /// Follows one photon to its end. `closest_hit` queries an index over the model's triangles. `observe` receives
    /// each segment in order.
    #[inline]
    pub fn follow(
        &self,
        photon: u64,
        mut closest_hit: impl FnMut(&Ray) -> Option<Hit>,
        mut observe: impl FnMut(&Segment),
    ) -> Option<PathEnd> {
        let mut path = match self.emit(photon)? {
            Ok(path) => path,
            Err(end) => return Some(end),
        };
        loop {
            let hit = closest_hit(path.ray());
            observe(&path.segment(hit));
            if let Some(end) = self.bounce(&mut path, hit) {
                return Some(end);
            }
        }
    }

    /// Calls `each` with all rays of a range of photons, in order, traced through any index. Benches replay these rays
    /// on every other index.
    pub fn rays<I: RayIndex + ?Sized>(
        &self,
        index: &I,
        photons: Range<u64>,
        mut each: impl FnMut(&Ray),
    ) {
        for photon in photons {
            self.follow(photon, |ray| index.closest_hit(ray), |segment| each(&segment.ray));
        }
    }
}
