//! Files of indices: the bytes of an index, as they lie in memory.

use std::path::Path;
use std::{fs, io};

use arboleda::{OpenError, OwnedIndex};
use thiserror::Error;

use crate::files::FileError;

#[derive(Debug, Error)]
enum IndexProblem {
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    #[error("{0}; `arboleda pack` writes indices")]
    Unopened(OpenError),
}

/// Reads an index of any kind from a file, and validates it.
///
/// # Errors
/// If the file cannot be read, or its bytes are not an index that holds its triangles.
pub fn load_index(path: &Path) -> Result<OwnedIndex, FileError> {
    let bytes = fs::read(path).map_err(IndexProblem::Unreadable);
    let index =
        bytes.and_then(|bytes| OwnedIndex::from_bytes(&bytes).map_err(IndexProblem::Unopened));
    index.map_err(|problem| FileError::new(path, problem))
}
