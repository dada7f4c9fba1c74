//! Arguments that several commands share.

use std::path::PathBuf;

use anyhow::Context;
use arboleda::{BvhBuild, IndexKind, Level, Options, Resolution, Scene};
use clap::Args;

use crate::owned_index::{kind_by_name, kind_names};
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

/// Where the coordinates of scene files begin.
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
    /// Loads the file, and prints what it says that is not in the model; or makes the built-in scene.
    ///
    /// # Errors
    /// If neither or an unknown scene is named, or the file cannot be used.
    pub fn load(&self) -> anyhow::Result<Model> {
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
    #[arg(long, value_name = "N", default_value_t = Options::default().leaf_capacity)]
    leaf_capacity: u32,
    /// The highest level of an octree, 0 to 20 [default: found by estimated cost]
    #[arg(long, value_name = "N")]
    level: Option<u32>,
    /// Primitives whose boxes are at most this multiple of the class's median diagonal apart are in
    /// one cluster
    #[arg(long, value_name = "X", default_value_t = Options::default().proximity)]
    proximity: f32,
    /// The most size classes, 1 to 4
    #[arg(long, value_name = "N", default_value_t = Options::default().size_classes)]
    size_classes: u32,
    /// The cells of uniform grids, for each triangle [default: found by estimated cost]
    #[arg(long, value_name = "X")]
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
    #[arg(long, value_name = "N", default_value_t = 30_000)]
    pub photons: u64,
    /// How often the rays are replayed
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repetitions: usize,
    /// Another seed gives other photons
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

impl MeasureArguments {
    /// The command line that measures the same again.
    pub fn command(&self, name: &str) -> String {
        format!(
            "arboleda {name} --photons {} --repetitions {} --seed {}",
            self.photons, self.repetitions, self.seed
        )
    }
}

/// Which index, or all.
#[derive(Args, Clone, Debug)]
pub struct IndexChoice {
    /// The index: linear, octree, octree-hierarchy, ... or all; `auto` tries each and chooses by estimated cost
    #[arg(long, value_name = "NAME", default_value = "auto")]
    index: String,
}

impl IndexChoice {
    /// The kinds named. The automatic choice prints why on stderr.
    ///
    /// # Errors
    /// For an unknown name; lists the known ones. If the scene cannot be indexed.
    pub fn kinds(&self, scene: &Scene<'_>, options: &Options) -> anyhow::Result<Vec<IndexKind>> {
        if self.is_all() {
            return Ok(IndexKind::ALL.to_vec());
        }
        if self.index == "auto" {
            let selection = select_index(scene, options)?;
            eprintln!("{selection}");
            return Ok(vec![selection.kind()]);
        }
        let kind = kind_by_name(&self.index).with_context(|| {
            let names = kind_names().collect::<Vec<_>>().join(", ");
            format!("there is no index {:?}; there are {names}, all and auto", self.index)
        })?;
        Ok(vec![kind])
    }

    /// Whether what is chosen or built depends on the rays of the scene.
    pub fn goes_by_rays(&self) -> bool {
        self.is_all()
            || self.index == "auto"
            || kind_by_name(&self.index).is_some_and(IndexKind::goes_by_rays)
    }

    /// Whether `all` was asked for.
    pub fn is_all(&self) -> bool {
        self.index == "all"
    }
}
