//! What a person looks at: pictures, plots, tables, pages.

mod camera;
mod canvas;
mod compare_page;
pub mod grid;
pub mod html;
mod paper_page;
mod paper_words;
mod peers_page;
pub mod peers_table;
mod picture;
pub mod plot;
mod separation_section;

pub use camera::{Camera, UpAxis};
pub use canvas::{Canvas, Colour};
pub use compare_page::{CompareEvidence, compare_page};
pub use paper_page::{PaperEvidence, paper_page};
pub use peers_page::{PeersEvidence, absent, peers_page};
pub use picture::{cluster_colour, heat, paint_clusters, paint_irradiance};
