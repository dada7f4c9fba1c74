//! Files beside scenes: what a file is, rays from it, and results to it.

mod error;
mod mapped;
pub(crate) mod output;
pub mod rays;
pub(crate) mod signature;
mod target;

pub use error::FileError;
pub(crate) use mapped::MappedFile;
