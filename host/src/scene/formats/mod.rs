//! Readers of scene files, whose format is recognised by the first bytes or the file name's ending.
//!
//! ```text
//! bytes -> recognise -> obj, ply, stl, gltf -> Surface
//! ```
//! Readers take bytes, so they work without a file system. The caller's function reads companion files, such as
//! materials.

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

/// Function that reads a file named by a scene file.
pub type Companions<'c> = dyn Fn(&Path) -> io::Result<Vec<u8>> + 'c;

/// Loads a scene file. Logs its warnings and, if it was subtracted, its origin.
///
/// # Errors
/// [`SceneError::Unreadable`], and those of [`read`] and [`Surface::place`].
pub fn load(path: &Path, origin: Origin) -> Result<Model, SceneError> {
    let import = read_file(path)?.place(origin)?;
    for warning in &import.warnings {
        log::warn!("{warning}");
    }
    origin.log(path.display(), import.model.origin, "the file's");
    Ok(import.model)
}

/// Reads a scene file of any known format.
///
/// # Errors
/// [`SceneError::Unreadable`], and those of [`read`].
pub fn read_file(path: &Path) -> Result<Surface, SceneError> {
    let bytes =
        fs::read(path).map_err(|source| SceneError::Unreadable { file: path.into(), source })?;
    read(&bytes, path, &read_companion)
}

/// Reads a file that a scene file names. The scene may come from someone else, so a pipe or a device, which may never
/// end, is refused.
fn read_companion(path: &Path) -> io::Result<Vec<u8>> {
    if fs::metadata(path)?.is_file() {
        fs::read(path)
    } else {
        Err(io::Error::other("it is not a regular file"))
    }
}

/// Reads the bytes of a scene file of any known format.
///
/// # Errors
/// [`SceneError::Foreign`] for a file recognised as another kind, and those of the format's reader.
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
