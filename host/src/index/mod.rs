//! Indices on the heap: built, timed, chosen, built by several threads, and read from files.

mod automatic;
mod index_file;
mod threads;
mod timed_index;

pub use automatic::select_index;
pub use index_file::IndexFile;
pub use threads::Threads;
pub use timed_index::{TimedIndex, kind_by_name, kind_names};
