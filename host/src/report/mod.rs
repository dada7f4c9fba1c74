//! Pictures, plots, tables and pages for people to look at.
//!
//! ```text
//! colour, number <- canvas, camera, legend <- picture   PNG files
//!       ^---------- plot <- html <- pages            HTML pages
//! ```

mod camera;
mod canvas;
mod colour;
pub mod grid;
pub mod html;
mod legend;
mod number;
pub mod pages;
mod picture;
pub mod plot;

pub use camera::{Camera, UpAxis};
pub use canvas::Canvas;
pub use colour::{Colour, cluster_colour, heat};
pub use legend::{ColourScale, draw_legend};
pub(crate) use number::{four_decimals, short_number};
pub(crate) use picture::{NIGHT, has_room_for_text};
pub use picture::{paint_clusters, paint_irradiance};
