//! Indices on the heap: built, timed, chosen, and built by several threads.

mod automatic;
mod threads;
mod timed_index;

pub use automatic::select_index;
pub use threads::Threads;
pub use timed_index::{TimedIndex, kind_by_name, kind_names};
