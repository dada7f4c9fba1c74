//! What can be wrong with a scene, said so that a person can act.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why there is no scene.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file does not exist or cannot be read.
    #[error("cannot read {}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// A line of the file is wrong.
    #[error("{}, line {line}: {problem}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1; of a continued line, the first.
        line: usize,
        /// What is wrong with it.
        problem: LineProblem,
    },
    /// A part of a file without lines is wrong.
    #[error("{}, {place}: {problem}", file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// The place in the file: a line, an element, the header.
        place: String,
        /// The problem there.
        problem: String,
    },
    /// There is nothing in the file that a ray could hit.
    #[error(
        "{}: no faces of three or more corners found ({vertex_count} vertices, {ignored_count} points, \
         lines and shorter faces); {hint}",
        file.display()
    )]
    NoFaces {
        /// The file.
        file: PathBuf,
        /// How many vertices it has.
        vertex_count: usize,
        /// The number of points, lines, and faces of one or two corners.
        ignored_count: usize,
        /// A question about the likely cause.
        hint: &'static str,
    },
    /// The file is of a kind that is not read.
    #[error("{}: {kind}; {cure}", file.display())]
    Foreign {
        /// The file.
        file: PathBuf,
        /// A sentence about the kind of the file.
        kind: &'static str,
        /// Advice on a file that would be read.
        cure: &'static str,
    },
    /// Each face has a vertex that is not finite.
    #[error(
        "{}: all {faces} faces have a vertex that is not finite as a 32-bit number",
        file.display()
    )]
    NoFiniteFaces {
        /// The file.
        file: PathBuf,
        /// The number of faces.
        faces: usize,
    },
    /// The reader of OBJ files refused the file for a reason that the checks before it do not know.
    #[error("{} is refused by the reader of OBJ files", file.display())]
    Refused {
        /// The file.
        file: PathBuf,
        /// Its reason.
        source: tobj::LoadError,
    },
    /// No built-in scene has this name.
    #[error("there is no built-in scene `{name}`; there are: {}", super::builtin::list())]
    UnknownScene {
        /// The name asked for.
        name: String,
    },
    /// Not an axis.
    #[error("`{given}` is not an axis that points up; use y, z or auto")]
    UnknownAxis {
        /// What was given.
        given: String,
    },
}

/// What is wrong with a line of an OBJ file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LineProblem {
    /// A vertex has fewer than three coordinates.
    #[error("a vertex needs 3 coordinates, here are {given}")]
    FewCoordinates {
        /// How many there are.
        given: usize,
    },
    /// A coordinate is no number.
    #[error("vertex coordinate `{text}` is not a number")]
    NotANumber {
        /// The coordinate as written.
        text: String,
    },
    /// A face names a vertex by something that is no whole number other than 0.
    #[error("face corner `{text}` does not begin with a vertex number (1, 2, ... or -1, -2, ...)")]
    NotAnIndex {
        /// The corner as written.
        text: String,
    },
    /// A face names a vertex that does not exist.
    #[error("a face names vertex {index}, but there are {vertex_count} vertices {place}")]
    OutOfRange {
        /// The number as written.
        index: i64,
        /// How many vertices it could have named.
        vertex_count: usize,
        /// "in the file", or, for a negative number, "above it".
        place: &'static str,
    },
}
