//! Digests of a small fixed scene and fixed rays through every index, one line for each index.
//!
//! Scene and rays are made of integers and exactly representable fractions, so all targets start from the same bits.
//! The digests show whether they end with the same bits:
//!
//! - Hits are the same on every target and for every index.
//! - Counters are the same on every target.
//! - Index bytes are the same on every target, read as numbers of 32 bits in the machine's byte order.
//!
//! `golden.txt` has the lines, with which `.ci/run digests` compares those of each target. If a digest is meant to
//! change: `cargo run --release --bin hosted >golden.txt`.
#![no_std]

#[cfg(all(target_arch = "arm", target_os = "none"))]
pub mod cortex_m;
pub mod cost;
#[cfg(target_arch = "arm")]
pub mod stack;

use core::fmt::{self, Write};
use core::ptr::addr_of_mut;
use core::sync::atomic::{AtomicBool, Ordering};

use arboleda::{
    AnyIndex, Block, Counters, Hit, IndexKind, Options, Ray, Scene, SimdLevel, Triangle, Vec3,
};

/// Squares along each side of the floor.
const FLOOR: usize = 6;
/// Cubes of a group along each axis.
const CUBES: usize = 2;
/// Position and cube side of each group.
const GROUPS: [(Vec3, f32); 4] = [
    (Vec3::new(-12.0, 0.0, -9.0), 1.0),
    (Vec3::new(7.5, 0.0, -8.0), 1.5),
    (Vec3::new(-6.0, 0.0, 10.25), 0.75),
    // The fourth group is above the floor, and too small for the size class of the others.
    (Vec3::new(9.0, 5.0, 9.0), 0.03125),
];
const CUBE_TRIANGLES: usize = 12;
const TRIANGLES: usize = 2 * FLOOR * FLOOR + GROUPS.len() * CUBES * CUBES * CUBES * CUBE_TRIANGLES;

const RAYS: u32 = 400;
/// Room for all hits, too little for some rays, so that the digest covers truncation.
const MOST_HITS: usize = 4;
/// Rays of a batch query: one more than are traced in turn.
const IN_A_BATCH: usize = 5;

/// Blocks of the arena and of the scratch: 256 KiB each, ten times the need of most of these indices.
const BLOCKS: usize = 4096;

struct Memory {
    triangles: [Triangle; TRIANGLES],
    arena: [Block; BLOCKS],
    scratch: [Block; BLOCKS],
}

static mut MEMORY: Memory = Memory {
    triangles: [Triangle::new(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO); TRIANGLES],
    arena: [Block::ZERO; BLOCKS],
    scratch: [Block::ZERO; BLOCKS],
};

/// Returns the static memory to the first caller, and `None` to all others.
fn memory() -> Option<&'static mut Memory> {
    static TAKEN: AtomicBool = AtomicBool::new(false);
    // Not a swap, which a Cortex-M0 does not have.
    let taken = TAKEN.load(Ordering::Relaxed);
    TAKEN.store(true, Ordering::Relaxed);
    // SAFETY: the programs have one thread, and no interrupt calls this. So only the first caller gets the reference.
    (!taken).then(|| unsafe { &mut *addr_of_mut!(MEMORY) })
}

/// Kinds whose queries use SIMD beyond what the program is compiled for.
pub const SIMD_KINDS: [IndexKind; 6] = [
    IndexKind::WideBvh,
    IndexKind::WideBvhHierarchy,
    IndexKind::CompactBvh,
    IndexKind::CompactBvhHierarchy,
    IndexKind::LeanBvh,
    IndexKind::LeanBvhHierarchy,
];

/// Writes one line for each index. Succeeds only once.
///
/// # Errors
/// If the output, a build or the opening of an index fails.
pub fn run(out: &mut dyn Write) -> fmt::Result {
    run_each(IndexKind::ALL, SimdLevel::detect(), out)
}

