//! Sources of triangles: scene files, the paper's scenes, generated cities.
//!
//! ```text
//! formats (a file) -> surface -> polygon --\   files: several, one after another
//! generated (functions) -> builtin (names) -+-> Model -> light (adds one above a model that has none)
//! ```
//! census and closed inspect a model: shared vertices, triangles without area, closed meshes.

pub mod builtin;
mod census;
pub mod closed;
mod column;
mod error;
mod files;
pub mod formats;
mod generated;
mod light;
mod model;
mod polygon;
mod surface;

pub use census::Census;
pub use column::Column;
pub use error::{LineProblem, SceneError};
pub use files::SceneFiles;
pub use formats::load;
pub use generated::{city, mixed, paper, shapes, sized, teapot};
pub use light::UpAxis;
pub use model::{AreaLight, FaceLight, LitSides, Model};
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
