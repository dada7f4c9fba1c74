//! Errors of files of rays, with the remedy if there is one.

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
    /// The file is recognised as another kind.
    #[error("{kind}; {cure}")]
    Foreign {
        /// Description of the file's kind.
        kind: &'static str,
        /// Advice how to get a file that can be read.
        cure: &'static str,
    },
    /// The file does not begin as a `.npy` file does.
    #[error("it is not a .npy file; save the {name} with numpy.save")]
    NotNpy {
        /// What the file should hold.
        name: &'static str,
    },
    /// The header cannot be understood.
    #[error("the header of the .npy file is not valid: {0}")]
    Header(String),
    /// The file ends before its last number.
    #[error("it is cut off: shape {shape:?} needs {needed} bytes, but it has {found}")]
    CutOff {
        /// The shape in the header.
        shape: Vec<u64>,
        /// Bytes that the file needs by its header.
        needed: u128,
        /// Bytes that the file has.
        found: usize,
    },
    /// The array has another shape.
    #[error("it has shape {shape:?}; {name} are of shape {shapes}")]
    Shape {
        /// The shape in the header.
        shape: Vec<u64>,
        /// What the file should hold.
        name: &'static str,
        /// Shapes that are read.
        shapes: &'static str,
    },
    /// The array is stored column by column.
    #[error("it is in Fortran order; save it with numpy.ascontiguousarray")]
    FortranOrder,
    /// The numbers are of a type that cannot be read.
    #[error(
        "it holds values of type {found}; {name} are float32 or float64: save it with .astype('<f4')"
    )]
    Element {
        /// The type in the header.
        found: String,
        /// What the file should hold.
        name: &'static str,
    },
}
