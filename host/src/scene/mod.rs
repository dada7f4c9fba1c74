//! Where triangles come from: OBJ files, the paper's scenes, generated cities.

mod model;

pub use model::{AreaLight, Model};
