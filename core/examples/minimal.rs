//! One triangle, one index, one ray: the shortest way, for programs that have a heap.
//!
//! `cargo run -p arboleda --features alloc --example minimal`

use arboleda::{IndexKind, Options, OwnedIndex, Ray, Scene, Triangle, Vec3};

/// Builds an index that owns its memory, and asks for the closest hit of a ray.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
    let owned = OwnedIndex::build(IndexKind::WideBvh, &Scene::new(&triangles), &Options::DEFAULT)?;
    let index = owned.index();

    let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z)?;
    let hit = index.closest_hit(&ray).ok_or("the ray meets the triangle")?;
    println!("triangle {} at t = {}, u = {}, v = {}", hit.triangle.0, hit.t, hit.u, hit.v);
    assert_eq!((hit.triangle.0, hit.t, hit.u, hit.v), (0, 1.0, 0.25, 0.25));
    Ok(())
}
