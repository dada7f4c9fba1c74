//! Rays to replay and their answers: found once, asked of every contender.
//!
//! Emission and bouncing cost as much as a fast query and are the same for all, so they are done beforehand. A
//! photon's path does not depend on the index, and neither do its rays.
//!
//! *Closest hit*: the rays of photons, which begin at a light or on a surface and go anywhere. *Occluded*: the same
//! rays; every second one ends just before its hit (free), the others do not end (blocked, if there is a hit). *Leaks*:
//! rays from inside a closed mesh at its edges and corners; each must hit.

use std::ops::Range;

use anyhow::{Context, ensure};
use arboleda::{Hit, IndexKind, Options, Ray, RayIndex, Triangle, Vec3};

use crate::TimedIndex;
use crate::benchmark::contenders::contender::Mode;
use crate::photon::{DEFAULT_MAX_BOUNCES, PhotonRandom, Tracer};
use crate::scene::Model;
use crate::scene::closed::Inside;

/// The index that finds the rays of photons, and the hits that others are compared with.
const GUIDE: IndexKind = IndexKind::WideBvh;

/// Photons whose rays indices are built and selected by.
pub const SAMPLE_PHOTONS: u64 = 512;
/// Photons that are followed before a scene counts as dark: if none of them has a ray, no photon has.
const DARK: u64 = 256;
/// The end of a free occlusion ray, as a share of the way to the hit: so far before it that rounding
/// does not decide.
const FREE_SHARE: f32 = 0.99;

/// Rays of some photons in order, and the exact answers.
///
/// Invariants: `hits` has one entry for each ray; `ends` ascends, and its last entry is the number of rays;
/// `occluded` has one entry for each shadow ray.
#[derive(Default)]
pub struct Workload {
    rays: Vec<Ray>,
    /// Closest hits; [`Hit::NONE`] where there is none.
    pub hits: Vec<Hit>,
    /// Number of rays of the photons up to and with this one.
    ends: Vec<usize>,
    /// Occlusion rays; none before [`Workload::with_shadow_rays`].
    shadow_rays: Vec<Ray>,
    /// True where something is in a shadow ray's way.
    pub occluded: Vec<bool>,
}

impl Workload {
    /// Follows photons with the help of a fast index.
    ///
    /// # Errors
    /// If the model cannot be indexed, or nothing in it emits.
    pub fn of_photons(model: &Model, photons: u64, seed: u64) -> anyhow::Result<Self> {
        let guide = TimedIndex::build(GUIDE, &model.scene(), &Options::default())
            .with_context(|| format!("cannot build an index of {}", model.name))?;
        let index = guide.index();
        let workload =
            Self::follow(model, index.as_ray_index(), seed, |emitted, _| emitted == photons);
        ensure!(!workload.rays.is_empty(), "nothing in {} emits photons", model.name);
        Ok(workload)
    }

    /// Follows photons until there are `count` rays; fewer if the model has no light. `index` answers.
    pub fn of_rays(model: &Model, index: &(dyn RayIndex + Sync), count: usize, seed: u64) -> Self {
        let mut workload = Self::follow(model, index, seed, |_, rays| rays >= count);
        workload.rays.truncate(count);
        workload.hits.truncate(count);
        if let Some(last) = workload.ends.last_mut() {
            *last = workload.rays.len();
        }
        workload
    }

    /// Follows photons one by one, until `is_enough` of photons and of rays.
    fn follow(
        model: &Model,
        index: &(dyn RayIndex + Sync),
        seed: u64,
        is_enough: impl Fn(u64, usize) -> bool,
    ) -> Self {
        let tracer = Tracer::new(model, seed, DEFAULT_MAX_BOUNCES);
        let (mut rays, mut ends) = (Vec::new(), Vec::new());
        for photon in 0.. {
            let is_dark = photon >= DARK && rays.is_empty();
            if is_enough(photon, rays.len()) || is_dark {
                break;
            }
            tracer.rays(index, photon..photon + 1, |ray| rays.push(*ray));
            ends.push(rays.len());
        }
        let hits = rays.iter().map(|ray| index.closest_hit(ray).unwrap_or(Hit::NONE)).collect();
        Self { rays, hits, ends, ..Self::default() }
    }

    /// Adds occlusion rays, half of them shortened. `index` answers.
    #[must_use]
    pub fn with_shadow_rays(mut self, index: &(dyn RayIndex + Sync)) -> Self {
        let shortened = |(place, (ray, hit)): (usize, (&Ray, &Hit))| {
            if place.is_multiple_of(2) || hit.is_none() {
                return *ray;
            }
            let end = hit.t * FREE_SHARE;
            Ray::with_interval(ray.origin(), ray.direction(), ray.t_min(), end).unwrap_or(*ray)
        };
        self.shadow_rays = self.rays.iter().zip(&self.hits).enumerate().map(shortened).collect();
        self.occluded = self.shadow_rays.iter().map(|ray| index.occluded(ray)).collect();
        self
    }

