//! Arguments that several commands share.

use std::path::PathBuf;

use anyhow::Context;
use arboleda::{BuildError, BvhBuild, IndexKind, Level, Options, Resolution, Scene};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::output::bytes;
use super::values::{MOST_REPETITIONS, MOST_REPLAYED_PHOTONS, number, whole};
use crate::bench::plan::{Effort, Share};
use crate::bench::progress::during;
use crate::owned_index::kind_by_name;
use crate::scene::{self, Model, Origin, UpAxis};
use crate::select_index;

/// Which scene.
#[derive(Args, Clone, Debug)]
pub struct SceneArguments {
    /// A scene file: OBJ, PLY, STL or glTF (.gltf, .glb)
    #[arg(value_name = "SCENE", conflicts_with = "scene")]
    file: Option<PathBuf>,
    /// A built-in scene instead: fig2, fig3, fig4a to fig4e, city, mixed, sphere, mesh; or mesh-N, city-N
    /// with about N triangles
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// The axis that points up, for pictures and the default light
    #[arg(long, value_name = "auto|y|z", default_value_t = UpAxis::Auto)]
    pub up: UpAxis,
    #[command(flatten)]
    origin: OriginArgument,
}

/// Option for the origin of the coordinates of scene files.
#[derive(Args, Clone, Copy, Debug)]
pub struct OriginArgument {
    /// Subtract a point from the coordinates of scene files, in 64 bits, before they are rounded to 32;
    /// `auto` takes the middle of the scene. Rays and lights are given in the file's coordinates all the
    /// same. The point is printed
    #[arg(long, value_name = "X,Y,Z|auto", allow_hyphen_values = true)]
    origin: Option<Origin>,
}

impl OriginArgument {
    /// The origin asked for, or none.
    pub fn get(self) -> Origin {
        self.origin.unwrap_or_default()
    }
}

impl SceneArguments {
    /// Loads the file and logs warnings about it, or makes the built-in scene.
    ///
    /// # Errors
    /// If neither or an unknown scene is named, or the file cannot be used.
    pub fn load(&self) -> anyhow::Result<Model> {
        during("loading", || self.load_unwatched())
    }

    fn load_unwatched(&self) -> anyhow::Result<Model> {
        match (&self.file, &self.scene) {
            (Some(path), _) => Ok(scene::load(path, self.origin.get())?),
            (None, Some(_)) if self.origin.get() != Origin::Unchanged => {
                anyhow::bail!("--origin is for scene files; built-in scenes lose no digits")
            }
            (None, Some(name)) => Ok(scene::builtin::require(name)?),
            (None, None) => {
                let names = scene::builtin::names().collect::<Vec<_>>().join(", ");
                anyhow::bail!("name a scene: a file, or --scene with one of {names}")
            }
        }
    }
}

/// How indices are built.
#[derive(Args, Clone, Debug)]
pub struct BuildArguments {
    /// A cell with at most this many triangles is not divided
    #[arg(long, value_name = "N", default_value_t = Options::default().leaf_capacity,
        value_parser = whole::<u32>(1..=u32::MAX.into()))]
    leaf_capacity: u32,
    /// The highest level of an octree, 0 to 20 [default: found by estimated cost]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=20))]
    level: Option<u32>,
    /// Primitives whose boxes are at most this multiple of the class's median diagonal apart are in
    /// one cluster
    #[arg(long, value_name = "X", default_value_t = Options::default().proximity,
        value_parser = number(0.0..=1e6))]
    proximity: f32,
    /// The most size classes, 1 to 4
    #[arg(long, value_name = "N", default_value_t = Options::default().size_classes,
        value_parser = whole::<u32>(1..=4))]
    size_classes: u32,
    /// The cells of uniform grids, for each triangle, 0.001 to 1024 [default: found by estimated cost]
    #[arg(long, value_name = "X", value_parser = number(0.001..=1024.0))]
    cells_per_triangle: Option<f32>,
    /// Build bounding volume hierarchies by inserting triangles one by one (Goldsmith and Salmon)
    #[arg(long)]
    bvh_insertion: bool,
    /// Find clusters among whole objects of the file rather than among triangles
    #[arg(long)]
    objects: bool,
}

