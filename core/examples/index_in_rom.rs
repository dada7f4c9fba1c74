//! An index in ROM: built on another machine, included in the program, asked where it lies.
//!
//! `square.arb` was written by `as_bytes` of the BVH below; a build script of yours would write such a file. It opens
//! on every little-endian target, 32 or 64 bits. There is no copy and no heap: beside the stack (see the table of
//! [`IndexKind`](arboleda::IndexKind)) a query needs only the `Index`, some 100 bytes.
//!
//! `cargo run -p arboleda --example index_in_rom`

use arboleda::kinds::Bvh;
use arboleda::{Block, Index, Options, Ray, Scene, Triangle, Vec3, include_index};

/// The path is relative to this source file.
static BYTES: &[u8] = include_index!("square.arb");

/// Opens the index once, asks it, and compares it with one that is built here.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    if cfg!(target_endian = "big") {
        return Ok(());
    }
    // 1. Open once, at start-up: that checks all links. The `Index<'static, _>` is `Copy`, `Send` and `Sync`; keep it.
    let index = Index::<Bvh>::from_bytes(BYTES)?;
    assert!(std::ptr::eq(index.as_bytes().as_ptr(), BYTES.as_ptr()), "nothing was copied");

    // 2. Ask.
    let hit = index.closest_hit(&Ray::new(Vec3::new(0.75, 0.25, -1.0), Vec3::Z)?);
    println!("{} bytes: {hit:?}", BYTES.len());
    assert_eq!(hit.map(|hit| (hit.triangle.0, hit.t)), Some((0, 1.0)));

    // 3. The file is what this machine builds.
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let triangles = [Triangle::new(a, b, c), Triangle::new(a, c, d)];
    let (mut arena, mut scratch) = ([Block::ZERO; 8], [Block::ZERO; 8]);
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    let built = Index::<Bvh>::build(&Scene::new(&triangles), &Options::DEFAULT, arena, scratch)?;
    assert_eq!(built.as_bytes(), BYTES, "written by another version: write it anew");
    Ok(())
}
