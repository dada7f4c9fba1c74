//! Packed scenes: an index and what photons need beside it, in two files that processes map and share.
//!
//! ```text
//! city.obj --pack--> city.arb         the bytes of the index, which firmware and other programs open too
//!                    city.arb.scene   triangles that the index does not have, reflectances, lights, names
//!                        |
//!   process, process, .. map both; the first one on a machine validates them, and leaves a record
//! ```
//! The scene names the digest of its index. So a pair that does not belong together is an error, and never another
//! scene's light.

mod error;
mod record;
mod scene_file;
#[cfg(test)]
mod tests;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arboleda::AnyIndex;

use crate::files::output::write_file;
use crate::files::{FileError, MappedFile};
use crate::scene::Model;
use error::PackedProblem;
use record::Record;
use scene_file::SceneFile;
pub(crate) use scene_file::{SceneParts, Sequence, digest_of, emitter_bytes, name_bytes};

/// Version of this program, whose validation a record tells of.
const PROGRAM: &str = concat!("arboleda ", env!("CARGO_PKG_VERSION"));

/// When the files of a packed scene are validated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Validation {
    /// Unless a process of this user did so on this machine, and the files were not changed since.
    #[default]
    Once,
    /// In any case.
    Always,
}

/// Index in a file that is mapped and was validated.
#[derive(Debug)]
pub struct PackedIndex(Arc<MappedFile>);

/// Scene and its index, in files that are mapped.
///
/// # Examples
/// ```no_run
/// use arboleda_host::photon::{ShootOptions, shoot};
/// use arboleda_host::{PackedScene, Validation};
///
/// let PackedScene { model, index, .. } = PackedScene::open("city.arb".as_ref(), Validation::Once)?;
/// let shot = shoot(&model, index.index().as_ray_index(), &ShootOptions::default(), &|_| {});
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PackedScene {
    /// The scene. Its columns lie in the files; object names are left out.
    pub model: Model,
    /// The index over its triangles.
    pub index: PackedIndex,
    /// True if these files were validated just now, false if there was a record of it.
    pub is_validated_now: bool,
    scene: SceneFile,
}

/// Returns the path of the scene that belongs to an index.
pub fn scene_path(index: &Path) -> PathBuf {
    let mut path = OsString::from(index);
    path.push(".scene");
    path.into()
}

impl PackedIndex {
    /// Returns the index. Cost: constant.
    ///
    /// # Panics
    /// If the file was written to since it was opened, against the promise of whoever mapped it.
    pub fn index(&self) -> AnyIndex<'_> {
        AnyIndex::from_validated_bytes(self.0.bytes()).expect("it was opened before")
    }
}

impl PackedScene {
    /// Writes an index, and its scene beside it. Returns the BLAKE3 of the index.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(path: &Path, model: &Model, index: &AnyIndex<'_>) -> anyhow::Result<blake3::Hash> {
        let digest = digest_of(index);
        // Whoever opens them meanwhile finds a pair that does not match.
        SceneParts {
            name: &model.name,
            origin: model.origin,
            lights: &model.lights,
            emitters: Sequence {
                count: model.emitters.len(),
                bytes: &emitter_bytes(&model.emitters, 0)?,
            },
            triangles: &model.triangles,
            reflectance: bytemuck::cast_slice(&model.reflectance),
            colours: bytemuck::cast_slice(&model.colours),
            objects: bytemuck::cast_slice(&model.objects),
            object_names: Sequence {
                count: model.object_names.len(),
                bytes: &name_bytes(&model.object_names)?,
            },
        }
        .write(&scene_path(path), index, &digest)?;
        write_file(path, |file| file.write_all(index.as_bytes()))?;
        Ok(digest)
    }

    /// Maps an index and its scene, and validates them.
    ///
    /// Cost: constant if they were validated before, else linear, on the threads of the caller's pool. Of processes that
    /// open them at the same time, one validates, and the others wait.
    ///
    /// # While they are open
    /// Nobody may write to the files or cut them short, as for [`IndexFile`](crate::IndexFile). `pack` does not: it puts
    /// other files in their place, and those that are open stay as they are.
    ///
    /// # Errors
    /// If a file cannot be read, is not what it should be, or was changed, or if both do not belong together.
    pub fn open(path: &Path, validation: Validation) -> Result<Self, FileError> {
        let beside = scene_path(path);
        let of_index = |problem| FileError::new(path, problem);
        let of_scene = |problem| FileError::new(&beside, problem);
        let other = || of_scene(PackedProblem::OtherIndex { index: path.into() });

        // 1. Both files, and the record of them as they are.
        let file = MappedFile::open(path);
        let file = Arc::new(file.map_err(|error| of_index(PackedProblem::Unreadable(error)))?);
        let scene = MappedFile::open(&beside);
        let scene = scene.map_err(|error| of_scene(PackedProblem::NoScene(error)))?;
        let scene = SceneFile::of(scene).map_err(of_scene)?;
        let record = || {
            let files = [file.metadata().ok()?, scene.file.metadata().ok()?];
            Record::of(&files)
        };
        let before = record();
        let is_there =
            || validation == Validation::Once && before.as_ref().is_some_and(Record::is_there);
        // Who waited for another process finds its record.
        let lock = if is_there() { None } else { before.as_ref().and_then(Record::lock) };
        let is_known = is_there();

        // 2. The index, validated where there is no record.
        let bytes = file.bytes();
        let (digest, length) = scene.head.index;
        let opened = if is_known {
            AnyIndex::from_validated_bytes(bytes)
        } else {
            scene.check().map_err(of_scene)?;
            let (opened, found) = rayon::join(
                || AnyIndex::from_bytes(bytes),
                || blake3::Hasher::new().update_rayon(bytes).finalize(),
            );
            if opened.is_ok() && *found.as_bytes() != digest {
                return Err(other());
            }
            opened
        };
        let index = opened.map_err(|error| of_index(PackedProblem::Unopened(error)))?;
        if length != bytes.len() as u64 {
            return Err(other());
        }
        let model =
            scene.model(&file, &index).ok_or_else(|| of_scene(PackedProblem::Contradiction))?;

        // 3. The record, if nobody changed a file meanwhile.
        if !is_known && let Some(before) = before.filter(|before| record().as_ref() == Some(before))
        {
            before.write();
        }
        drop(lock);
        Ok(Self { model, index: PackedIndex(file), is_validated_now: !is_known, scene })
    }

    /// Reads the names of the model's objects.
    ///
    /// # Errors
    /// If the file does not have them.
    pub fn object_names(&self) -> Result<Vec<String>, FileError> {
        let problem = || FileError::new(self.scene.file.path(), PackedProblem::Contradiction);
        self.scene.object_names().ok_or_else(problem)
    }
}
