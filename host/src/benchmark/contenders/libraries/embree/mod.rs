//! Intel's Embree 4, opened at run time: nothing of it is needed to compile.
//!
//! ```text
//! library (the file, its functions) -> scene (safe: build, one ray, eight rays) -> Contender
//! layout  (the C structures) ---------/
//! ```
//! Version 4 has no ray streams any more, so several rays together are a packet. The processor's mode
//! that flushes subnormal numbers to zero, which Embree recommends, stays off: it is a state of the
//! thread and would change the arithmetic of the others.
//!
//! # Source
//! I. Wald, S. Woop, C. Benthin, G. S. Johnson, M. Ernst, *Embree: A Kernel Framework for Efficient CPU
//! Ray Tracing*, 2014; the headers `rtcore_*.h` of Embree 4.4.

mod layout;
#[allow(unsafe_code)] // a C interface; all of it is called here
mod library;

use std::time::Instant;

use arboleda::{Hit, Ray, Triangle};

use self::layout::{Packet, RayHit, SingleRay};
use self::library::{Config, EmbreeScene, Quality, Robustness};
use crate::benchmark::contenders::PeerError;
use crate::benchmark::contenders::contender::{Batch, Contender};
use crate::benchmark::contenders::mesh::WeldedMesh;
use crate::benchmark::contenders::peer::{BuiltPeer, Peer, Setting};

/// One quality on AVX2 and on the best there is.
macro_rules! both_isas {
    ($quality:ident) => {
        &[
            Setting {
                name: "isa=avx2",
                build: |t| build(t, AVX2, Quality::$quality, Robustness::Fast),
            },
            Setting {
                name: "isa=best",
                build: |t| build(t, BEST, Quality::$quality, Robustness::Fast),
            },
        ]
    };
}

/// Each quality on each of them.
macro_rules! both_qualities {
    ($robustness:ident) => {{
        use Quality::{High, Medium};
        use Robustness::$robustness;
        &[
            Setting { name: "medium, isa=avx2", build: |t| build(t, AVX2, Medium, $robustness) },
            Setting { name: "medium, isa=best", build: |t| build(t, BEST, Medium, $robustness) },
            Setting { name: "high, isa=avx2", build: |t| build(t, AVX2, High, $robustness) },
            Setting { name: "high, isa=best", build: |t| build(t, BEST, High, $robustness) },
        ]
    }};
}

/// Binned surface area; the usual triangle test.
pub const MEDIUM: Peer = Peer { name: "embree4-medium", settings: both_isas!(Medium) };

/// Spatial splits; the usual triangle test.
pub const HIGH: Peer = Peer { name: "embree4-high", settings: both_isas!(High) };

/// The scene flag "robust": boxes with a margin and Plücker coordinates for the triangles.
pub const ROBUST: Peer = Peer { name: "embree4-robust", settings: both_qualities!(Robust) };

/// The scene flags "robust" and "compact": quantised boxes, and triangles that look their corners up in the
/// mesh, which is counted too.
pub const COMPACT: Peer =
    Peer { name: "embree4-compact", settings: both_qualities!(RobustCompact) };

/// AVX-512, which "best" takes where there is any, was often the slower.
const AVX2: Config = Config(c"threads=1,isa=avx2");
const BEST: Config = Config(c"threads=1");

struct Embree {
    scene: EmbreeScene,
}

fn build(
    triangles: &[Triangle],
    config: Config,
    quality: Quality,
    robustness: Robustness,
) -> Result<BuiltPeer, PeerError> {
    // A program that uses Embree has a mesh with shared corners, and would not pay for finding them.
    let mesh = WeldedMesh::of(triangles);
    let start = Instant::now();
    let scene = EmbreeScene::build(&mesh, config, quality, robustness)?;
    let build_seconds = start.elapsed().as_secs_f64();
    Ok(BuiltPeer { contender: Box::new(Embree { scene }), build_seconds })
}

impl Contender for Embree {
    fn bytes(&self) -> Option<usize> {
        Some(self.scene.bytes())
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, answer) in rays.iter().zip(hits) {
            let mut query = RayHit::new(ray);
            self.scene.intersect(&mut query);
            *answer = query.answer();
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(answers) {
            let mut query = SingleRay::new(ray);
            self.scene.occluded(&mut query);
            *answer = query.is_occluded();
        }
    }

    fn batch(&self) -> Option<&dyn Batch> {
        Some(self)
    }
}

impl Batch for Embree {
    fn closest_hits_together(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (rays, hits) in rays.chunks(Packet::WIDTH).zip(hits.chunks_mut(Packet::WIDTH)) {
            let mut packet = Packet::new(rays);
            self.scene.intersect_packet(&mut packet);
            for (lane, hit) in hits.iter_mut().enumerate() {
                *hit = packet.answer(lane);
            }
        }
    }
}
