//! What a person looks at: pictures and tables.

mod camera;
mod canvas;
mod picture;

pub use camera::{Camera, UpAxis};
pub use canvas::{Canvas, Colour};
pub use picture::{cluster_colour, heat, paint_clusters, paint_irradiance};
