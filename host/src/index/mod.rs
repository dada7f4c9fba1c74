//! Indices on the heap and in files: built, timed, chosen, packed with their scenes.
//!
//! ```text
//! automatic (which kind?) -> timed_index (on the heap, built by threads) -> index_file (its bytes, mapped)
//!                            bounded (of scenes that memory does not hold) -> packed (its bytes and its scene, shared)
//! ```

mod automatic;
pub mod bounded;
mod index_file;
pub(crate) mod packed;
mod threads;
mod timed_index;

pub use automatic::select_index;
pub use index_file::IndexFile;
pub use packed::{PackedIndex, PackedScene, Validation, scene_path};
pub use threads::Threads;
pub use timed_index::{TimedIndex, kind_by_name, kind_names};
