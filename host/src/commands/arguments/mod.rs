//! Arguments that several commands have in common.

pub mod estimator;
pub mod light;
pub mod packed;
pub mod part;
pub mod photons;
pub mod values;

use std::path::{Path, PathBuf};

use anyhow::Context;
use arboleda::{BuildError, BvhBuild, IndexKind, Level, Options, Resolution, Scene};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::output::bytes;
use crate::benchmark::harness::plan::{Effort, Share};
use crate::benchmark::harness::progress::during;
use crate::index::kind_by_name;
use crate::scene::{self, Model, Origin, SceneFiles, UpAxis};
use crate::{Threads, TimedIndex, select_index};
use values::{MOST_REPETITIONS, MOST_REPLAYED_PHOTONS, number, whole};

/// Arguments that name a scene.
#[derive(Args, Clone, Debug)]
pub struct SceneArguments {
    /// Scene file: OBJ, PLY, STL or glTF (.gltf, .glb); for `cast` and `inspect` also an index, .arb. Several files, or
    /// a folder of them (sorted by path, with its folders, without links to folders), are one scene, as if they stood
    /// one after another
    #[arg(value_name = "SCENE", conflicts_with = "scene")]
    files: Vec<PathBuf>,
    /// Built-in scene, in place of a file: fig2, fig3, fig4a to fig4e, city, mixed, sphere, mesh; or mesh-N or city-N,
    /// with about N triangles
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Axis that points up, for pictures and the default light
    #[arg(long, value_name = "auto|y|z", default_value_t = UpAxis::Auto)]
    pub up: UpAxis,
    #[command(flatten)]
    origin: OriginArgument,
}

/// Option for the origin of the coordinates of scene files.
#[derive(Args, Clone, Copy, Debug)]
pub struct OriginArgument {
    /// Subtract a point from the coordinates of the scene file, in 64 bits, before they are rounded to 32 bits. `auto`
    /// subtracts the middle of the scene. Rays and lights stay in the coordinates of the file. The point is printed
    #[arg(long, value_name = "X,Y,Z|auto", allow_hyphen_values = true)]
    origin: Option<Origin>,
}

impl OriginArgument {
    /// Returns the origin of the command line, by default [`Origin::Unchanged`].
    pub fn get(self) -> Origin {
        self.origin.unwrap_or_default()
    }
}

impl SceneArguments {
    /// The file of an index that is named in place of a scene, as `pack` writes them: its name ends in .arb.
    ///
    /// # Errors
    /// If options are given that say how to load a scene or how to build an index.
    pub fn index_file(&self, build: &BuildArguments) -> anyhow::Result<Option<&Path>> {
        let ends = |path: &&Path| path.extension().is_some_and(|it| it.eq_ignore_ascii_case("arb"));
        let path = self.files.iter().map(PathBuf::as_path).find(ends);
        if let Some(path) = path {
            anyhow::ensure!(
                self.files.len() == 1,
                "{} is an index, and not a file of a scene: name it alone",
                path.display()
            );
            anyhow::ensure!(
                self.origin.get() == Origin::Unchanged && build.is_default(),
                "{} is an index already: --origin and options of builds are for `pack`",
                path.display()
            );
        }
        Ok(path)
    }

    /// Lists the files that are read; none if the scene is built in.
    ///
    /// # Errors
    /// If a folder cannot be read, or has no scene files.
    pub fn inputs(&self) -> anyhow::Result<Vec<PathBuf>> {
        Ok(SceneFiles::paths_of(&self.files)?)
    }

    /// Names other files, or folders, of the scene.
    pub fn move_to(&mut self, files: &[PathBuf]) {
        (self.files, self.scene) = (files.to_vec(), None);
    }

    /// Loads the file and logs its warnings, or makes the built-in scene.
    ///
    /// # Errors
    /// If no scene or an unknown scene is named, or the file cannot be read.
    pub fn load(&self) -> anyhow::Result<Model> {
        during("loading", || self.load_unwatched())
    }

    /// Lists the files of the scene; none if it is built in. With the origin to subtract.
    ///
    /// # Errors
    /// If a folder cannot be read, or has no scene files.
    pub fn scene_files(&self) -> anyhow::Result<Option<(SceneFiles, Origin)>> {
        if self.files.is_empty() {
            return Ok(None);
        }
        Ok(Some((SceneFiles::list(&self.files)?, self.origin.get())))
    }

    fn load_unwatched(&self) -> anyhow::Result<Model> {
        if let Some((files, origin)) = self.scene_files()? {
            return Ok(files.load(origin)?);
        }
        match &self.scene {
            Some(_) if self.origin.get() != Origin::Unchanged => {
                anyhow::bail!("--origin is for scene files; built-in scenes lose no digits")
            }
            Some(name) => Ok(scene::builtin::require(name)?),
            None => {
                let names = scene::builtin::names().collect::<Vec<_>>().join(", ");
                anyhow::bail!("name a scene: a file, or --scene with one of {names}")
            }
        }
    }
}

