//! The C++ library tinybvh through the crate `tinybvh-rs`: an eight-wide hierarchy in AVX2.
//!
//! The crate has no query for "any hit", does not let the builder's costs be set, and does not say how
//! much memory it takes. Rays always begin at 0.
//!
//! # Source
//! V. Fuetterling, C. Lojewski, F.-J. Pfreundt, A. Ebert, *Accelerated Single Ray Tracing for Wide
//! Vector Units*, 2017; M. Stich, H. Friedrich, A. Dietrich, *Spatial Splits in Bounding Volume
//! Hierarchies*, 2009.

use arboleda::Triangle;

use crate::benchmark::contenders::PeerError;
use crate::benchmark::contenders::peer::{BuiltPeer, Peer, Setting};

/// With spatial splits and without.
pub const PEER: Peer = Peer {
    name: "tinybvh",
    settings: &[
        Setting { name: "bvh8, spatial splits", build: |t| build(t, Splits::Spatial) },
        Setting { name: "bvh8, binned", build: |t| build(t, Splits::OfObjects) },
    ],
};

/// Way in which the hierarchy divides.
#[derive(Clone, Copy)]
enum Splits {
    /// Triangles may be referred to from both sides.
    Spatial,
    /// Each triangle is on one side.
    OfObjects,
}

#[cfg(not(feature = "tinybvh"))]
fn build(_: &[Triangle], _: Splits) -> Result<BuiltPeer, PeerError> {
    let why_apart = "it needs a C++20 compiler";
    Err(PeerError::NotCompiled { library: "tinybvh", feature: "tinybvh", why_apart })
}

// The crate decides at compile time.
#[cfg(all(feature = "tinybvh", not(target_feature = "avx2")))]
fn build(_: &[Triangle], _: Splits) -> Result<BuiltPeer, PeerError> {
    Err(PeerError::NeedsInstructions { library: "tinybvh", needed: "AVX2" })
}

#[cfg(all(feature = "tinybvh", target_feature = "avx2"))]
fn build(triangles: &[Triangle], splits: Splits) -> Result<BuiltPeer, PeerError> {
    wide::build(triangles, splits)
}

#[cfg(all(feature = "tinybvh", target_feature = "avx2"))]
mod wide {
    use std::time::Instant;

    use arboleda::{Hit, Ray, Triangle, Vec3};
    use tinybvh_rs::{Intersector, Ray as TinyRay, bvh, bvh8_cpu, mbvh};

    use super::Splits;
    use crate::benchmark::contenders::PeerError;
    use crate::benchmark::contenders::contender::Contender;
    use crate::benchmark::contenders::peer::{BuiltPeer, found, refused};

    /// Its leaves hold four triangles side by side.
    const LEAF: u32 = 4;

    pub(super) fn build(triangles: &[Triangle], splits: Splits) -> Result<BuiltPeer, PeerError> {
        let point = |v: Vec3| [v.x, v.y, v.z, 0.0];
        let corners: Vec<[f32; 4]> =
            triangles.iter().flat_map(|t| [point(t.a), point(t.b), point(t.c)]).collect();
        let start = Instant::now();
        let corners = corners.as_slice().into();
        let binary = match splits {
            Splits::Spatial => bvh::BVH::new_hq(corners),
            Splits::OfObjects => bvh::BVH::new(corners),
        };
        let mut binary = binary.map_err(|error| refused("tinybvh", error))?;
        binary.split_leaves(LEAF);
        binary.compact();
        let many = mbvh::BVH::new(&binary);
        let bvh = bvh8_cpu::BVH::new(&many).map_err(|error| refused("tinybvh", error))?;
        let build_seconds = start.elapsed().as_secs_f64();
        Ok(BuiltPeer { contender: Box::new(Wide { bvh }), build_seconds })
    }

    struct Wide {
        bvh: bvh8_cpu::BVH,
    }

    /// The library declares its rays aligned to 64, the crate to 16.
    #[repr(align(64))]
    struct Aligned(TinyRay);

    /// 1/x, and what the library itself takes for it near 0. An infinite one makes boxes that the ray's
    /// origin is level with undecided, which counts as hit, those of empty lanes too: the traversal then
    /// follows a child that is not there.
    #[inline]
    fn reciprocal(x: f32) -> f32 {
        if x.abs() > 1e-12 { 1.0 / x } else { tinybvh_rs::INFINITE.copysign(x) }
    }

    impl Wide {
        #[inline]
        fn hit(&self, ray: &Ray) -> Hit {
            let direction = ray.direction();
            let mut theirs = Aligned(TinyRay {
                origin: ray.origin().to_array(),
                padding_0: 0xFFFF, // the mask of all instances
                dir: direction.to_array(),
                r_d: direction.to_array().map(reciprocal),
                ..TinyRay::default()
            });
            // Its infinity; a larger number would make its test of empty lanes a hit.
            let last = ray.t_max().min(tinybvh_rs::INFINITE);
            theirs.0.hit.t = last;
            self.bvh.intersect(&mut theirs.0);
            let hit = theirs.0.hit;
            if hit.t < last { found(hit.prim, hit.t) } else { Hit::NONE }
        }
    }

    impl Contender for Wide {
        fn bytes(&self) -> Option<usize> {
            None
        }

        fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
            for (ray, answer) in rays.iter().zip(hits) {
                *answer = self.hit(ray);
            }
        }

        fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
            for (ray, answer) in rays.iter().zip(answers) {
                *answer = !self.hit(ray).is_none();
            }
        }
    }
}
