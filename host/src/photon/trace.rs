//! One photon's life.
//!
//! ```text
//! emission -> closest_hit -+-> nothing: escaped
//!                ^         +-> roulette lost: absorbed
//!                |         +-> too many bounces: cut off
//!                +- bounce +
//! ```
//!
//! A photon survives a hit with the probability that the triangle reflects, so its flux never
//! changes, and it goes on in a cosine distribution on the side it came from. Its path is a function of the
//! model, the seed and the photon's number; every index gives the same.
//!
//! # Source
//! J. Arvo, D. Kirk, *Particle Transport and Image Synthesis*, 1990, for the roulette; H. W. Jensen,
//! *Global Illumination using Photon Maps*, 1996.

use std::ops::Range;

use arboleda::{Hit, Ray, RayIndex};

use super::emission::Emitter;
use super::hemisphere::cosine_direction;
use super::offset::Departure;
use super::random::PhotonRandom;
use crate::scene::Model;

/// The usual limit of bounces. At a reflectance of 0.8, 6 photons in 10 million come this far.
pub const DEFAULT_MAX_BOUNCES: u32 = 64;

/// One straight piece of a photon's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The photon's number.
    pub photon: u64,
    /// How often it had bounced before: 0 for the piece that begins at the light.
    pub bounce: u32,
    /// Where it begins and in which direction it goes; of unit length up to rounding.
    pub ray: Ray,
    /// What it ends at; `None` if it leaves the scene.
    pub hit: Option<Hit>,
}

/// How a photon's path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PathEnd {
    /// The triangle it hit last did not reflect it.
    Absorbed,
    /// It hit nothing any more.
    Escaped,
    /// It would have bounced once more than is allowed.
    CutOff,
    /// No valid ray begins there: beyond the range of `f32`, or in doubt on which side of the
    /// triangle it is. Also the end of a photon that hit a triangle that the model does not have.
    Refused,
}

/// A photon on its way.
#[derive(Clone, Debug)]
pub struct Path {
    photon: u64,
    bounce: u32,
    ray: Ray,
    random: PhotonRandom,
}

impl Path {
    /// Where it goes next.
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// The piece that ends at `hit`.
    pub fn segment(&self, hit: Option<Hit>) -> Segment {
        Segment { photon: self.photon, bounce: self.bounce, ray: self.ray, hit }
    }
}

/// Follows the photons of a model.
#[derive(Clone, Debug)]
pub struct Tracer<'m> {
    model: &'m Model,
    emitter: Emitter,
    seed: u64,
    max_bounces: u32,
}

impl<'m> Tracer<'m> {
    /// Prepares the model's lights. A path has at most `max_bounces + 1` segments.
    pub fn new(model: &'m Model, seed: u64, max_bounces: u32) -> Self {
        Self { model, emitter: Emitter::new(&model.lights), seed, max_bounces }
    }

    /// The lights.
    pub fn emitter(&self) -> &Emitter {
        &self.emitter
    }

    /// Lets one photon leave the light.
    ///
    /// A model without light emits nothing: `None`. Allocates nothing and never panics; so below.
    #[inline]
    pub fn emit(&self, photon: u64) -> Option<Result<Path, PathEnd>> {
        let mut random = PhotonRandom::new(self.seed, photon);
        let emission = self.emitter.emit(&mut random)?;
        let ray = Ray::new(emission.origin, emission.direction);
        Some(ray.map(|ray| Path { photon, bounce: 0, ray, random }).map_err(|_| PathEnd::Refused))
    }

    /// Lets a photon bounce where its ray hits, or says how its path ends there.
    #[inline]
    pub fn bounce(&self, path: &mut Path, hit: Option<Hit>) -> Option<PathEnd> {
        let Some(hit) = hit else {
            return Some(PathEnd::Escaped);
        };
        // A draw is below 1: a reflectance of 1 always survives, 0 and NaN never do.
        let id = hit.triangle.0 as usize;
        let reflectance = self.model.reflectance.get(id).copied().unwrap_or(0.0);
        let survives = path.random.uniform() < reflectance;
        if !survives {
            return Some(PathEnd::Absorbed);
        }
        if path.bounce >= self.max_bounces {
            return Some(PathEnd::CutOff);
        }

        let bounced = self.model.triangles.get(id).and_then(|triangle| {
            let departure = Departure::new(triangle, &hit, path.ray.direction())?;
            let direction = cosine_direction(departure.unit_normal(), &mut path.random);
            departure.ray(direction.rounded())
        });
        let Some(bounced) = bounced else {
            return Some(PathEnd::Refused);
        };
        path.ray = bounced;
        path.bounce += 1;
        None
    }

    /// Follows one photon. `closest_hit` asks an index over the model's triangles; `observe` sees
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

    /// Shows all rays of some photons in order, found with the help of any index: for benches that
    /// replay the same rays on every other.
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