/// Arguments of index builds.
#[derive(Args, Clone, Debug)]
pub struct BuildArguments {
    /// Most triangles of a cell that is not divided further
    #[arg(long, value_name = "N", default_value_t = Options::default().leaf_capacity,
        value_parser = whole::<u32>(1..=u32::MAX.into()))]
    leaf_capacity: u32,
    /// Deepest level of an octree, 0 to 20 [default: the level of the least estimated cost]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=20))]
    level: Option<u32>,
    /// Least side of an octree's cell that is halved, as a share of its longest side; 0 halves all, as in the paper
    #[arg(long, value_name = "X", default_value_t = Options::default().least_side,
        value_parser = number(0.0..=1.0))]
    least_side: f32,
    /// Largest gap inside a cluster: primitives whose bounding boxes are at most X times the median diagonal of their
    /// size class apart are in one cluster
    #[arg(long, value_name = "X", default_value_t = Options::default().proximity,
        value_parser = number(0.0..=1e6))]
    proximity: f32,
    /// Most size classes, 1 to 4
    #[arg(long, value_name = "N", default_value_t = Options::default().size_classes,
        value_parser = whole::<u32>(1..=4))]
    size_classes: u32,
    /// Cells of a uniform grid for each triangle, 0.001 to 1024 [default: the number of the least estimated cost]
    #[arg(long, value_name = "X", value_parser = number(0.001..=1024.0))]
    cells_per_triangle: Option<f32>,
    /// Build bounding volume hierarchies by inserting triangles one by one (Goldsmith and Salmon 1987)
    #[arg(long)]
    bvh_insertion: bool,
    /// Find clusters among whole objects of the file instead of single triangles
    #[arg(long)]
    objects: bool,
}

impl BuildArguments {
    /// Converts to the core's options; the core checks their values.
    pub fn options(&self) -> Options {
        Options {
            leaf_capacity: self.leaf_capacity,
            level: self.level.map_or(Level::Automatic, Level::AtMost),
            least_side: self.least_side,
            proximity: self.proximity,
            size_classes: self.size_classes,
            resolution: self
                .cells_per_triangle
                .map_or(Resolution::Automatic, Resolution::CellsPerTriangle),
            bvh_build: if self.bvh_insertion { BvhBuild::Insertion } else { BvhBuild::Binned },
            ..Options::default()
        }
    }

    /// Tells whether no option was given another value than its default.
    pub fn is_default(&self) -> bool {
        !self.objects && self.options() == Options::default()
    }

    /// Tells whether clusters are found among whole objects.
    pub fn by_objects(&self) -> bool {
        self.objects
    }

    /// Makes the scene of a model whose primitives are triangles, or objects with `--objects`.
    pub fn scene<'m>(&self, model: &'m Model) -> Scene<'m> {
        if self.objects { model.scene_of_objects() } else { model.scene() }
    }
}

/// Arguments of measurements.
#[derive(Args, Clone, Debug)]
pub struct MeasureArguments {
    /// Number of photons in each repetition
    #[arg(long, value_name = "N", default_value_t = 30_000, value_parser = whole::<u64>(1..=MOST_REPLAYED_PHOTONS))]
    photons: u64,
    #[command(flatten)]
    repeat: RepeatArguments,
}

/// Repetitions of a measurement, and its photons.
#[derive(Args, Clone, Debug)]
pub struct RepeatArguments {
    /// Number of times that the rays are replayed
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = whole::<usize>(1..=MOST_REPETITIONS))]
    pub repetitions: usize,
    /// Another seed gives other photons
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

impl MeasureArguments {
    /// Returns the effort asked for, if a repetition may take about `seconds`.
    pub fn effort(&self, seconds: f64, share: Share) -> Effort {
        let RepeatArguments { repetitions, seed } = self.repeat;
        Effort { photons: self.photons, repetitions, seconds, share, seed }
    }

    /// Writes the command line that repeats the measurement.
    pub fn command(&self, name: &str) -> String {
        let RepeatArguments { repetitions, seed } = self.repeat;
        format!(
            "arboleda {name} --photons {} --repetitions {repetitions} --seed {seed}",
            self.photons
        )
    }
}

/// Argument that names an index, or all of them.
#[derive(Args, Clone, Debug)]
pub struct IndexChoice {
    /// Index through which rays are cast. An index whose name ends in -hierarchy is built in each cluster
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = index_names())]
    index: String,
}

impl IndexChoice {
    /// Returns the kinds that the argument names. The automatic selection logs its reasons.
    ///
    /// # Errors
    /// If no index of the scene can be built.
    pub fn kinds(&self, scene: &Scene<'_>, options: &Options) -> anyhow::Result<Vec<IndexKind>> {
        if self.is_all() {
            return Ok(IndexKind::ALL.to_vec());
        }
        if self.index == "auto" {
            let selection = during("choosing an index", || select_index(scene, options));
            let selection = selection.map_err(|error| unbuilt(&error))?;
            log::info!("{selection}");
            return Ok(vec![selection.kind()]);
        }
        let kind = kind_by_name(&self.index).context("the parser knows all names")?;
        Ok(vec![kind])
    }

