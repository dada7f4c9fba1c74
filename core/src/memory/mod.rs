//! Memory that the caller provides: typed slices of bytes, a growing run of words, radix sort and selection.

mod arena;
mod sort;
mod words;

pub use arena::{ALIGNMENT, Aligned, Block};
pub(crate) use arena::{Arena, padded, size_of_slice};
pub(crate) use sort::{SortBuffer, nth_smallest, sort_by_digits, sort_by_key, sort_by_upper_half};
pub use words::Words;

/// Writes a value, if there is such a slot. Callers know that there is; the check keeps a panic out.
#[inline]
pub(crate) fn put<T>(slots: &mut [T], at: usize, value: T) {
    if let Some(slot) = slots.get_mut(at) {
        *slot = value;
    }
}
