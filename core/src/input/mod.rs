//! Input of a build and of queries: mesh, scene, options, executor, SIMD level.

mod executor;
mod mesh;
mod options;
mod scene;
mod simd_level;

pub use executor::{Executor, Sequential};
pub(crate) use mesh::MOST_TRIANGLES;
pub use mesh::Mesh;
pub use options::{BvhBuild, CostModel, Float64, Level, Options, Resolution};
pub(crate) use options::{MAX_LEVEL, MOST_CELLS_ON_AXIS};
pub use scene::Scene;
pub use simd_level::SimdLevel;
