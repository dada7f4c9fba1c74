//! What can be wrong with a file of rays, said so that a person can act.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why there are no rays.
#[derive(Debug, Error)]
#[error("{}: {problem}", file.display())]
pub struct RaysError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub problem: RaysProblem,
}

/// What is wrong with a file of rays.
#[derive(Debug, Error)]
pub enum RaysProblem {
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// It is of another kind, which is recognised.
    #[error("{kind}; {cure}")]
    Foreign {
        /// What it is.
        kind: &'static str,
        /// What to do.
        cure: &'static str,
    },
    /// It does not begin as a `.npy` file does.
    #[error("it is not a .npy file; save the rays with numpy.save")]
    NotNpy,
    /// Its header cannot be understood.
    #[error("the header of the .npy file is not valid: {0}")]
    Header(String),
    /// It ends too soon.
    #[error("it is cut off: {needed} bytes are needed for shape {shape:?}, here are {found}")]
    CutOff {
        /// By its header.
        shape: Vec<u64>,
        /// Bytes of the whole file, by its header.
        needed: u128,
        /// Bytes that there are.
        found: usize,
    },
    /// It has another shape.
    #[error("it has shape {0:?}; rays are of shape (N, 6) or (N, 8)")]
    Shape(Vec<u64>),
    /// Its columns lie one after the other.
    #[error("it is in Fortran order; save it with numpy.ascontiguousarray")]
    FortranOrder,
    /// Its numbers are of a type that is not read.
    #[error(
        "it holds values of type {0}; rays are float32 or float64: save it with .astype('<f4')"
    )]
    Element(String),
}