    /// Aims rays from inside a closed mesh at points of its edges and at its corners: for every mode the same. The
    /// answers are left out: each must hit.
    pub fn of_leaks(triangles: &[Triangle], inside: Inside, count: usize, seed: u64) -> Self {
        let photons = (0..).map(|number| PhotonRandom::new(seed, number));
        let rays = photons.filter_map(|random| leak_ray(triangles, inside, random));
        let rays: Vec<Ray> = rays.take(count).collect();
        Self { shadow_rays: rays.clone(), rays, ..Self::default() }
    }

    /// Returns the rays that a mode asks about.
    pub fn rays(&self, mode: Mode) -> &[Ray] {
        match mode {
            Mode::Single | Mode::Batch => &self.rays,
            Mode::Occluded => &self.shadow_rays,
        }
    }

    /// Counts the photons.
    pub fn photon_count(&self) -> u64 {
        self.ends.len() as u64
    }

    /// Returns the rays to build and select indices by.
    pub fn sample(&self) -> &[Ray] {
        self.rays_of_first(SAMPLE_PHOTONS)
    }

    /// Returns the rays of the first photons.
    pub fn rays_of_first(&self, photons: u64) -> &[Ray] {
        &self.rays[self.range(photons)]
    }

    /// Returns the closest hits of these rays.
    pub fn hits_of_first(&self, photons: u64) -> &[Hit] {
        &self.hits[self.range(photons)]
    }

    fn range(&self, photons: u64) -> Range<usize> {
        let photons = photons.min(self.photon_count()) as usize;
        0..photons.checked_sub(1).map_or(0, |last| self.ends[last])
    }
}

/// Aims one ray; nothing if its target is where it begins.
fn leak_ray(triangles: &[Triangle], inside: Inside, mut random: PhotonRandom) -> Option<Ray> {
    let triangle = &triangles[random.bits() as usize % triangles.len()];
    let (p, q) = match random.bits() % 3 {
        0 => (triangle.a, triangle.b),
        1 => (triangle.b, triangle.c),
        _ => (triangle.c, triangle.a),
    };
    // A corner, the middle, anywhere on the edge.
    let along = match random.bits() % 3 {
        0 => 0.0,
        1 => 0.5,
        _ => random.uniform(),
    };
    // From the middle itself, from near it, and from half-way to the closest triangle.
    let spread = [0.0, 0.1, 0.5][random.bits() as usize % 3];
    let mut coordinate = || random.uniform() * 2.0 - 1.0;
    let cube = Vec3::new(coordinate(), coordinate(), coordinate());
    let target = p + (q - p) * along;
    let origin = inside.centre + cube * (spread * inside.radius / 3.0_f32.sqrt());
    Ray::new(origin, target - origin).ok()
}

/// Tells whether two answers are the same bit for bit; `==` would take -0.0 for 0.0.
pub fn same_bits(a: Hit, b: Hit) -> bool {
    bits(a) == bits(b)
}

/// Returns a hit as four words.
pub fn bits(hit: Hit) -> [u32; 4] {
    [hit.triangle.0, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::paper::fig2;

    #[test]
    fn prefixes_are_whole_photons() {
        let model = fig2();
        let [few, many] = [20, 50].map(|count| Workload::of_photons(&model, count, 1).unwrap());
        assert_eq!(few.rays, many.rays_of_first(20));
        assert_eq!(many.rays_of_first(0), []);
        assert_eq!(many.rays_of_first(9_999).len(), many.rays.len());
        assert_eq!(many.hits_of_first(50).len(), many.rays.len());
    }

    #[test]
    fn as_many_rays_as_asked_for_are_those_of_the_first_photons() {
        let model = fig2();
        let guide = TimedIndex::build(GUIDE, &model.scene(), &Options::default()).unwrap();
        let index = guide.index();
        let workload = Workload::of_rays(&model, index.as_ray_index(), 100, 1)
            .with_shadow_rays(index.as_ray_index());
        assert_eq!(workload.rays, Workload::of_photons(&model, 200, 1).unwrap().rays[..100]);
        assert_eq!([workload.hits.len(), workload.rays(Mode::Occluded).len()], [100; 2]);
        assert_eq!(workload.rays_of_first(u64::MAX).len(), 100);
        let free = workload.occluded.iter().skip(1).step_by(2).filter(|occluded| !**occluded);
        assert_eq!(free.count(), 50);
    }

    #[test]
    fn a_model_without_light_is_an_error() {
        let dark = Model { lights: Vec::new(), ..fig2() };
        assert!(Workload::of_photons(&dark, 10, 1).is_err());
    }
}
