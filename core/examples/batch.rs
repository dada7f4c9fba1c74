//! Many rays in one call: the same bits as one by one, and faster in the wide BVHs.
//!
//! Memory is the caller's: a dry run says how many bytes the index takes, a bound how many the build needs beside.
//!
//! `cargo run -p arboleda --release --example batch`

use arboleda::kinds::WideBvh;
use arboleda::{BATCH_SCRATCH, Block, Hit, Index, Options, Ray, Scene, Triangle, Vec3};

/// Builds a wide BVH of a hilly square, and asks about 10,000 rays at once.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let triangles = hills(64);
    let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);

    let scratch_bytes = Index::<WideBvh>::scratch_capacity(triangles.len(), &options);
    let mut scratch = vec![Block::ZERO; Block::count(scratch_bytes)];
    let capacity = Index::<WideBvh>::capacity(&scene, &options, Block::bytes(&mut scratch))?;
    let mut arena = vec![Block::ZERO; Block::count(capacity.index)];
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    let index = Index::<WideBvh>::build(&scene, &options, arena, scratch)?;

    // Rays from above, evenly over a square a little larger than the hills.
    let rays = (0..10_000).map(|number| {
        let (x, y) = ((number % 100) as f32, (number / 100) as f32);
        Ray::new(Vec3::new(x * 0.7 - 2.0, y * 0.7 - 2.0, 10.0), Vec3::new(0.1, 0.05, -1.0))
    });
    let rays: Vec<Ray> = rays.collect::<Result<_, _>>()?;

    let mut hits = vec![Hit::NONE; rays.len()];
    let mut scratch = vec![0; BATCH_SCRATCH];
    index.closest_hits_in(&rays, &mut hits, &mut scratch);
    let mut occluded = vec![false; rays.len()];
    index.occluded_each_in(&rays, &mut occluded, &mut scratch);

    for ((ray, hit), occluded) in rays.iter().zip(&hits).zip(&occluded) {
        assert_eq!(index.closest_hit(ray).unwrap_or(Hit::NONE), *hit);
        assert_eq!(*occluded, !hit.is_none());
    }
    let hit_count = hits.iter().filter(|hit| !hit.is_none()).count();
    println!(
        "{} triangles in {} bytes: {hit_count} of {} rays hit",
        triangles.len(),
        capacity.index,
        rays.len()
    );
    assert!(0 < hit_count && hit_count < rays.len());
    Ok(())
}

/// Makes a square of `side * side` cells, two triangles each, of uneven heights.
fn hills(side: u32) -> Vec<Triangle> {
    let corner =
        |x: u32, y: u32| Vec3::new(x as f32, y as f32, ((7 * x + 3 * y) % 5) as f32 * 0.25);
    let cell = |x: u32, y: u32| {
        let (a, b, c, d) = (corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
        [Triangle::new(a, b, c), Triangle::new(a, c, d)]
    };
    (0..side * side).flat_map(|number| cell(number % side, number / side)).collect()
}
