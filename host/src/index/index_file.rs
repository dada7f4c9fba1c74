//! Files of indices: the bytes of an index, as they lie in memory.

use std::io;
use std::path::Path;

use arboleda::{AnyIndex, OpenError, Statistics};
use thiserror::Error;

use crate::files::{FileError, MappedFile};

#[derive(Debug, Error)]
enum IndexProblem {
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    #[error("{0}; `arboleda pack` writes indices")]
    Unopened(OpenError),
}

/// File of an index. It is mapped into memory, so nothing is copied, and processes that open it share its pages. What
/// cannot be mapped, such as a pipe, is read.
///
/// While it is mapped, the file must not be written to or cut short: a program that reads what is no longer there is
/// ended by the system. To replace it, write another file and rename it, as `arboleda pack` does.
///
/// # Examples
/// ```no_run
/// use arboleda_host::IndexFile;
///
/// let file = IndexFile::open("city.arb".as_ref())?;
/// let (index, _) = file.index()?; // once; then ask it
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct IndexFile(MappedFile);

impl IndexFile {
    /// Maps a file, or reads it.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let file = MappedFile::open(path);
        Ok(Self(file.map_err(|error| FileError::new(path, IndexProblem::Unreadable(error)))?))
    }

    /// Opens the index of any kind in the file, and validates it. Cost: linear; keep the result for all queries. Also
    /// returns what it consists of.
    ///
    /// # Errors
    /// If the bytes are not an index that holds its triangles.
    pub fn index(&self) -> Result<(AnyIndex<'_>, Statistics), FileError> {
        AnyIndex::from_bytes_counted(self.0.bytes())
            .map_err(|error| FileError::new(self.0.path(), IndexProblem::Unopened(error)))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use arboleda::{IndexKind, Options, OwnedIndex, Scene, Triangle, Vec3};

    use super::*;

    fn written(folder: &Path) -> (PathBuf, OwnedIndex) {
        let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y); 3];
        let scene = Scene::new(&triangles);
        let owned = OwnedIndex::build(IndexKind::Bvh, &scene, &Options::DEFAULT).unwrap();
        let path = folder.join("a.arb");
        fs::write(&path, owned.as_bytes()).unwrap();
        (path, owned)
    }

    #[test]
    fn a_file_is_mapped_and_opened_in_place() {
        let folder = tempfile::tempdir().unwrap();
        let (path, owned) = written(folder.path());
        let file = IndexFile::open(&path).unwrap();
        assert!(file.0.is_mapped());
        let (index, statistics) = file.index().unwrap();
        assert_eq!(index.as_bytes().as_ptr(), file.0.bytes().as_ptr());
        assert_eq!(index.as_bytes(), owned.as_bytes());
        assert_eq!(statistics, index.check().unwrap());
    }

    #[test]
    fn a_file_that_is_replaced_stays_as_it_was_opened() {
        let folder = tempfile::tempdir().unwrap();
        let (path, owned) = written(folder.path());
        let file = IndexFile::open(&path).unwrap();
        crate::files::output::write_file(&path, |file| file.write_all(b"another")).unwrap();
        assert_eq!(file.index().unwrap().0.as_bytes(), owned.as_bytes());
    }

    #[test]
    #[cfg(unix)]
    fn a_pipe_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let (path, owned) = written(folder.path());
        let pipe = folder.path().join("pipe.arb");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let file = std::thread::scope(|scope| {
            scope.spawn(|| fs::copy(&path, &pipe).unwrap());
            IndexFile::open(&pipe).unwrap()
        });
        assert!(!file.0.is_mapped());
        assert_eq!(file.index().unwrap().0.as_bytes(), owned.as_bytes());
    }

    #[test]
    fn an_empty_file_and_none_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.arb");
        assert!(IndexFile::open(&path).unwrap_err().to_string().contains("a.arb: cannot be read"));
        fs::write(&path, b"").unwrap();
        let file = IndexFile::open(&path).unwrap();
        assert!(file.index().unwrap_err().to_string().contains("cut short"));
    }
}
