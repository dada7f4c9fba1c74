//! Compares `arboleda` with Embree and the best Rust crates on a few scenes, and writes `compare.csv`.
//!
//! ```text
//! RUSTFLAGS="-C target-cpu=native" cargo run --release --example peers --features tinybvh -- OUT [SCENE | FILE.obj]...
//! ```
//! Embree 4 is looked for where the environment variable `EMBREE4_LIBRARY` says.

use std::error::Error;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use arboleda_host::peers::{ComparisonOptions, compare, table, write_csv};
use arboleda_host::scene::{Model, SceneError, UpAxis, builtin, obj};

const SCENES: [&str; 5] = ["fig3", "fig4b", "fig4e", "city", "sphere"];

/// The one closed scene, around the origin.
const CLOSED: &str = "sphere";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = PathBuf::from(arguments.next().ok_or("usage: peers OUT [SCENE | FILE.obj]...")?);
    let mut scenes: Vec<String> = arguments.collect();
    if scenes.is_empty() {
        scenes = SCENES.map(String::from).to_vec();
    }

    let mut rows = Vec::new();
    for name in &scenes {
        let model = load(name)?;
        let leak_ray_count = if name == CLOSED { 1_000_000 } else { 0 };
        let comparison =
            compare(&model, &ComparisonOptions { leak_ray_count, ..Default::default() })?;
        println!("{}, {} triangles\n{}\n", model.name, model.triangles.len(), table(&comparison));
        for (contender, reason) in &comparison.absent {
            println!("without {contender}: {reason}");
        }
        rows.extend(comparison.rows);
    }
    fs::create_dir_all(&out)?;
    write_csv(File::create(out.join("compare.csv"))?, &rows)?;
    Ok(())
}

fn load(name: &str) -> Result<Model, SceneError> {
    let path = Path::new(name);
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")) {
        return Ok(obj::load(path)?.with_default_light(UpAxis::default()));
    }
    builtin::require(name)
}
