//! Errors of files of rays, each with the cure where there is one.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Error of a file of rays: the file and its problem.
#[derive(Debug, Error)]
#[error("{}: {problem}", file.display())]
pub struct RaysError {
    /// The file.
    pub file: PathBuf,
    /// The problem.
    pub problem: RaysProblem,
}

/// Problem of a file of rays.
#[derive(Debug, Error)]
pub enum RaysProblem {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// The file is of another kind, which is recognised.
    #[error("{kind}; {cure}")]
    Foreign {
        /// A sentence about the kind of the file.
        kind: &'static str,
        /// Advice on a file that would be read.
        cure: &'static str,
    },
    /// The file does not begin as a `.npy` file does.
    #[error("it is not a .npy file; save the rays with numpy.save")]
    NotNpy,
    /// The header cannot be understood.
    #[error("the header of the .npy file is not valid: {0}")]
    Header(String),
    /// The file ends before its last number.
    #[error("it is cut off: {needed} bytes are needed for shape {shape:?}, here are {found}")]
    CutOff {
        /// The shape in the header.
        shape: Vec<u64>,
        /// Bytes of the whole file, by the header.
        needed: u128,
        /// Bytes of the file as it is.
        found: usize,
    },
    /// The array has another shape.
    #[error("it has shape {0:?}; rays are of shape (N, 6) or (N, 8)")]
    Shape(Vec<u64>),
    /// The columns of the array lie one after the other.
    #[error("it is in Fortran order; save it with numpy.ascontiguousarray")]
    FortranOrder,
    /// The numbers are of a type that is not read.
    #[error(
        "it holds values of type {0}; rays are float32 or float64: save it with .astype('<f4')"
    )]
    Element(String),
}
