//! Memory that is a file: scratch, and views of a file's contents.

use std::fs::File;
use std::io;
use std::path::Path;

use memmap2::MmapOptions;

use super::{Pager, Watched};

/// Bytes in a file; in one without a name, which the system removes when the process ends, however it ends.
pub struct Scratch {
    map: Watched,
    length: usize,
}

impl Scratch {
    /// Makes a file of zeros in a folder. Its place on the disk is taken at once, so that a full disk is an error here.
    ///
    /// # Errors
    /// If the folder cannot be written to, or the disk has less space.
    pub fn new(folder: &Path, length: usize, pager: &Pager) -> io::Result<Self> {
        Self::over(&tempfile::tempfile_in(folder)?, length, pager)
    }

    /// Extends an empty file to `length` bytes, of which at least one, and maps it. The caller's promise: nobody else
    /// uses the file as long as it is mapped.
    ///
    /// # Errors
    /// If the disk has less space.
    pub fn over(file: &File, length: usize, pager: &Pager) -> io::Result<Self> {
        reserve(file, length.max(1) as u64)?;
        let map = MmapOptions::new().len(length.max(1)).map_raw(file)?;
        Ok(Self { map: pager.watch(map)?, length })
    }

    /// The bytes.
    #[allow(unsafe_code)] // the memory of a map has no owner in the language
    pub fn bytes(&mut self) -> &mut [u8] {
        // SAFETY: the map has at least `length` bytes, and is unmapped when `self` is dropped. Nobody else uses the file:
        // it has no name, or by the promise of `over`. The pager gives pages back, which does not change what they hold.
        unsafe { std::slice::from_raw_parts_mut(self.map.as_mut_ptr(), self.length) }
    }
}

/// Bytes of a file that is kept open by the caller, and not changed in the part that is viewed.
pub struct View {
    map: Watched,
    start: usize,
    length: usize,
}

impl View {
    /// Maps `length` bytes of a file from `start` on. The caller's promise: nobody changes them while the view is used.
    ///
    /// # Errors
    /// If the file cannot be mapped, or ends before.
    pub fn new(file: &File, start: usize, length: usize, pager: &Pager) -> io::Result<Self> {
        if file.metadata()?.len() < (start + length) as u64 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let mapped = (start + length).max(1);
        let map = MmapOptions::new().len(mapped).map_raw_read_only(file)?;
        Ok(Self { map: pager.watch(map)?, start, length })
    }

    /// The bytes.
    #[allow(unsafe_code)] // a map is memory that other programs can change
    pub fn bytes(&self) -> &[u8] {
        if self.length == 0 {
            return &[];
        }
        // SAFETY: the map has at least `start + length` bytes, and is unmapped when `self` is dropped. Nobody changes them,
        // by the promise of `new`: the file is a temporary one of this process.
        unsafe { std::slice::from_raw_parts(self.map.as_ptr().add(self.start), self.length) }
    }
}

/// Extends an empty file to a length, and takes the place on the disk.
#[cfg(target_os = "linux")]
fn reserve(file: &File, length: u64) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    use rustix::io::Errno;
    // The pager's signals interrupt it, and some systems undo what is interrupted: a step is short.
    const STEP: u64 = 16 << 20;
    for start in (0..length).step_by(STEP as usize) {
        let step = STEP.min(length - start);
        let reserved =
            rustix::io::retry_on_intr(|| fallocate(file, FallocateFlags::empty(), start, step));
        match reserved {
            Err(Errno::OPNOTSUPP | Errno::NOSYS | Errno::INVAL) if start == 0 => {
                return write_zeros(file, length);
            }
            reserved => reserved?,
        }
    }
    Ok(())
}

/// Extends an empty file to a length, and takes the place on the disk.
#[cfg(not(target_os = "linux"))]
fn reserve(file: &File, length: u64) -> io::Result<()> {
    write_zeros(file, length)
}

fn write_zeros(mut file: &File, length: u64) -> io::Result<()> {
    io::copy(&mut io::Read::take(io::repeat(0), length), &mut file).map(drop)
}

#[cfg(test)]
mod tests {
    use super::super::pager::tests::alone;
    use super::*;
    use std::io::Write;

    #[test]
    fn scratch_is_zero_and_can_be_written() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let pager = Pager::start(u64::MAX);
        for length in [0, 1, 100_000] {
            let mut scratch = Scratch::new(folder.path(), length, &pager).unwrap();
            assert_eq!(scratch.bytes().len(), length);
            assert!(scratch.bytes().iter().all(|&byte| byte == 0));
            scratch.bytes().fill(7);
            Pager::release();
            assert!(scratch.bytes().iter().all(|&byte| byte == 7), "pages that were given back");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "files have no names");
    }

    #[test]
    fn zeros_are_written_where_nothing_reserves_them() {
        let file = tempfile::tempfile().unwrap();
        write_zeros(&file, 100_000).unwrap();
        assert_eq!(file.metadata().unwrap().len(), 100_000);
    }

    #[test]
    fn views_begin_anywhere() {
        let _alone = alone();
        let pager = Pager::start(u64::MAX);
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[1, 2, 3, 4]).unwrap();
        assert_eq!(View::new(&file, 1, 2, &pager).unwrap().bytes(), [2, 3]);
        assert!(View::new(&file, 4, 0, &pager).unwrap().bytes().is_empty());
        assert!(View::new(&file, 3, 2, &pager).is_err());
    }
}
