//! An index that the device builds itself, in static memory and without a heap, of triangles that it learned on the way.
#![no_std]
#![no_main]

use core::fmt::{self, Write};
use core::ptr::addr_of_mut;

use arboleda::kinds::Bvh;
use arboleda::{Block, BuildError, Index, IndexKind, Options, Scene, Triangle, Vec3};
use arboleda_firmware::board::Console;
use arboleda_firmware::{ANSWERS, program, yard};

/// The most triangles of a yard.
const MOST: usize = yard::TRIANGLES;
/// Scratch that a build of this many never exceeds. It is free again after the build.
const SCRATCH: usize = IndexKind::Bvh.scratch_capacity(MOST, &Options::DEFAULT);
/// Bytes of the index. If they are too few, the error says how many are needed; so does `Index::capacity`.
const ARENA: usize = 12 << 10;

struct Memory {
    triangles: [Triangle; MOST],
    arena: [Block; Block::count(ARENA)],
    scratch: [Block; Block::count(SCRATCH)],
}

static mut MEMORY: Memory = Memory {
    triangles: [Triangle::new(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO); MOST],
    arena: [Block::ZERO; Block::count(ARENA)],
    scratch: [Block::ZERO; Block::count(SCRATCH)],
};

program!(main);

fn main() -> fmt::Result {
    // SAFETY: this function runs once, and nothing else uses the memory.
    let Memory { triangles, arena, scratch } = unsafe { &mut *addr_of_mut!(MEMORY) };

    // 1. Learn the triangles, here from the code, elsewhere from a sensor or a bus.
    *triangles = yard::triangles();

    // 2. Build: no allocation, and a bound on the steps for any triangles.
    let index = match build(triangles, arena, scratch) {
        Ok(index) => index,
        Err(error) => {
            writeln!(Console, "{error}")?;
            return Err(fmt::Error);
        }
    };

    // 3. Ask. The PC, which built an index of the same triangles, got the same bits.
    for (ray, answer) in yard::rays().zip(&ANSWERS) {
        let hit = index.closest_hit(&ray.map_err(|_| fmt::Error)?);
        if hit.map(|hit| (hit.triangle.0, hit.t.to_bits())) != *answer {
            writeln!(Console, "{hit:?}, the PC answered {answer:?}")?;
            return Err(fmt::Error);
        }
    }
    let bytes = index.as_bytes().len();
    writeln!(Console, "{} rays, {bytes} bytes of index, {SCRATCH} of scratch", yard::RAYS)
}

fn build<'a>(
    triangles: &'a [Triangle],
    arena: &'a mut [Block],
    scratch: &mut [Block],
) -> Result<Index<'a, Bvh>, BuildError> {
    let scene = Scene::new(triangles);
    Index::build(&scene, &Options::DEFAULT, Block::bytes(arena), Block::bytes(scratch))
}