/// Writes one line for each of some kinds of index, whose queries use a SIMD level. Succeeds only once.
///
/// # Errors
/// The errors of [`run`].
pub fn run_each(kinds: &[IndexKind], level: SimdLevel, out: &mut dyn Write) -> fmt::Result {
    let memory = memory().ok_or(fmt::Error)?;
    if write_scene(&mut memory.triangles) != TRIANGLES {
        writeln!(out, "the scene has another number of triangles")?;
        return Err(fmt::Error);
    }
    let scene = Scene::new(&memory.triangles);
    let options = Options::default();
    let (arena, scratch) = (Block::bytes(&mut memory.arena), Block::bytes(&mut memory.scratch));
    for &kind in kinds {
        match line(kind, level, &scene, &options, arena, scratch) {
            Ok(line) => writeln!(out, "{line}")?,
            Err(reason) => {
                writeln!(out, "{}: {reason}", kind.name())?;
                return Err(fmt::Error);
            }
        }
    }
    Ok(())
}

/// Line of results that are compared across targets.
struct Line {
    name: &'static str,
    hits: Digest,
    counters: Digest,
    index: Digest,
    bytes: usize,
    hit_count: u32,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, hits, counters, index, bytes, hit_count } = self;
        let (hits, counters, index) = (hits.0, counters.0, index.0);
        write!(f, "{name} {hit_count} of {RAYS} rays hit, {bytes} bytes, ")?;
        write!(f, "hits={hits:016x} counters={counters:016x} index={index:016x}")
    }
}

fn line(
    kind: IndexKind,
    level: SimdLevel,
    scene: &Scene<'_>,
    options: &Options,
    arena: &mut [u8],
    scratch: &mut [u8],
) -> Result<Line, &'static str> {
    // The index is built in an arena of exactly the required size, and opened from its bytes.
    let capacity = kind.capacity(scene, options, scratch).map_err(|_| "capacity failed")?;
    let arena = arena.get_mut(..capacity.index).ok_or("BLOCKS is too low")?;
    kind.build(scene, options, arena, scratch).map_err(|_| "build failed")?;
    let index = at_level(kind.from_bytes(arena).map_err(|_| "its bytes were refused")?, level);

    let mut line = Line {
        name: kind.name(),
        hits: Digest::EMPTY,
        counters: Digest::EMPTY,
        index: Digest::EMPTY,
        bytes: index.as_bytes().len(),
        hit_count: 0,
    };
    for word in index.as_bytes().as_chunks().0 {
        line.index.word(u32::from_ne_bytes(*word));
    }
    let mut numbers = Numbers(1);
    for number in 0..RAYS {
        if let Ok(ray) = ray(number, &mut numbers) {
            ask(&index, &ray, &mut line);
        }
    }
    Ok(line)
}

