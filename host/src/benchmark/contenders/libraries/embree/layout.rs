//! The C structures of Embree 4, field by field, and a mesh as it wants it.
//!
//! The names are those of `rtcore_ray.h`. Its hits end in the numbers of instances: one for each level
//! of instancing the library was compiled with, and from 4.3 on as many again for arrays of instances.
//! None is read here, so there is only room for them, more than enough for the usual single level.

use arboleda::{Hit, Ray};

use crate::benchmark::contenders::peer::found;

/// `RTC_INVALID_GEOMETRY_ID`.
const INVALID: u32 = u32::MAX;

/// `RTCRay`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct SingleRay {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

impl SingleRay {
    #[inline]
    pub(super) fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin().to_array(),
            t_near: ray.t_min(),
            direction: ray.direction().to_array(),
            time: 0.0,
            t_far: ray.t_max(),
            mask: u32::MAX,
            id: 0,
            flags: 0,
        }
    }

    /// Reads what an occlusion query says by the end of the ray.
    #[inline]
    pub(super) fn is_occluded(&self) -> bool {
        self.t_far < 0.0
    }
}

/// `RTCHit`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
struct SingleHit {
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instances: [u32; 5],
}

/// `RTCRayHit`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct RayHit {
    ray: SingleRay,
    hit: SingleHit,
}

// The size in version 4.4.
const _: () = assert!(size_of::<RayHit>() == 96 && align_of::<RayHit>() == 16);

impl RayHit {
    #[inline]
    pub(super) fn new(ray: &Ray) -> Self {
        let hit = SingleHit {
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: INVALID,
            geometry: INVALID,
            instances: [INVALID; 5],
        };
        Self { ray: SingleRay::new(ray), hit }
    }

    #[inline]
    pub(super) fn answer(&self) -> Hit {
        if self.hit.geometry == INVALID {
            return Hit::NONE;
        }
        found(self.hit.primitive, self.ray.t_far)
    }
}

/// As many lanes as AVX2 has. Photon rays have little in common: packets of eight came to 0.9 of the speed
/// of one ray at a time, packets of four to 0.8 to 1.0.
const WIDTH: usize = 8;

/// `RTCRay8`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct PacketRays {
    origin: [[f32; WIDTH]; 3],
    t_near: [f32; WIDTH],
    direction: [[f32; WIDTH]; 3],
    time: [f32; WIDTH],
    t_far: [f32; WIDTH],
    mask: [u32; WIDTH],
    id: [u32; WIDTH],
    flags: [u32; WIDTH],
}

impl PacketRays {
    #[inline]
    fn new(rays: &[Ray]) -> Self {
        let mut packet = Self {
            origin: [[0.0; WIDTH]; 3],
            t_near: [0.0; WIDTH],
            direction: [[1.0; WIDTH]; 3],
            time: [0.0; WIDTH],
            t_far: [0.0; WIDTH],
            mask: [u32::MAX; WIDTH],
            id: [0; WIDTH],
            flags: [0; WIDTH],
        };
        for (lane, ray) in rays.iter().take(WIDTH).enumerate() {
            let (origin, direction) = (ray.origin().to_array(), ray.direction().to_array());
            for axis in 0..3 {
                packet.origin[axis][lane] = origin[axis];
                packet.direction[axis][lane] = direction[axis];
            }
            packet.t_near[lane] = ray.t_min();
            packet.t_far[lane] = ray.t_max();
        }
        packet
    }
}

/// `RTCHit8`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct PacketHits {
    normal: [[f32; WIDTH]; 3],
    u: [f32; WIDTH],
    v: [f32; WIDTH],
    primitive: [u32; WIDTH],
    geometry: [u32; WIDTH],
    instances: [[u32; WIDTH]; 5],
}

/// `RTCRayHit8`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct PacketRayHits {
    rays: PacketRays,
    hits: PacketHits,
}

/// A packet and which of its lanes are in use.
pub(super) struct Packet {
    pub(super) lanes: Lanes,
    pub(super) query: PacketRayHits,
}

impl Packet {
    /// The number of rays in a packet.
    pub(super) const WIDTH: usize = WIDTH;

    /// Takes up to eight rays.
    #[inline]
    pub(super) fn new(rays: &[Ray]) -> Self {
        let hits = PacketHits {
            normal: [[0.0; WIDTH]; 3],
            u: [0.0; WIDTH],
            v: [0.0; WIDTH],
            primitive: [INVALID; WIDTH],
            geometry: [INVALID; WIDTH],
            instances: [[INVALID; WIDTH]; 5],
        };
        let query = PacketRayHits { rays: PacketRays::new(rays), hits };
        Self { lanes: Lanes::first(rays.len()), query }
    }

    #[inline]
    pub(super) fn answer(&self, lane: usize) -> Hit {
        let PacketRayHits { rays, hits } = &self.query;
        if hits.geometry[lane] == INVALID {
            return Hit::NONE;
        }
        found(hits.primitive[lane], rays.t_far[lane])
    }
}

/// The mask of lanes that a packet query reads: -1 for on.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Lanes([i32; WIDTH]);

impl Lanes {
    #[inline]
    fn first(count: usize) -> Self {
        Self(std::array::from_fn(|lane| -i32::from(lane < count)))
    }

    /// Points to the lanes, for the C interface.
    #[inline]
    pub(super) fn as_ptr(&self) -> *const i32 {
        self.0.as_ptr()
    }
}
