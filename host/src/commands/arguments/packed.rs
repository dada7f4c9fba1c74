//! Option `--index-file`: a packed scene in place of one that is loaded and indexed.

use std::path::{Path, PathBuf};

use arboleda::AnyIndex;
use clap::Args;

use super::values::file_ending_in;
use crate::benchmark::harness::progress::during;
use crate::index::scene_path;
use crate::{PackedIndex, PackedScene, TimedIndex, Validation};

/// Packed scene of a command.
#[derive(Args, Clone, Debug)]
pub struct PackedArguments {
    /// Take the scene and its index from the files X.arb and X.arb.scene that `pack` wrote, in place of SCENE. Nothing
    /// is loaded or built: the files are mapped, and processes of a machine share their memory. The first process on a
    /// machine validates them, and again when they were changed
    #[arg(long, value_name = "X.arb", value_parser = file_ending_in(&["arb"]), conflicts_with_all = [
        "files", "scene", "origin", "index", "leaf_capacity", "level", "least_side", "proximity", "size_classes",
        "cells_per_triangle", "bvh_insertion", "objects",
    ])]
    index_file: Option<PathBuf>,
    /// Validate the files of --index-file although they were validated on this machine before
    #[arg(long)]
    check: bool,
}

impl PackedArguments {
    /// Opens the packed scene, if one is named.
    ///
    /// # Errors
    /// The errors of [`PackedScene::open`]. If none is named, but is to be validated.
    pub fn open(&self) -> anyhow::Result<Option<PackedScene>> {
        let Some(path) = &self.index_file else {
            anyhow::ensure!(!self.check, "--check is for --index-file");
            return Ok(None);
        };
        let validation = if self.check { Validation::Always } else { Validation::Once };
        let scene = during("opening", || PackedScene::open(path, validation))?;
        if scene.is_validated_now {
            log::info!("{}: validated, with its scene", path.display());
        }
        Ok(Some(scene))
    }

    /// Lists the files that are read, if a packed scene is named.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let index = self.index_file.iter();
        index.flat_map(|path| [path.clone(), scene_path(path)]).collect()
    }

    /// Names another packed scene, or none.
    pub fn move_to(&mut self, path: Option<&Path>) {
        (self.index_file, self.check) = (path.map(Path::to_owned), false);
    }
}

/// Index of a command: one that it built, or a packed one.
pub enum SceneIndex {
    Built(TimedIndex),
    Packed(PackedIndex),
}

impl SceneIndex {
    /// Opens the index. Cost: linear for one that was built, so keep the result.
    pub fn index(&self) -> AnyIndex<'_> {
        match self {
            Self::Built(built) => built.index(),
            Self::Packed(packed) => packed.index(),
        }
    }
}