/// The same index, with queries at a SIMD level if they use SIMD.
fn at_level(index: AnyIndex<'_>, level: SimdLevel) -> AnyIndex<'_> {
    use AnyIndex::{
        CompactBvh, CompactBvhHierarchy, LeanBvh, LeanBvhHierarchy, WideBvh, WideBvhHierarchy,
    };
    match index {
        WideBvh(index) => WideBvh(index.with_simd_level(level)),
        WideBvhHierarchy(index) => WideBvhHierarchy(index.with_simd_level(level)),
        CompactBvh(index) => CompactBvh(index.with_simd_level(level)),
        CompactBvhHierarchy(index) => CompactBvhHierarchy(index.with_simd_level(level)),
        LeanBvh(index) => LeanBvh(index.with_simd_level(level)),
        LeanBvhHierarchy(index) => LeanBvhHierarchy(index.with_simd_level(level)),
        other => other,
    }
}

/// Adds all answers about one ray to the digests.
fn ask(index: &AnyIndex<'_>, ray: &Ray, line: &mut Line) {
    let mut counters = Counters::default();
    let closest = index.closest_hit_counted(ray, &mut counters);
    let occluded = index.occluded_counted(ray, &mut counters);
    let mut buffer = [Hit::NONE; MOST_HITS];
    let all = index.all_hits(ray, &mut buffer);
    let mut batch = [Hit::NONE; IN_A_BATCH];
    index.closest_hits(&[*ray; IN_A_BATCH], &mut batch);

    line.hit_count += u32::from(closest.is_some());
    line.hits.word(u32::from(occluded) + 2 * u32::from(all.truncated));
    for hit in closest.iter().chain(all.hits).chain(&batch) {
        line.hits.word(hit.triangle.0);
        for number in [hit.t, hit.u, hit.v] {
            line.hits.word(number.to_bits());
        }
    }
    for count in [counters.nodes_visited, counters.triangle_tests] {
        line.counters.bytes(&count.to_le_bytes());
    }
}

/// Fills `triangles`. Returns the number of triangles of the scene, whether they fit or not.
fn write_scene(triangles: &mut [Triangle]) -> usize {
    let mut slots = triangles.iter_mut();
    let mut count = 0;
    let mut square = |corner: Vec3, u: Vec3, v: Vec3| {
        let (near, far) = (corner, corner + u + v);
        for side in [corner + u, corner + v] {
            if let Some(slot) = slots.next() {
                *slot = Triangle::new(near, side, far);
            }
            count += 1;
        }
    };
    let grid = |i: usize, j: usize, k: usize| Vec3::new(i as f32, j as f32, k as f32);
    for i in 0..FLOOR {
        for k in 0..FLOOR {
            let corner = grid(i, 0, k) * 6.0 - Vec3::new(18.0, 0.0, 18.0);
            square(corner, Vec3::X * 6.0, Vec3::Z * 6.0);
        }
    }
    for (origin, side) in GROUPS {
        for at in 0..CUBES * CUBES * CUBES {
            let place = grid(at % CUBES, at / CUBES % CUBES, at / CUBES / CUBES);
            let lo = origin + place * (1.5 * side);
            let axes = [Vec3::X * side, Vec3::Y * side, Vec3::Z * side];
            let [x, y, z] = axes;
            for (u, v, w) in [(x, y, z), (y, z, x), (z, x, y)] {
                square(lo, u, v);
                square(lo + w, u, v);
            }
        }
    }
    count
}

/// Makes ray `number`. There are eight sorts: random, along an axis, at a corner, along a face, from inside a cube,
/// from far away, with a tiny direction, and lines.
fn ray(number: u32, numbers: &mut Numbers) -> Result<Ray, arboleda::RayError> {
    let anywhere = numbers.point() * 24.0;
    let target = numbers.point() * 16.0;
    let (group, side) = GROUPS[number as usize / 8 % GROUPS.len()];
    match number % 8 {
        0 => Ray::new(anywhere, target - anywhere),
        1 => Ray::new(Vec3::new(anywhere.x, 30.0, anywhere.z), Vec3::NEG_Y),
        2 => Ray::new(anywhere, group - anywhere), // a corner
        3 => Ray::new(group - Vec3::X * 4.0, Vec3::new(2.0, 0.0, 0.0)), // edges, and the floor's plane
        4 => Ray::new(group + Vec3::splat(side * 0.5), numbers.point()),
        5 => Ray::new(anywhere * 1.0e6, target - anywhere * 1.0e6),
        6 => Ray::with_interval(anywhere, (target - anywhere) * 1.0e-30, 1.0e29, 1.0e30),
        _ => Ray::with_interval(target, numbers.point() * 1.0e-40, -f32::INFINITY, f32::INFINITY),
    }
}

/// Pseudo-random numbers by xorshift (G. Marsaglia 2003).
struct Numbers(u32);

impl Numbers {
    /// Draws a multiple of 2^-10 in -1..1.
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 >> 21) as f32 / 1024.0 - 1.0
    }

    fn point(&mut self) -> Vec3 {
        let (x, y, z) = (self.next(), self.next(), self.next());
        Vec3::new(x, y, z)
    }
}

/// Digest by FNV-1a, 64 bits (Fowler, Noll, Vo).
struct Digest(u64);

impl Digest {
    const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Adds a number, lowest byte first, independent of the machine's byte order.
    fn word(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }
}
