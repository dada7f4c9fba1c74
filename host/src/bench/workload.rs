//! The rays that every contender answers, and the right answers.
//!
//! *Closest hit*: the rays of photons, which begin at a light or on a surface and go anywhere. *Occluded*:
//! the same rays; every second one ends just before its hit (free), the others do not end (blocked, if
//! there is a hit). *Leaks*: rays from inside a closed mesh at its edges and corners: each must hit.

use arboleda::{Hit, Ray, RayIndex, Triangle, Vec3};

use crate::photon::{DEFAULT_MAX_BOUNCES, PhotonRandom, Tracer};
use crate::scene::Model;
use crate::scene::closed::Inside;

/// Rays and what is to be answered.
pub struct Workload {
    /// Closest-hit rays in the order in which photons go.
    pub rays: Vec<Ray>,
    /// Their closest hits by `arboleda`.
    pub hits: Vec<Hit>,
    /// Occlusion rays.
    pub shadow_rays: Vec<Ray>,
    /// Whether anything is in their way, by `arboleda`.
    pub occluded: Vec<bool>,
}

/// The end of a free occlusion ray, as a share of the way to the hit: so far before it that rounding
/// does not decide.
const FREE_SHARE: f32 = 0.99;

impl Workload {
    /// Follows photons until there are `count` rays; fewer if the model has no light. `index` answers.
    pub fn new(model: &Model, index: &(dyn RayIndex + Sync), count: usize, seed: u64) -> Self {
        let tracer = Tracer::new(model, seed, DEFAULT_MAX_BOUNCES);

        // 1. Photons in portions, until there are enough rays.
        let mut rays = Vec::with_capacity(count + PORTION as usize);
        let mut photon = 0;
        while rays.len() < count {
            let before = rays.len();
            tracer.rays(index, photon..photon + PORTION, |ray| rays.push(*ray));
            photon += PORTION;
            if rays.len() == before {
                break;
            }
        }
        rays.truncate(count);

        // 2. Their answers.
        let closest = |ray: &Ray| index.closest_hit(ray).unwrap_or(Hit::NONE);
        let hits: Vec<Hit> = rays.iter().map(closest).collect();

        // 3. Half of them shortened.
        let shortened = |place: usize| {
            let (ray, hit) = (rays[place], hits[place]);
            if place.is_multiple_of(2) || hit.is_none() {
                return ray;
            }
            let end = hit.t * FREE_SHARE;
            Ray::with_interval(ray.origin(), ray.direction(), ray.t_min(), end).unwrap_or(ray)
        };
        let shadow_rays: Vec<Ray> = (0..rays.len()).map(shortened).collect();
        let occluded = shadow_rays.iter().map(|ray| index.occluded(ray)).collect();
        Self { rays, hits, shadow_rays, occluded }
    }
}

/// Photons between two looks at the number of rays.
const PORTION: u64 = 256;

/// Rays from inside a closed mesh at points of its edges and at its corners.
pub fn leak_rays(triangles: &[Triangle], inside: Inside, count: usize, seed: u64) -> Vec<Ray> {
    let mut rays = Vec::with_capacity(count);
    for number in 0.. {
        if rays.len() >= count {
            break;
        }
        let mut random = PhotonRandom::new(seed, number);
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
        rays.extend(Ray::new(origin, target - origin));
    }
    rays
}
