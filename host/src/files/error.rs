//! Error of reading a file that this program writes.

use std::error::Error as Cause;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Error of reading a photon map, a part of a shot or an index: the file, and what is wrong with it.
#[derive(Debug, Error)]
#[error("{}: {problem}", file.display())]
pub struct FileError {
    file: PathBuf,
    #[source]
    problem: Box<dyn Cause + Send + Sync>,
}

impl FileError {
    pub(crate) fn new(file: &Path, problem: impl Cause + Send + Sync + 'static) -> Self {
        Self { file: file.into(), problem: Box::new(problem) }
    }
}
