//! Memory and instructions of a kind of index, in one line: `index=` bytes of the yard's index, `scratch=` bytes that
//! its build may need, `ask=` bytes of stack of queries, `open=` and `build=` of those, `ray=` instructions of a closest
//! hit, the mean of a turn, and `built=` instructions of the build.
//!
//! The emulator has to count instructions, one each nanosecond: `-icount shift=0`.
#![no_std]
#![no_main]

mod clock;
mod stack;

use core::fmt::{self, Write};
use core::hint::black_box;
use core::ptr::addr_of_mut;

use arboleda::{Block, Hit, Index, Options, Ray, Scene, Triangle, Vec3};
use arboleda_firmware::board::Console;
use arboleda_firmware::kind::Kind;
use arboleda_firmware::{IN_FLASH, program, yard};

/// Blocks of the arena and of the scratch, far more than any kind needs.
const BLOCKS: usize = 8192;

struct Memory {
    triangles: [Triangle; yard::TRIANGLES],
    arena: [Block; BLOCKS],
    scratch: [Block; BLOCKS],
}

static mut MEMORY: Memory = Memory {
    triangles: [Triangle::new(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO); yard::TRIANGLES],
    arena: [Block::ZERO; BLOCKS],
    scratch: [Block::ZERO; BLOCKS],
};

program!(main);

fn main() -> fmt::Result {
    // SAFETY: this function runs once, and nothing else uses the memory.
    let Memory { triangles, arena, scratch } = unsafe { &mut *addr_of_mut!(MEMORY) };
    let (arena, scratch) = (Block::bytes(arena), Block::bytes(scratch));
    *triangles = yard::triangles();
    let (scene, options) = (Scene::new(triangles), Options::DEFAULT);
    let scratch_bytes = Index::<Kind>::scratch_capacity(triangles.len(), &options);
    let scratch = scratch.get_mut(..scratch_bytes).ok_or(fmt::Error)?;

    let mut is_built = false;
    let mut build = || is_built = Index::<Kind>::build(&scene, &options, arena, scratch).is_ok();
    let build_stack = stack::used_by(&mut build);
    let built = clock::instructions(&mut build)?;
    let mut opened = None;
    let open_stack = stack::used_by(&mut || opened = Index::<Kind>::from_bytes(IN_FLASH).ok());
    let index = opened.ok_or(fmt::Error)?;
    // A device and the PC build the same bytes.
    if !is_built || arena.get(..IN_FLASH.len()) != Some(IN_FLASH) {
        writeln!(Console, "the build differs from the PC's")?;
        return Err(fmt::Error);
    }

    let ask_stack = stack::used_by(&mut || ask_all(&index, triangles));
    let mut turn = [Ray::new(Vec3::ZERO, Vec3::X).map_err(|_| fmt::Error)?; yard::RAYS];
    for (slot, ray) in turn.iter_mut().zip(yard::rays()) {
        *slot = ray.map_err(|_| fmt::Error)?;
    }
    let rays = clock::instructions(&mut || {
        for ray in &turn {
            black_box(index.closest_hit(ray));
        }
    })?;
    write!(Console, "index={} scratch={scratch_bytes} ask={ask_stack} ", IN_FLASH.len())?;
    writeln!(
        Console,
        "open={open_stack} build={build_stack} ray={} built={built}",
        rays / yard::RAYS as u64
    )
}

/// Asks with the rays of a turn, and with rays that the filters cannot decide: through corners, and from far away.
fn ask_all(index: &Index<'_, Kind>, triangles: &[Triangle]) {
    let eye = Vec3::new(0.0, 0.375, 0.0);
    let corners = triangles.iter().map(|triangle| triangle.a);
    let through = corners.clone().map(|corner| Ray::new(eye, corner - eye));
    let down = corners.clone().map(|corner| Ray::new(corner + Vec3::Y * 64.0, Vec3::NEG_Y));
    let lines = corners.map(|corner| {
        Ray::with_interval(corner, Vec3::new(1.0, 1.0e-38, 0.5), f32::NEG_INFINITY, f32::INFINITY)
    });
    for ray in yard::rays().chain(through).chain(down).chain(lines).flatten() {
        let mut hits = [Hit::NONE; 4];
        black_box((index.closest_hit(&ray), index.occluded(&ray), index.all_hits(&ray, &mut hits)));
    }
}
