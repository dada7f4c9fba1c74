//! What the tests of the interface are given: the mesh and the rays of the examples, and memory for an index.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use arboleda::{Block, Hit};
use arboleda_ffi::*;

/// Mesh of the examples, as arrays that C takes.
pub struct Given {
    pub vertices: Vec<[f32; 3]>,
    pub corners: Vec<[u32; 3]>,
}

impl Given {
    /// Reads `examples/groups.obj`, as the examples do.
    pub fn groups() -> Self {
        let (mut vertices, mut corners) = (Vec::new(), Vec::new());
        for line in include_str!("../../examples/groups.obj").lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    vertices.push([(); 3].map(|()| words.next().unwrap().parse().unwrap()))
                }
                Some("f") => {
                    let corner = |word: &str| word.parse::<u32>().unwrap() - 1;
                    corners.push([(); 3].map(|()| corner(words.next().unwrap())));
                }
                _ => {}
            }
        }
        Self { vertices, corners }
    }

    /// The mesh as vertices and corners.
    pub fn indexed(&self) -> arb_mesh {
        arb_mesh {
            vertices: self.vertices.as_ptr().cast(),
            corners: self.corners.as_ptr().cast(),
            triangle_count: self.corners.len(),
            vertex_count: self.vertices.len(),
            ..no_mesh()
        }
    }

    /// Nine numbers for each triangle.
    pub fn triangles(&self) -> Vec<[[f32; 3]; 3]> {
        let vertex = |&corner: &u32| self.vertices[corner as usize];
        self.corners.iter().map(|corners| [0, 1, 2].map(|i| vertex(&corners[i]))).collect()
    }

    /// Makes the rays of the examples.
    pub fn rays(&self, count: usize) -> Vec<arb_ray> {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for vertex in &self.vertices {
            for axis in 0..3 {
                low[axis] = low[axis].min(vertex[axis]);
                high[axis] = high[axis].max(vertex[axis]);
            }
        }
        let mut state = 1_u32;
        let mut draw = || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            (state >> 21) as f32 / 1024.0 - 1.0
        };
        let mut ray = || {
            let (mut origin, mut direction) = ([0.0; 3], [0.0; 3]);
            for axis in 0..3 {
                let (centre, half) =
                    ((low[axis] + high[axis]) * 0.5, (high[axis] - low[axis]) * 0.5);
                let from = draw() * half * 2.0;
                let to = draw() * half;
                origin[axis] = centre + from;
                direction[axis] = centre + to - origin[axis];
            }
            arb_ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
        };
        (0..count).map(|_| ray()).collect()
    }
}

/// A mesh without triangles.
pub fn no_mesh() -> arb_mesh {
    arb_mesh {
        triangles: null(),
        vertices: null(),
        corners: null(),
        objects: null(),
        triangle_count: 0,
        vertex_count: 0,
    }
}

pub const CLOSED: arb_index = arb_index { opaque: [0; ARB_INDEX_WORDS] };
pub const NO_HIT: arb_hit = arb_hit { triangle: ARB_NO_TRIANGLE, t: f32::INFINITY, u: 0.0, v: 0.0 };

pub fn default_options() -> arb_options {
    let mut options: arb_options = bytemuck::Zeroable::zeroed();
    let status = unsafe { arb_options_default(&mut options, size_of::<arb_options>()) };
    assert_eq!(status, arb_status::ARB_OK);
    options
}

pub fn empty_error() -> arb_error {
    arb_error {
        status: arb_status::ARB_OTHER_REASON,
        element: 77,
        needed_bytes: 77,
        given_bytes: 77,
        message: [1; ARB_MESSAGE_BYTES],
    }
}

/// The message of an error.
pub fn message(error: &arb_error) -> String {
    let bytes: Vec<u8> = error.message.iter().map(|&byte| byte as u8).collect();
    CStr::from_bytes_until_nul(&bytes).unwrap().to_str().unwrap().to_owned()
}

/// Index that was built by the interface, and its memory.
pub struct Built {
    pub index: arb_index,
    pub memory: Vec<Block>,
    pub bytes: usize,
}

/// Builds an index, as a C program does: scratch, measure, build.
pub fn build(kind: u32, mesh: &arb_mesh, options: &arb_options) -> Result<Built, Box<arb_error>> {
    let mut error = empty_error();
    let mut scratch_bytes = 0;
    let count = mesh.triangle_count;
    let bytes = &mut scratch_bytes;
    let status = unsafe { arb_scratch_bytes(kind, count, options, bytes, &mut error) };
    if status != arb_status::ARB_OK {
        return Err(Box::new(error));
    }
    let mut scratch = vec![Block::ZERO; Block::count(scratch_bytes)];
    let mut capacity = arb_capacity { index_bytes: 0, scratch_bytes: 0, steps: 0 };
    let first = scratch.as_mut_ptr().cast();
    let status = unsafe {
        arb_measure(kind, mesh, options, first, scratch_bytes, &mut capacity, &mut error)
    };
    if status != arb_status::ARB_OK {
        return Err(Box::new(error));
    }
    assert!(capacity.scratch_bytes <= scratch_bytes && capacity.index_bytes > 0);
    let mut memory = vec![Block::ZERO; Block::count(capacity.index_bytes)];
    let bytes = capacity.index_bytes;
    let mut index = CLOSED;
    let status = unsafe {
        let room = memory.as_mut_ptr().cast();
        arb_build(&mut index, kind, mesh, options, room, bytes, first, scratch_bytes, &mut error)
    };
    if status == arb_status::ARB_OK {
        Ok(Built { index, memory, bytes })
    } else {
        Err(Box::new(error))
    }
}

/// Asks about rays as a batch.
pub fn closest_each(index: &arb_index, rays: &[arb_ray], scratch: &mut [u8]) -> Vec<arb_hit> {
    let mut hits = vec![arb_hit { triangle: 7, ..NO_HIT }; rays.len()];
    let (first, count) = (scratch.as_mut_ptr().cast(), scratch.len());
    let status = unsafe {
        let to = hits.as_mut_ptr();
        arb_closest_each(index, rays.as_ptr(), rays.len(), to, first, count, null_mut())
    };
    assert_eq!(status, arb_status::ARB_OK);
    hits
}

pub fn core_hit(hit: arb_hit) -> Option<Hit> {
    let hit: Hit = bytemuck::cast(hit);
    (!hit.is_none()).then_some(hit)
}

/// FNV-1a, 64 bits, of the four words of each hit, lowest byte first.
pub fn digest(hits: &[arb_hit]) -> u64 {
    let words = hits.iter().flat_map(|hit| bytemuck::cast::<arb_hit, [u32; 4]>(*hit));
    words.flat_map(u32::to_le_bytes).fold(0xcbf2_9ce4_8422_2325, |digest, byte| {
        (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// A pointer that is not aligned for anything larger than a byte.
pub fn odd<T>(value: *mut T) -> *mut T {
    value.wrapping_byte_add(1)
}
