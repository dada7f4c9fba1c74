//! An index beside a mesh that the program keeps anyway: no triangle is copied.
//!
//! `cargo run -p arboleda --example beside_a_mesh`

use arboleda::kinds::LeanBvh;
use arboleda::{Block, Index, Mesh, Options, Ray, Scene, Vec3};

/// Builds a lean BVH beside vertices and corners, and opens its bytes beside the same mesh and beside another.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A strip of 200 triangles along x, by vertices that they share.
    let vertices: Vec<Vec3> =
        (0..202).map(|number| Vec3::new((number / 2) as f32, (number % 2) as f32, 0.0)).collect();
    let corners: Vec<[u32; 3]> = (0..200).map(|first| [first, first + 1, first + 2]).collect();
    let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };

    let (scene, options) = (Scene::of(mesh).beside(), Options::DEFAULT);
    let scratch_bytes = Index::<LeanBvh>::scratch_capacity(mesh.len(), &options);
    let mut scratch = vec![Block::ZERO; Block::count(scratch_bytes)];
    let capacity = Index::<LeanBvh>::capacity(&scene, &options, Block::bytes(&mut scratch))?;
    let mut arena = vec![Block::ZERO; Block::count(capacity.index)];
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    let index = Index::<LeanBvh>::build(&scene, &options, arena, scratch)?;

    let ray = Ray::new(Vec3::new(50.25, 0.25, -1.0), Vec3::Z)?;
    let hit = index.closest_hit(&ray).ok_or("the ray meets the strip")?;
    println!(
        "triangle {}, by {} bytes for {} triangles of 36 bytes",
        hit.triangle.0,
        capacity.index,
        mesh.len()
    );
    assert_eq!((hit.triangle.0, hit.t), (100, 1.0));
    assert!(capacity.index < 12 * mesh.len());

    // The bytes are of use beside this mesh only; a fingerprint in their header tells another from it.
    let opened = Index::<LeanBvh>::from_bytes_beside(index.as_bytes(), mesh)?;
    assert_eq!(opened.closest_hit(&ray), Some(hit));
    let other = Mesh::Indexed { vertices: &vertices, corners: &corners[1..] };
    let refused = Index::<LeanBvh>::from_bytes_beside(index.as_bytes(), other).err();
    println!("beside another mesh: {}", refused.ok_or("refused")?);
    Ok(())
}
