//! Errors of scenes, worded so that a person can act on them.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Error of loading or making a scene.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file does not exist or cannot be read.
    #[error("cannot read {}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A line of the file is not valid.
    #[error("{}, line {line}: {problem}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// Number of the line, counted from 1. For a continued line, the number of the first part.
        line: usize,
        /// Problem of the line.
        problem: LineProblem,
    },
    /// A part of the file is not valid.
    #[error("{}, {place}: {problem}", file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// Part of the file: a line, an element, the header.
        place: String,
        /// Problem of the part.
        problem: String,
    },
    /// The file has no face of three or more corners, so no ray could hit anything.
    #[error(
        "{}: no faces of three or more corners found ({vertex_count} vertices, {ignored_count} points, \
         lines and shorter faces); {hint}",
        file.display()
    )]
    NoFaces {
        /// The file.
        file: PathBuf,
        /// Number of vertices in the file.
        vertex_count: usize,
        /// Number of points, lines, and faces of one or two corners.
        ignored_count: usize,
        /// Question that hints at the likely cause.
        hint: &'static str,
    },
    /// The file is of a kind that cannot be read.
    #[error("{}: {kind}; {cure}", file.display())]
    Foreign {
        /// The file.
        file: PathBuf,
        /// Description of the file's kind.
        kind: &'static str,
        /// Advice how to get a file that can be read.
        cure: &'static str,
    },
    /// Every face has a vertex that is not finite.
    #[error(
        "{}: all {faces} faces have a vertex that is not finite as a 32-bit number",
        file.display()
    )]
    NoFiniteFaces {
        /// The file.
        file: PathBuf,
        /// Number of faces.
        faces: usize,
    },
    /// The crate that reads OBJ files refused a file that passed this crate's checks.
    #[error("{} is refused by the reader of OBJ files", file.display())]
    Refused {
        /// The file.
        file: PathBuf,
        /// Reason of the crate.
        source: tobj::LoadError,
    },
    /// A folder has no scene files.
    #[error("{}: no scene files (.obj, .ply, .stl, .gltf, .glb) in it", folder.display())]
    NoSceneFiles {
        /// The folder.
        folder: PathBuf,
    },
    /// No built-in scene has this name.
    #[error("there is no built-in scene `{name}`; there are: {}", super::builtin::list())]
    UnknownScene {
        /// The name asked for.
        name: String,
    },
    /// The text names no axis.
    #[error("`{given}` is not an axis that points up; use y, z or auto")]
    UnknownAxis {
        /// The text.
        given: String,
    },
}

/// Problem of a line of an OBJ file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LineProblem {
    /// A vertex has fewer than three coordinates.
    #[error("a vertex needs 3 coordinates, but has {given}")]
    FewCoordinates {
        /// Number of coordinates on the line.
        given: usize,
    },
    /// A coordinate is not a number.
    #[error("vertex coordinate `{text}` is not a number")]
    NotANumber {
        /// The coordinate as written.
        text: String,
    },
    /// A corner of a face does not begin with a whole number other than 0.
    #[error("face corner `{text}` does not begin with a vertex number (1, 2, ... or -1, -2, ...)")]
    NotAnIndex {
        /// The corner as written.
        text: String,
    },
    /// A face names a vertex that does not exist.
    #[error("a face names vertex {index}, but there are {vertex_count} vertices {place}")]
    OutOfRange {
        /// Vertex number as written.
        index: i64,
        /// Number of vertices that the corner could have named.
        vertex_count: usize,
        /// Place of these vertices: "in the file", or "above it" for a negative number.
        place: &'static str,
    },
}
