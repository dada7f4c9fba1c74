//! The crate `parry3d`: a binary hierarchy, walked closest child first.
//!
//! Its hierarchy is used with the triangles laid out one after the other rather than its `TriMesh`,
//! which looks the corners up by index and came to 0.75 to 0.85 of the speed. The triangle test is its own,
//! which is not watertight.

use std::time::Instant;

use arboleda::{Hit, Ray, Triangle, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::{Ray as ParryRay, RayCast};
use parry3d::shape::Triangle as ParryTriangle;

use crate::benchmark::contenders::contender::Contender;
use crate::benchmark::contenders::peer::{BuiltPeer, Peer, Setting, found};

/// Both of its builders.
pub const PEER: Peer = Peer {
    name: "parry3d",
    settings: &[
        Setting { name: "binned", build: |t| Ok(Parry::build(t, BvhBuildStrategy::Binned)) },
        Setting { name: "ploc", build: |t| Ok(Parry::build(t, BvhBuildStrategy::Ploc)) },
    ],
};

struct Parry {
    bvh: Bvh,
    triangles: Vec<ParryTriangle>,
}

impl Parry {
    fn build(triangles: &[Triangle], strategy: BvhBuildStrategy) -> BuiltPeer {
        let triangles: Vec<_> = triangles
            .iter()
            .map(|t| ParryTriangle::new(vector(t.a), vector(t.b), vector(t.c)))
            .collect();
        let start = Instant::now();
        let boxes: Vec<Aabb> = triangles.iter().map(ParryTriangle::local_aabb).collect();
        let bvh = Bvh::from_leaves(strategy, &boxes);
        let build_seconds = start.elapsed().as_secs_f64();
        BuiltPeer { contender: Box::new(Self { bvh, triangles }), build_seconds }
    }

    #[inline]
    fn test(&self, id: u32, ray: &ParryRay, last: f32) -> Option<f32> {
        self.triangles[id as usize].cast_local_ray(ray, last, true)
    }
}

fn vector(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

impl Contender for Parry {
    fn bytes(&self) -> Option<usize> {
        Some(self.bvh.total_memory_size() + size_of_val(self.triangles.as_slice()))
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, answer) in rays.iter().zip(hits) {
            let theirs = ParryRay::new(vector(ray.origin()), vector(ray.direction()));
            let hit =
                self.bvh.cast_ray(&theirs, ray.t_max(), |id, last| self.test(id, &theirs, last));
            *answer = hit.map_or(Hit::NONE, |(triangle, t)| found(triangle, t));
        }
    }

    // It has no query for "any hit". A closest-hit query whose first hit counts as the closest possible
    // enters nothing any more after it. Its general traversal with an early exit, and a box test of our
    // own, was within 5% either way.
    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(answers) {
            let theirs = ParryRay::new(vector(ray.origin()), vector(ray.direction()));
            let hit = self.bvh.cast_ray(&theirs, ray.t_max(), |id, last| {
                self.test(id, &theirs, last).map(|_| f32::NEG_INFINITY)
            });
            *answer = hit.is_some();
        }
    }
}
