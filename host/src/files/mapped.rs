//! Files whose bytes are mapped into memory, so that processes share them.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use arboleda::Block;
use memmap2::Mmap;

/// File whose bytes lie in memory, at the beginning of a [`Block`]. They are mapped, so that nothing is copied, and
/// processes share the pages. What cannot be mapped, such as a pipe, is read.
///
/// While it is mapped, the file must not be written to or cut short: a program that reads what is no longer there is
/// ended by the system. To replace it, write another file and rename it, as `arboleda pack` does.
#[derive(Debug)]
pub(crate) struct MappedFile {
    path: PathBuf,
    file: File,
    contents: Contents,
}

#[derive(Debug)]
enum Contents {
    Mapped(Mmap),
    /// Aligned, and the number of bytes.
    Read(Vec<Block>, usize),
}

impl MappedFile {
    /// Maps a file, or reads it.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn open(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let contents = Contents::of(&mut file)?;
        Ok(Self { path: path.into(), file, contents })
    }

    /// Returns the path by which the file was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Asks the system about the file that was opened, whatever its path names by now.
    ///
    /// # Errors
    /// If the system does not tell.
    pub fn metadata(&self) -> io::Result<Metadata> {
        self.file.metadata()
    }

    /// Returns the bytes.
    #[inline]
    pub fn bytes(&self) -> &[u8] {
        match &self.contents {
            Contents::Mapped(map) => map,
            Contents::Read(blocks, count) => &bytemuck::cast_slice(blocks)[..*count],
        }
    }

    /// Tells whether the bytes are mapped, and not read.
    #[cfg(test)]
    pub fn is_mapped(&self) -> bool {
        matches!(self.contents, Contents::Mapped(_))
    }
}

impl Contents {
    fn of(file: &mut File) -> io::Result<Self> {
        // A map of a pipe or of a device would be refused, or would have no bytes.
        if file.metadata()?.is_file()
            && let Ok(map) = map(file)
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
