//! Surface: the contents of a scene file before conversion to a model, polygons with coordinates in `f64`.
//!
//! ```text
//! obj, ply, stl, gltf -> Surface -> place: origin subtracted, rounded to f32 -> polygon: divided -> Model
//!                           \-> precision, rounding: loss by rounding, of one file and of several
//! ```
//! Every format becomes a surface, so all formats are converted and checked in the same way.

mod material;
mod origin;
mod place;
mod polygon;
mod precision;
mod rounding;

use std::path::PathBuf;

use super::SceneError;
pub use material::DEFAULT_REFLECTANCE;
pub(in crate::scene) use material::Material;
pub(in crate::scene) use origin::Extent;
pub use origin::{NotAnOrigin, Origin};
pub use place::Import;
pub(in crate::scene) use rounding::RoundingLoss;

/// Polygons of a scene file.
///
/// # Invariants
/// - `arities` divide `corners` into faces, in order; each face has at least three corners.
/// - `parts` divide the faces, in order.
/// - `corners` are indices into `positions`.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Path of the file, for messages and the model's name.
    file: PathBuf,
    positions: Vec<[f64; 3]>,
    corners: Vec<u32>,
    /// Number of corners of each face.
    arities: Vec<u32>,
    parts: Vec<FaceRun>,
    object_names: Vec<String>,
    warnings: Vec<String>,
}

/// Consecutive faces of one object and one material.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FaceRun {
    first_face: usize,
    object: u32,
    material: Material,
}

impl Surface {
    /// Creates a surface without faces. Messages name the file; the last part of its path names the model.
    pub(super) fn new(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            positions: Vec::new(),
            corners: Vec::new(),
            arities: Vec::new(),
            parts: Vec::new(),
            object_names: Vec::new(),
            warnings: Vec::new(),
        }
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    pub(super) fn face_count(&self) -> usize {
        self.arities.len()
    }

    pub(super) fn add_vertex(&mut self, position: [f64; 3]) {
        self.positions.push(position);
    }

    /// Adds an object and returns its number, for [`Self::begin_part`].
    pub(super) fn add_object(&mut self, name: impl Into<String>) -> u32 {
        self.object_names.push(name.into());
        self.object_names.len() as u32 - 1
    }

    /// Begins a part: faces added from now on have this object and material.
    pub(super) fn begin_part(&mut self, object: u32, material: Material) {
        self.parts.push(FaceRun { first_face: self.arities.len(), object, material });
    }

    /// Adds a face. The caller guarantees three corners or more, and that all corners exist when the surface is placed.
    pub(super) fn add_face(&mut self, corners: impl IntoIterator<Item = u32>) {
        let before = self.corners.len();
        self.corners.extend(corners);
        debug_assert!(self.corners.len() >= before + 3);
        self.arities.push((self.corners.len() - before) as u32);
    }

    /// Finds the first corner that names no vertex; returns the number of its face, and the corner.
    pub(super) fn missing_corner(&self) -> Option<(usize, u32)> {
        let count = self.positions.len();
        self.faces().enumerate().find_map(|(face, corners)| {
            corners.iter().find(|&&corner| corner as usize >= count).map(|&corner| (face, corner))
        })
    }

    /// Adds a face with three vertices of its own.
    pub(super) fn add_triangle(&mut self, corners: [[f64; 3]; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.add_face(first..first + 3);
    }

    /// Makes an error about a part of the file.
    pub(super) fn malformed(
        &self,
        place: impl Into<String>,
        problem: impl std::fmt::Display,
    ) -> SceneError {
        SceneError::Malformed {
            file: self.file.clone(),
            place: place.into(),
            problem: problem.to_string(),
        }
    }

    /// Adds a warning: one line about contents of the file that are lost.
    pub(super) fn warn(&mut self, text: impl std::fmt::Display) {
        self.warnings.push(format!("{}: {text}", self.file.display()));
    }

    /// Returns the positions of all vertices in the file's coordinates. Some may not be finite.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// The box of the vertices of faces.
    pub(super) fn extent(&self) -> Extent {
        Extent::of(self.corners.iter().map(|&corner| &self.positions[corner as usize]))
    }

    /// Iterates over the faces in the order of the file. A face is three or more indices into
    /// [`vertices`](Self::vertices).
    pub fn faces(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = self.corners.as_slice();
        self.arities.iter().map(move |&arity| {
            let (face, after) = rest.split_at(arity as usize);
            rest = after;
            face
        })
    }
}