    /// Returns the one kind that the argument names, for work that is done once. The automatic selection logs its
    /// reasons.
    ///
    /// # Errors
    /// If the argument is `all`, or no index of the scene can be built.
    pub fn kind(&self, scene: &Scene<'_>, options: &Options) -> anyhow::Result<IndexKind> {
        anyhow::ensure!(!self.is_all(), "--index all is for comparisons: name one index, or auto");
        self.kinds(scene, options)?.first().copied().context("an index was named")
    }

    /// Returns the kind that the argument names; `None` for `auto` and `all`.
    pub fn named(&self) -> Option<IndexKind> {
        kind_by_name(&self.index)
    }

    /// Tells whether the selection or the build depends on the sample of rays in the scene.
    pub fn uses_rays(&self) -> bool {
        self.is_all()
            || self.index == "auto"
            || kind_by_name(&self.index).is_some_and(IndexKind::uses_rays)
    }

    /// Tells whether the argument is `all`.
    pub fn is_all(&self) -> bool {
        self.index == "all"
    }
}

/// Accepts the names of all indices, `auto` and `all`; help lists them.
fn index_names() -> PossibleValuesParser {
    let special = [
        PossibleValue::new("auto")
            .help("the usual index with the least estimated cost on this scene"),
        PossibleValue::new("all").help("every index, one after the other"),
    ];
    let kinds =
        IndexKind::ALL.iter().map(|&kind| PossibleValue::new(kind.name()).help(description(kind)));
    PossibleValuesParser::new(special.into_iter().chain(kinds))
}

/// Describes an index in a few words, a hierarchy by the index in its clusters.
fn description(kind: IndexKind) -> String {
    let inside = kind.name().strip_suffix("-hierarchy");
    match (kind, inside) {
        (IndexKind::OctreeHierarchy | IndexKind::GridHierarchy, _) | (_, None) => {
            division(kind).to_owned()
        }
        (_, Some(inside)) => format!("{inside} in each cluster"),
    }
}

/// Describes in a few words how an index divides the scene.
fn division(kind: IndexKind) -> &'static str {
    match kind {
        IndexKind::Linear => "tests every triangle: slow, the reference for the others",
        IndexKind::Octree => "cells divided in the middle into eight",
        IndexKind::OctreeHierarchy => {
            "the paper's index: an octree in each cluster, joined by a binary tree"
        }
        IndexKind::OctreeR => "an octree with split planes of the least estimated cost",
        IndexKind::UniformGrid => "cells of equal size",
        IndexKind::GridHierarchy => "a uniform grid in each cluster (Cazals, Drettakis, Puech)",
        IndexKind::KdTree => "split planes by surface-area cost (SAH)",
        IndexKind::BspTree => "split planes in the middle, the axes in turn",
        IndexKind::Bvh => "a bounding volume hierarchy with two children a node",
        IndexKind::WideBvh => {
            "a bounding volume hierarchy with eight children a node (SAH): usually the fastest"
        }
        IndexKind::CompactBvh => "wide-bvh in half the bytes, a little slower",
        IndexKind::LeanBvh => "wide-bvh in the fewest bytes, for a mesh that the caller keeps",
        _ => "an index over all triangles",
    }
}

/// Builds an index, and shows how long that takes.
///
/// # Errors
/// If the index cannot be built; the error names it.
pub fn build_index(
    kind: IndexKind,
    scene: &Scene<'_>,
    options: &Options,
    threads: &Threads,
) -> anyhow::Result<TimedIndex> {
    let build = || TimedIndex::build_with(kind, scene, options, threads);
    during(&format!("building {}", kind.name()), build)
        .map_err(|error| unbuilt(&error))
        .with_context(|| format!("cannot build {}", kind.name()))
}

/// Describes a build error to the user of the command line, who knows options but no arenas.
pub fn unbuilt(error: &BuildError) -> anyhow::Error {
    match *error {
        BuildError::ArenaFull { needed, .. } | BuildError::ScratchFull { needed, .. } => {
            anyhow::anyhow!(
                "the index would take {}, more than the program allots to this scene: lower --level, raise \
                 --leaf-capacity, or name another index with --index",
                bytes(needed)
            )
        }
        BuildError::TooLarge => anyhow::anyhow!(
            "the index outgrows 32-bit links: lower --level, raise --leaf-capacity, or name another index with --index"
        ),
        ref other => anyhow::anyhow!("{other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_builds_name_options_and_no_arenas() {
        for error in [
            BuildError::ArenaFull { needed: 3 << 30, given: 1 << 20 },
            BuildError::ScratchFull { needed: 3 << 30, given: 1 << 20 },
            BuildError::TooLarge,
        ] {
            let text = unbuilt(&error).to_string();
            assert!(text.contains("--level") && text.contains("--index"), "{text}");
            assert!(!text.contains("arena") && !text.contains("scratch"), "{text}");
        }
    }
}
