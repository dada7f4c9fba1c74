//! Sources of triangles: scene files, the paper's scenes, generated cities.
//!
//! ```text
//! formats (a file) -> surface -> polygon ---------------\
//! shapes, teapot -> paper, city, mixed, sized -> builtin +-> Model -> light (one above, where there is none)
//! ```
//! Every scene but a file's is a function of its options: no clock, no platform's mathematics, z up.

pub mod builtin;
mod census;
pub mod city;
pub mod closed;
mod error;
pub mod formats;
mod hash;
mod light;
pub mod mixed;
mod model;
pub mod paper;
mod polygon;
pub mod shapes;
pub mod sized;
mod surface;
pub mod teapot;

pub use census::Census;
pub use error::{LineProblem, SceneError};
pub use formats::load;
pub use light::UpAxis;
pub use model::{AreaLight, Model};
pub use surface::{DEFAULT_REFLECTANCE, Import, NotAnOrigin, Origin, Surface};

#[cfg(test)]
pub(crate) mod test_support {
    //! What tests of scenes ask of the core.

    use arboleda::{Block, Options, Scene, clusters as cluster};

    /// The numbers of clusters and of size classes with these options.
    pub(crate) fn cluster_counts(scene: &Scene<'_>, options: &Options) -> (usize, u32) {
        let bytes = cluster::scratch_capacity(scene.triangles().len());
        let mut scratch = vec![Block::ZERO; Block::count(bytes)];
        let clusters = cluster::find(scene, options, Block::bytes(&mut scratch))
            .expect("built-in scenes are valid");
        (clusters.count(), clusters.class_count())
    }
}
