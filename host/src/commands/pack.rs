//! `arboleda pack`: the index of a scene to a file, and what such a file holds.

use std::path::{Path, PathBuf};

use anyhow::Context;
use arboleda::{AnyIndex, BuildError, IndexKind, Statistics};
use clap::Args;

use super::arguments::values::{file_ending_in, whole};
use super::arguments::{BuildArguments, IndexChoice, SceneArguments, build_index, unbuilt};
use super::output::{bytes, count, say};
use crate::benchmark::harness::progress::during;
use crate::files::output::{check_writable, write_file};
use crate::index::bounded::BoundedPack;
use crate::index::packed::digest_of;
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
    /// Keep the resident memory of the program below this many bytes, as in 1500M or 1.5G (M is a million). The scene's
    /// files are read one after the other, and triangles, tables and index lie in temporary files beside the index,
    /// about 100 bytes a triangle. Both files have the same bytes as without it. The least is 600M and what the largest
    /// file takes, 5 to 24 times its length. On systems other than Linux, the system decides how much of the files stays
    /// in memory. With it, `--index auto` is octree-hierarchy
    #[arg(long, value_name = "BYTES", value_parser = whole::<u64>(1..=u64::MAX))]
    memory: Option<u64>,
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
        if let Some(memory) = self.memory {
            return self.run_within(memory);
        }
        let model = self.scene.load()?;
        let (scene, options) = (self.build.scene(&model), self.build.options());
        let kind = self.index.kind(&scene, &options)?;
        let owned = build_index(kind, &scene, &options, &Threads::default())?;
        let index = owned.index();
        let digest = if self.index_only {
            write_file(&self.out, |file| file.write_all(index.as_bytes()))?;
            digest_of(&index)
        } else {
            PackedScene::write(&self.out, &model, &index)?
        };
        say!("{}", describe_index(&self.out, &index, &index.check()?, &digest));
        self.tell_of_scene(model.origin);
        Ok(())
    }

    /// Packs the files of a scene within `memory` bytes.
    fn run_within(&self, memory: u64) -> anyhow::Result<()> {
        let files = self.scene.scene_files()?;
        let (files, origin) =
            files.context("--memory is for scene files: a built-in scene is made in memory")?;
        anyhow::ensure!(
            !self.index.is_all(),
            "--index all is for comparisons: name one index, or auto"
        );
        let kind = self.index.named().unwrap_or_else(|| {
            log::info!("octree-hierarchy, which is built cluster by cluster; --index names others");
            IndexKind::OctreeHierarchy
        });
        let scene = scene_path(&self.out);
        let pack = BoundedPack {
            files: &files,
            origin,
            kind,
            options: self.build.options(),
            by_objects: self.build.by_objects(),
            memory,
            scene: (!self.index_only).then_some(&scene),
        };
        // It is shown when the files are there.
        let mut described = String::new();
        let packed = pack.run(&self.out, &mut |index, parts, digest| {
            described = describe_index(&self.out, index, parts, digest);
        });
        let packed = packed.map_err(|error| match error.downcast_ref::<BuildError>() {
            Some(build) => unbuilt(build).context(format!("cannot build {}", kind.name())),
            None => error,
        })?;
        say!("{described}");
        self.tell_of_scene(packed.origin);
        Ok(())
    }

    /// Names the file of the scene, or warns of what is lost without it.
    fn tell_of_scene(&self, origin: [f64; 3]) {
        if !self.index_only {
            log::info!("its scene: {}", scene_path(&self.out).display());
        } else if origin != [0.0; 3] {
            let [x, y, z] = origin;
            log::warn!(
                "the file does not hold the origin {x},{y},{z}: subtract it from the origins of rays"
            );
        }
    }
}

/// Prints what the file of an index holds.
///
/// # Errors
/// If the file cannot be read, or is not an index.
pub fn describe_file(path: &Path) -> anyhow::Result<()> {
    let file = IndexFile::open(path)?;
    let (index, parts) = during("reading the index", || file.index())?;
    say!("{}", describe_index(path, &index, &parts, &digest_of(&index)));
    Ok(())
}

/// Describes an index in lines. Validation tells whether an index does harm, not whether it was changed on its way: the
/// digest does.
fn describe_index(
    path: &Path,
    index: &AnyIndex<'_>,
    parts: &Statistics,
    digest: &blake3::Hash,
) -> String {
    let sections = index.sections();
    format!(
        "{}: {}, {} triangles in {} cluster{}, {}
{} inner nodes, {} leaves, {} references, level {}
BLAKE3 {digest}",
        path.display(),
        index.kind().name(),
        count(sections.triangle_count().into()),
        count(sections.cluster_count().into()),
        if sections.cluster_count() == 1 { "" } else { "s" },
        bytes(index.as_bytes().len()),
        count(parts.inner_nodes),
        count(parts.leaves),
        count(parts.references),
        parts.deepest_level
    )
}
