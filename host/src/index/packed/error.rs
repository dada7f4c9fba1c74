//! Errors of packed scenes.

use std::io;
use std::path::PathBuf;

use arboleda::OpenError;
use thiserror::Error;

/// Problem of a file of a packed scene.
#[derive(Debug, Error)]
pub enum PackedProblem {
    /// The file of the index.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    #[error("{0}; `arboleda pack` writes indices")]
    Unopened(OpenError),
    /// The file of the scene.
    #[error("cannot be read: {0}; `arboleda pack` writes it beside the index")]
    NoScene(io::Error),
    #[error("it is not the scene of an index, which `arboleda pack` writes beside it")]
    NotAScene,
    #[error("it was written on a machine of the other byte order; pack the scene on this one")]
    OtherByteOrder,
    #[error("its version is {found}, but this program reads version {read}; pack the scene again")]
    Version { found: u32, read: u32 },
    #[error(
        "it is torn or was changed: its contents do not have the digest that it names; pack the scene again"
    )]
    Torn,
    #[error("it contradicts itself")]
    Contradiction,
    /// Both do not belong together.
    #[error(
        "it is not the scene of {}, but of another index, or one of them was changed: pack the scene again",
        index.display()
    )]
    OtherIndex { index: PathBuf },
}
