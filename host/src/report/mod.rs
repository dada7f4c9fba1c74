//! What a person looks at: pictures, plots, tables, pages.

mod camera;
mod canvas;
pub mod grid;
pub mod html;
pub mod pages;
mod picture;
pub mod plot;

pub use camera::{Camera, UpAxis};
pub use canvas::{Canvas, Colour};
pub use picture::{cluster_colour, heat, paint_clusters, paint_irradiance};
