//! A built-in scene as several scene files (STL): something large for `arboleda pack DIR --memory 1.5G -o city.arb`.
//!
//! `cargo run --release -p arboleda-host --example scene_to_files -- city-10000000 DIR 16`

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use arboleda_host::scene::builtin::require;

/// Writes the scene that is named on the command line; a small city without a name.
pub fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(name), Some(folder)) = (arguments.next(), arguments.next()) else {
        let folder = std::env::temp_dir().join(format!("arboleda-files-{}", std::process::id()));
        run("city-1000", &folder, 3)?;
        return Ok(fs::remove_dir_all(folder)?);
    };
    let count = arguments.next().map_or(Ok(16), |count| count.parse())?;
    run(&name, Path::new(&folder), count)
}

/// Writes the triangles of a built-in scene to `count` files of a folder, in their order. All have their exact
/// coordinates, so the files together are the same scene.
pub fn run(name: &str, folder: &Path, count: usize) -> Result<(), Box<dyn Error>> {
    let model = require(name)?;
    fs::create_dir_all(folder)?;
    let share = model.triangles.len().div_ceil(count.max(1)).max(1);
    for (number, triangles) in model.triangles.chunks(share).enumerate() {
        let mut file = BufWriter::new(File::create(folder.join(format!("part-{number:04}.stl")))?);
        // A heading of 80 bytes, the number of triangles; for each a normal, three corners, two bytes of attributes.
        file.write_all(&[b' '; 80])?;
        file.write_all(&u32::try_from(triangles.len())?.to_le_bytes())?;
        for triangle in triangles {
            file.write_all(&[0; 12])?;
            for number in [triangle.a, triangle.b, triangle.c].iter().flat_map(|at| at.to_array()) {
                file.write_all(&number.to_le_bytes())?;
            }
            file.write_all(&[0; 2])?;
        }
        file.flush()?;
    }
    println!("{}: {} triangles in {}", name, model.triangles.len(), folder.display());
    Ok(())
}
