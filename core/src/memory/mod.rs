//! Memory that the caller provides: typed slices of bytes, a growing run of words, and a radix sort.

mod arena;
mod sort;
mod words;

pub use arena::{ALIGNMENT, Aligned, Block};
pub(crate) use arena::{Arena, padded, size_of_slice};
pub(crate) use sort::{SortBuffer, sort_by_key, sort_by_upper_half};
pub use words::Words;
