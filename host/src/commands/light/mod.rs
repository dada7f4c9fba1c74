//! Commands of the light: photons through an index, pictures, irradiance at points; whole, or in parts.
//!
//! ```text
//! lit_scene (scene, lights, index) -> irradiance, render --+-> parts (a range, a checkpoint, several processes; merge)
//!                                     shoot ---------------+
//! ```

pub mod irradiance;
mod lit_scene;
pub mod parts;
pub mod render;
pub mod shoot;
