//! A scene file, an index that fits it, and rays from above: which object does each hit?
//!
//! `cargo run --release -p arboleda-host --example obj_to_hits -- city.obj`

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use arboleda::{Hit, Options, OwnedIndex, Ray, Vec3};
use arboleda_host::scene::{Origin, load};
use arboleda_host::select_index;

/// Rays along each side of the scene.
const SIDE: u32 = 100;

/// Counts the hits on the file that is named on the command line; on a comb without a name.
pub fn main() -> Result<(), Box<dyn Error>> {
    let comb = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/files/comb.obj");
    let path = std::env::args().nth(1).unwrap_or_else(|| comb.to_owned());
    run(Path::new(&path)).map(|_| ())
}

/// Shoots rays straight down on the scene, prints the hits on each object, and returns them.
pub fn run(path: &Path) -> Result<BTreeMap<String, usize>, Box<dyn Error>> {
    // 1. Load. OBJ, PLY, STL and glTF are told apart by ending or first bytes.
    let model = load(path, Origin::Unchanged)?;

    // 2. Choose an index, and build it in memory of exactly its size.
    let (scene, options) = (model.scene(), Options::DEFAULT);
    let rays_to_come = u64::from(SIDE * SIDE);
    let selection = select_index(&scene.expecting(rays_to_come), &options)?;
    println!("{}: {} triangles; {selection}", model.name, model.triangles.len());
    let owned = OwnedIndex::build(selection.kind(), &scene, &options)?;
    let index = owned.index();

    // 3. Ask about all rays at once: one above the middle of each cell of the ground plan.
    let bounds = model.bounds();
    let cell = (bounds.hi - bounds.lo) / SIDE as f32;
    let rays = (0..SIDE * SIDE).map(|number| {
        let (x, y) = ((number % SIDE) as f32 + 0.5, (number / SIDE) as f32 + 0.5);
        let above =
            Vec3::new(bounds.lo.x + x * cell.x, bounds.lo.y + y * cell.y, bounds.hi.z + 1.0);
        Ray::new(above, Vec3::NEG_Z)
    });
    let rays: Vec<Ray> = rays.collect::<Result<_, _>>()?;
    let mut hits = vec![Hit::NONE; rays.len()];
    index.closest_hits(&rays, &mut hits);

    // 4. From triangles to the names of their objects.
    let mut hits_on = BTreeMap::new();
    for hit in hits.iter().filter(|hit| !hit.is_none()) {
        let object = model.objects[hit.triangle.0 as usize] as usize;
        *hits_on.entry(model.object_names[object].clone()).or_insert(0) += 1;
    }
    for (object, hits) in &hits_on {
        println!("{object}: {hits} of {} rays", rays.len());
    }
    Ok(hits_on)
}
