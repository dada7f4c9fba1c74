//! Files of indices: the bytes of an index, as they lie in memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use arboleda::Statistics;
use arboleda::{AnyIndex, Block, OpenError};
use memmap2::Mmap;
use thiserror::Error;

use crate::files::FileError;

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
pub struct IndexFile {
    path: PathBuf,
    contents: Contents,
}

#[derive(Debug)]
enum Contents {
    Mapped(Mmap),
    /// Aligned, and the number of bytes.
    Read(Vec<Block>, usize),
}

impl IndexFile {
    /// Maps a file, or reads it.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let contents = Contents::of(path)
            .map_err(|error| FileError::new(path, IndexProblem::Unreadable(error)))?;
        Ok(Self { path: path.into(), contents })
    }

    /// Opens the index of any kind in the file, and validates it. Cost: linear; keep the result for all queries. Also
    /// returns what it consists of.
    ///
    /// # Errors
    /// If the bytes are not an index that holds its triangles.
    pub fn index(&self) -> Result<(AnyIndex<'_>, Statistics), FileError> {
        AnyIndex::from_bytes_counted(self.bytes())
            .map_err(|error| FileError::new(&self.path, IndexProblem::Unopened(error)))
    }

    fn bytes(&self) -> &[u8] {
        match &self.contents {
            Contents::Mapped(map) => map,
            Contents::Read(blocks, count) => &bytemuck::cast_slice(blocks)[..*count],
        }
    }
}

impl Contents {
    fn of(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        // A map of a pipe or of a device would be refused, or would have no bytes.
        if file.metadata()?.is_file()
            && let Ok(map) = map(&file)
        {
            return Ok(Self::Mapped(map));
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let mut blocks = vec![Block::ZERO; Block::count(bytes.len())];
        Block::bytes(&mut blocks)[..bytes.len()].copy_from_slice(&bytes);
        Ok(Self::Read(blocks, bytes.len()))
    }
}

/// Maps a file into memory, at the beginning of a page, which is aligned enough for an index.
#[allow(unsafe_code)] // a map is memory that other programs can change
fn map(file: &File) -> io::Result<Mmap> {
    // SAFETY: the caller's promise, told above: nobody writes to the file. `pack` never does, but puts another file in
    // its place, and this map keeps the old one.
    unsafe { Mmap::map(file) }
}

#[cfg(test)]
mod tests {
    use std::fs;

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
        assert!(matches!(file.contents, Contents::Mapped(_)));
        let (index, statistics) = file.index().unwrap();
        assert_eq!(index.as_bytes().as_ptr(), file.bytes().as_ptr());
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
        assert!(matches!(file.contents, Contents::Read(..)));
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
