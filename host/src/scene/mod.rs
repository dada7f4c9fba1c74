//! Sources of triangles: scene files, the paper's scenes, generated cities.
//!
//! ```text
//! files (several, one after another) -> formats (one file) -> surface (rounded, divided into triangles) --+-> Model
//! builtin (names) --------------------> generated (functions) --------------------------------------------+
//! ```
//! `vector` calculates with points and normals of triangles in `f64`, here and for photons.

pub mod builtin;
mod error;
mod files;
pub mod formats;
mod generated;
mod model;
mod surface;
pub(crate) mod vector;

pub use error::{LineProblem, SceneError};
pub use files::SceneFiles;
pub use formats::load;
pub use generated::{city, mixed, paper, shapes, sized, teapot};
pub use model::{AreaLight, Census, Column, FaceLight, LitSides, Model, UpAxis, closed};
pub use surface::{DEFAULT_REFLECTANCE, Import, NotAnOrigin, Origin, Surface};

#[cfg(test)]
pub(crate) mod test_support {
    //! Queries of the core that tests of scenes share.

    use arboleda::{Block, Options, Scene, clusters as cluster};

    /// Counts clusters and size classes with these options.
    pub(crate) fn cluster_counts(scene: &Scene<'_>, options: &Options) -> (usize, u32) {
        let bytes = cluster::scratch_capacity(scene.triangles().len());
        let mut scratch = vec![Block::ZERO; Block::count(bytes)];
        let clusters = cluster::find(scene, options, Block::bytes(&mut scratch))
            .expect("built-in scenes are valid");
        (clusters.count(), clusters.class_count())
    }
}
