//! The crate `obvhs`: a compressed eight-wide hierarchy, and a binary one.
//!
//! It has no watertight test: its triangle test is Möller's and Trumbore's with the edges and the
//! normal precomputed, and its node boxes are tested without a margin. The triangles are put in the
//! order of the leaves, as its documentation advises; one split in several leaves is stored in each.
//!
//! # Source
//! H. Ylitie, T. Karras, S. Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs*, 2017; D. Meister, J. Bittner, *Parallel Locally-Ordered Clustering for Bounding Volume
//! Hierarchy Construction*, 2018.

use std::time::{Duration, Instant};

use arboleda::glam::Vec3A;
use arboleda::{Hit, Ray, Triangle};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;

use crate::benchmark::contenders::contender::Contender;
use crate::benchmark::contenders::peer::{BuiltPeer, Peer, Setting, found};

/// The presets that build slowly and answer fast. Losers on figure 4(b) and the city: `medium_build`
/// (0.85 to 0.9 of `slow_build`), and the binary hierarchy (0.75 to 0.85 of the wide one), which is left
/// in for scenes of other kinds.
pub const PEER: Peer = Peer {
    name: "obvhs",
    settings: &[
        Setting { name: "cwbvh slow", build: |t| Ok(wide(t, BvhBuildParams::slow_build())) },
        Setting {
            name: "cwbvh very slow",
            build: |t| Ok(wide(t, BvhBuildParams::very_slow_build())),
        },
        Setting {
            name: "bvh2 very slow",
            build: |t| Ok(binary(t, BvhBuildParams::very_slow_build())),
        },
    ],
};

/// Hierarchy of the crate: both kinds answer by methods of the same names.
trait Hierarchy {
    fn bytes(&self) -> usize;
    fn ids(&self) -> &[u32];
    fn closest(&self, ray: ObvhsRay, hit: &mut RayHit, test: impl FnMut(&ObvhsRay, usize) -> f32);
    fn misses(&self, ray: ObvhsRay, test: impl FnMut(&ObvhsRay, usize) -> f32) -> bool;
}

macro_rules! forward_hierarchy {
    ($hierarchy:ty) => {
        impl Hierarchy for $hierarchy {
            fn bytes(&self) -> usize {
                size_of_val(self.nodes.as_slice()) + size_of_val(self.ids())
            }

            fn ids(&self) -> &[u32] {
                &self.primitive_indices
            }

            #[inline]
            fn closest(
                &self,
                ray: ObvhsRay,
                hit: &mut RayHit,
                test: impl FnMut(&ObvhsRay, usize) -> f32,
            ) {
                self.ray_traverse(ray, hit, test);
            }

            #[inline]
            fn misses(&self, ray: ObvhsRay, test: impl FnMut(&ObvhsRay, usize) -> f32) -> bool {
                self.ray_traverse_miss(ray, test)
            }
        }
    };
}
forward_hierarchy!(CwBvh);
forward_hierarchy!(Bvh2);

struct Obvhs<H> {
    hierarchy: H,
    /// In the order of the leaves.
    triangles: Vec<RtTriangle>,
}

fn wide(triangles: &[Triangle], preset: BvhBuildParams) -> BuiltPeer {
    build(triangles, |theirs| build_cwbvh_from_tris(theirs, preset, &mut Duration::default()))
}

fn binary(triangles: &[Triangle], preset: BvhBuildParams) -> BuiltPeer {
    build(triangles, |theirs| build_bvh2_from_tris(theirs, preset, &mut Duration::default()))
}

fn build<H: Hierarchy + 'static>(
    triangles: &[Triangle],
    hierarchy: impl FnOnce(&[obvhs::triangle::Triangle]) -> H,
) -> BuiltPeer {
    let theirs: Vec<_> = triangles
        .iter()
        .map(|triangle| obvhs::triangle::Triangle {
            v0: triangle.a.into(),
            v1: triangle.b.into(),
            v2: triangle.c.into(),
        })
        .collect();
    let start = Instant::now();
    let hierarchy = hierarchy(&theirs);
    let ordered = hierarchy.ids().iter().map(|&id| (&theirs[id as usize]).into()).collect();
    let build_seconds = start.elapsed().as_secs_f64();
    BuiltPeer { contender: Box::new(Obvhs { hierarchy, triangles: ordered }), build_seconds }
}

#[inline]
fn converted(ray: &Ray) -> ObvhsRay {
    let (origin, direction) = (Vec3A::from(ray.origin()), Vec3A::from(ray.direction()));
    ObvhsRay::new(origin, direction, ray.t_min(), ray.t_max())
}

impl<H: Hierarchy> Contender for Obvhs<H> {
    fn bytes(&self) -> Option<usize> {
        Some(self.hierarchy.bytes() + size_of_val(self.triangles.as_slice()))
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        let ids = self.hierarchy.ids();
        for (ray, answer) in rays.iter().zip(hits) {
            let mut hit = RayHit::none();
            self.hierarchy
                .closest(converted(ray), &mut hit, |ray, at| self.triangles[at].intersect(ray));
            *answer = match ids.get(hit.primitive_id as usize) {
                Some(&triangle) => found(triangle, hit.t),
                None => Hit::NONE,
            };
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(answers) {
            *answer =
                !self.hierarchy.misses(converted(ray), |ray, at| self.triangles[at].intersect(ray));
        }
    }
}
