//! Smallest program that builds an index: it asks the index for the closest hit of one ray.
#![no_std]
#![no_main]

use core::fmt;
use core::hint::black_box;
use core::ptr::addr_of_mut;

use arboleda::{Block, Index, Options, Ray, Scene, Triangle, Vec3};
use arboleda_firmware::kind::Kind;
use arboleda_firmware::program;

struct Memory {
    triangles: [Triangle; 100],
    arena: [Block; 200],
    scratch: [Block; 800],
}

static mut MEMORY: Memory = Memory {
    triangles: [Triangle::new(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO); 100],
    arena: [Block::ZERO; 200],
    scratch: [Block::ZERO; 800],
};

program!(main);

fn main() -> fmt::Result {
    // SAFETY: this function runs once, and nothing else uses the memory.
    let Memory { triangles, arena, scratch } = unsafe { &mut *addr_of_mut!(MEMORY) };
    let [x, y, z] = black_box([1.0, 2.0, 3.0]);
    let ray = Ray::new(Vec3::ZERO, Vec3::new(x, y, z)).map_err(|_| fmt::Error)?;
    let (arena, scratch) = (Block::bytes(arena), Block::bytes(scratch));
    let scene = Scene::new(black_box(&triangles[..]));
    let index = Index::<Kind>::build(&scene, &Options::DEFAULT, arena, scratch);
    black_box(index.map_err(|_| fmt::Error)?.closest_hit(&ray));
    Ok(())
}