impl BuildArguments {
    /// The options for the core, which checks them.
    pub fn options(&self) -> Options {
        Options {
            leaf_capacity: self.leaf_capacity,
            level: self.level.map_or(Level::Automatic, Level::AtMost),
            proximity: self.proximity,
            size_classes: self.size_classes,
            resolution: self
                .cells_per_triangle
                .map_or(Resolution::Automatic, Resolution::CellsPerTriangle),
            bvh_build: if self.bvh_insertion { BvhBuild::Insertion } else { BvhBuild::Binned },
            ..Options::default()
        }
    }

    /// The model as the clusters are to be found in it.
    pub fn scene<'m>(&self, model: &'m Model) -> Scene<'m> {
        if self.objects { model.scene_of_objects() } else { model.scene() }
    }
}

/// How much is measured, where several indices are.
#[derive(Args, Clone, Debug)]
pub struct MeasureArguments {
    /// Photons to each repetition
    #[arg(long, value_name = "N", default_value_t = 30_000, value_parser = whole::<u64>(1..=MOST_REPLAYED_PHOTONS))]
    photons: u64,
    #[command(flatten)]
    repeat: RepeatArguments,
}

/// How often the same is measured, and on which photons.
#[derive(Args, Clone, Debug)]
pub struct RepeatArguments {
    /// How often the rays are replayed
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

    /// Writes the command line that measures the same again.
    pub fn command(&self, name: &str) -> String {
        let RepeatArguments { repetitions, seed } = self.repeat;
        format!(
            "arboleda {name} --photons {} --repetitions {repetitions} --seed {seed}",
            self.photons
        )
    }
}

/// Which index, or all.
#[derive(Args, Clone, Debug)]
pub struct IndexChoice {
    /// The index. One whose name ends in -hierarchy is built in each cluster
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = index_names())]
    index: String,
}

impl IndexChoice {
    /// The kinds named. The automatic choice prints why on stderr.
    ///
    /// # Errors
    /// If the scene cannot be indexed.
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

    /// Whether what is chosen or built depends on the rays of the scene.
    pub fn uses_rays(&self) -> bool {
        self.is_all()
            || self.index == "auto"
            || kind_by_name(&self.index).is_some_and(IndexKind::uses_rays)
    }

    /// Whether `all` was asked for.
    pub fn is_all(&self) -> bool {
        self.index == "all"
    }
}

/// Accepts the names of all indices, `auto` and `all`; help lists them.
fn index_names() -> PossibleValuesParser {
    let special = [
        PossibleValue::new("auto")
            .help("tries the usual ones and takes the cheapest by estimated cost"),
        PossibleValue::new("all").help("each in turn"),
    ];
    let kinds =
        IndexKind::ALL.iter().map(|&kind| PossibleValue::new(kind.name()).help(what_it_is(kind)));
    PossibleValuesParser::new(special.into_iter().chain(kinds))
}

/// Says in a few words how an index divides the scene.
fn what_it_is(kind: IndexKind) -> &'static str {
    match kind {
        IndexKind::Linear => {
            "every triangle, one after the other: slow, and what the others are checked against"
        }
        IndexKind::Octree => "cubes, divided in the middle",
        IndexKind::OctreeHierarchy => {
            "the paper's: an octree in each cluster, joined by a binary tree"
        }
        IndexKind::OctreeR => "an octree whose planes lie where they cost least",
        IndexKind::UniformGrid => "equal cells",
        IndexKind::GridHierarchy => "equal cells in each cluster (Cazals, Drettakis, Puech)",
        IndexKind::KdTree => "planes by surface-area cost",
        IndexKind::BspTree => "planes in the middle, the axes in turn",
        IndexKind::Bvh => "a bounding volume hierarchy of two children a node",
        IndexKind::WideBvh => {
            "boxes by surface-area cost, eight children a node: usually the fastest"
        }
        IndexKind::CompactBvh => "the same in half the bytes, a little slower",
        IndexKind::LeanBvh => "the same in the fewest bytes, for a mesh that is kept anyway",
        other if other.is_clustered() => "the same in each cluster",
        _ => "one over everything",
    }
}

/// Words the error of a build for the command line, which has options but no arenas.
pub fn unbuilt(error: &BuildError) -> anyhow::Error {
    match *error {
        BuildError::ArenaFull { needed, .. } | BuildError::ScratchFull { needed, .. } => {
            anyhow::anyhow!(
                "the index would take {}, more than is given to this scene: lower --level, raise --leaf-capacity, \
                 or name another with --index",
                bytes(needed)
            )
        }
        BuildError::TooLarge => anyhow::anyhow!(
            "the index outgrows 32-bit links: lower --level, raise --leaf-capacity, or name another with --index"
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
