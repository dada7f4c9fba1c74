//! Which index? `select` builds the candidates, tries each on some rays, and says why it chose one.
//!
//! `cargo run -p arboleda --release --example choose_an_index`

use arboleda::select::{USUAL, select};
use arboleda::{Block, IndexKind, Options, Ray, Scene, Triangle, Vec3};

/// Chooses an index for a million rays and for one ray, and asks the first of them.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let triangles = villages();
    let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);

    // Room for the largest of the candidates that shall compete: one that does not fit is left out.
    let scratch_bytes = USUAL.iter().map(|kind| kind.scratch_capacity(triangles.len(), &options));
    let mut scratch = vec![Block::ZERO; Block::count(scratch_bytes.max().unwrap_or(0))];
    let mut arena = vec![Block::ZERO; 1 << 14]; // 1 MiB
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));

    let selection = select(&scene.expecting(1_000_000), &options, USUAL, arena, scratch)?;
    println!("for a million rays: {selection}");
    assert_eq!(selection.candidates().len(), USUAL.len());
    assert_ne!(selection.kind(), IndexKind::Linear);

    // The arena's contents are undefined now: build the chosen kind in it.
    let index = selection.kind().build(&scene, &options, arena, scratch)?;
    let ray = Ray::new(Vec3::new(0.5, 0.25, 9.0), Vec3::NEG_Z)?;
    let hit = index.closest_hit(&ray).ok_or("the ray meets a roof")?;
    assert_eq!((hit.triangle.0, hit.t), (0, 9.0));

    // For a single ray no tree pays: all triangles are tested.
    let mut arena = vec![Block::ZERO; 1 << 14];
    let single = select(&scene.expecting(1), &options, USUAL, Block::bytes(&mut arena), scratch)?;
    println!("for one ray: {single}");
    assert_eq!(single.kind(), IndexKind::Linear);
    Ok(())
}

/// Makes two villages far from each other, of 20 times 20 flat roofs each.
fn villages() -> Vec<Triangle> {
    let roof = |number: u32| {
        let (village, x, y) = (number / 400, number % 20, number / 20 % 20);
        let a = Vec3::new((2 * x + 1000 * village) as f32, (2 * y) as f32, 0.0);
        let (b, c, d) = (a + Vec3::X, a + Vec3::X + Vec3::Y, a + Vec3::Y);
        [Triangle::new(a, b, c), Triangle::new(a, c, d)]
    };
    (0..800).flat_map(roof).collect()
}
