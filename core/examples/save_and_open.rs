//! The arena is the file: write an index, read it back, ask it in place.
//!
//! For an index in ROM, without a copy, see `index_in_rom`.
//!
//! `cargo run -p arboleda --example save_and_open`

use arboleda::kinds::{Clustered, Octree};
use arboleda::{AnyIndex, Block, Index, OpenError, Options, Ray, Scene, Triangle, Vec3};

/// Builds an octree hierarchy, writes it to a file, opens the file's bytes, and damages them.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let near = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
    let far = Vec3::splat(50.0);
    let triangles = [near, Triangle::new(far, far + Vec3::X, far + Vec3::Y)];
    let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z)?;

    // 1. Build, and write the used part of the arena.
    let path = std::env::temp_dir().join(format!("arboleda-{}.arb", std::process::id()));
    let (mut arena, mut scratch) = ([Block::ZERO; 8], [Block::ZERO; 64]);
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
    let built = Index::<Clustered<Octree>>::build(&scene, &options, arena, scratch)?;
    std::fs::write(&path, built.as_bytes())?;

    // 2. Read it into aligned memory. Opening checks every link once, and copies nothing.
    let file = std::fs::read(&path)?;
    std::fs::remove_file(&path)?;
    let mut blocks = vec![Block::ZERO; Block::count(file.len())];
    let bytes = Block::bytes(&mut blocks);
    bytes[..file.len()].copy_from_slice(&file);
    let opened = AnyIndex::from_bytes(bytes)?;
    println!("{} bytes: {}", file.len(), opened.kind().name());
    assert_eq!(opened.kind().name(), "octree-hierarchy");
    assert_eq!(opened.closest_hit(&ray), built.closest_hit(&ray));
    assert!(opened.occluded(&ray));

    // 3. Bytes that are no index are refused, and so are those of an index cut short.
    let cut_off = AnyIndex::from_bytes(&bytes[..file.len() - 4]).err();
    println!("cut off: {}", cut_off.ok_or("refused")?);
    assert_eq!(cut_off, Some(OpenError::Truncated));
    Ok(())
}
