//! Scene files, recognised by their first bytes or their ending.
//!
//! ```text
//! bytes -> recognise -> obj, ply, stl, gltf -> Surface
//! ```
//! Readers take bytes, so they can be called without a file system; a function gives the bytes of other files
//! that a scene needs, such as materials.

pub mod gltf;
mod lines;
pub mod obj;
pub mod ply;
mod recognise;
pub mod stl;

use std::path::Path;
use std::{fs, io};

use super::surface::{Origin, Surface};
use super::{Model, SceneError};
use recognise::Format;

/// Reads a file that a scene file names, by its path.
pub type Companions<'c> = dyn Fn(&Path) -> io::Result<Vec<u8>> + 'c;

/// Loads a scene file, and logs its warnings and its origin.
///
/// # Errors
/// [`SceneError::Unreadable`], and those of [`read`] and [`Surface::place`].
pub fn load(path: &Path, origin: Origin) -> Result<Model, SceneError> {
    let bytes =
        fs::read(path).map_err(|source| SceneError::Unreadable { file: path.into(), source })?;
    let surface = read(&bytes, path, &|companion| fs::read(companion))?;
    drop(bytes);
    let import = surface.place(origin)?;
    for warning in &import.warnings {
        log::warn!("{warning}");
    }
    let [x, y, z] = import.model.origin;
    if origin != Origin::Unchanged {
        log::info!(
            "{}: origin {x},{y},{z} subtracted; add it to positions that are shown to get those of the file",
            path.display()
        );
    }
    Ok(import.model)
}

/// Reads the bytes of a scene file of any known format.
///
/// # Errors
/// [`SceneError::Foreign`] for a file of another kind that is recognised, and those of the format's reader.
pub fn read(bytes: &[u8], name: &Path, companions: &Companions) -> Result<Surface, SceneError> {
    match recognise::format(bytes, name)? {
        Format::Obj => obj::read(bytes, name, companions),
        Format::Gltf => gltf::read(bytes, name, companions),
        Format::Ply => ply::read(bytes, name),
        Format::Stl => stl::read(bytes, name),
    }
}

#[cfg(test)]
mod tests;
