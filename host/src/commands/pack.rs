//! `arboleda pack`: the index of a scene to a file, and what such a file holds.

use std::path::{Path, PathBuf};

use arboleda::AnyIndex;
use arboleda::Statistics;
use clap::Args;

use super::arguments::values::file_ending_in;
use super::arguments::{BuildArguments, IndexChoice, SceneArguments, build_index};
use super::output::{bytes, count, say};
use crate::bench::progress::during;
use crate::files::output::{check_writable, write_file};
use crate::{IndexFile, PackedScene, Threads, scene_path};

/// Write the index of a scene to a file, and what else photons need to a second one; the scene is not needed any more
///
/// X.arb has the bytes of the index as they lie in memory, with its triangles: `cast` and `inspect` read it, a program
/// opens it with `AnyIndex::from_bytes`, firmware includes it with `include_index!`. It can be opened on any
/// little-endian machine, without being built again.
///
/// X.arb.scene has the reflectances, the lights, the names of objects, the origin, and the triangles if the index has
/// them in another form: 8 to 56 bytes a triangle. `shoot`, `irradiance`, `render` and `cast` take both with
/// --index-file X.arb, so that many processes on a machine share them.
#[derive(Args)]
pub struct Pack {
    #[command(flatten)]
    scene: SceneArguments,
    /// Write the index to a file
    #[arg(long, short, value_name = "X.arb", value_parser = file_ending_in(&["arb"]))]
    out: PathBuf,
    /// Write X.arb only, as for firmware
    #[arg(long)]
    index_only: bool,
    #[command(flatten)]
    index: IndexChoice,
    #[command(flatten)]
    build: BuildArguments,
}

impl Pack {
    /// Runs the command.
    ///
    /// # Errors
    /// If the scene cannot be loaded, the index cannot be built, or the file cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        check_writable(&self.out)?;
        if !self.index_only {
            check_writable(&scene_path(&self.out))?;
        }
        let model = self.scene.load()?;
        let (scene, options) = (self.build.scene(&model), self.build.options());
        let kind = self.index.kind(&scene, &options)?;
        let owned = build_index(kind, &scene, &options, &Threads::default())?;
        let index = owned.index();
        if self.index_only {
            write_file(&self.out, |file| file.write_all(index.as_bytes()))?;
        } else {
            PackedScene::write(&self.out, &model, &index)?;
            log::info!("its scene: {}", scene_path(&self.out).display());
        }
        describe_index(&self.out, &index, &index.check()?);
        if self.index_only && model.origin != [0.0; 3] {
            let [x, y, z] = model.origin;
            log::warn!(
                "the file does not hold the origin {x},{y},{z}: subtract it from the origins of rays"
            );
        }
        Ok(())
    }
}

/// Prints what the file of an index holds.
///
/// # Errors
/// If the file cannot be read, or is not an index.
pub fn describe_file(path: &Path) -> anyhow::Result<()> {
    let file = IndexFile::open(path)?;
    let (index, parts) = during("reading the index", || file.index())?;
    describe_index(path, &index, &parts);
    Ok(())
}

fn describe_index(path: &Path, index: &AnyIndex<'_>, parts: &Statistics) {
    let sections = index.sections();
    say!(
        "{}: {}, {} triangles in {} cluster{}, {}",
        path.display(),
        index.kind().name(),
        count(sections.triangle_count().into()),
        count(sections.cluster_count().into()),
        if sections.cluster_count() == 1 { "" } else { "s" },
        bytes(index.as_bytes().len())
    );
    say!(
        "{} inner nodes, {} leaves, {} references, level {}",
        count(parts.inner_nodes),
        count(parts.leaves),
        count(parts.references),
        parts.deepest_level
    );
    // Validation tells whether an index does harm, not whether it was changed on its way.
    say!("BLAKE3 {}", blake3::hash(index.as_bytes()));
}
