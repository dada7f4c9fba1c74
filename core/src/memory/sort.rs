//! Stable radix sort and radix selection, in caller-provided memory.
//!
//! The sort takes one pass for each eight-bit digit, the lowest first (LSD). A pass is skipped if all keys have the same
//! digit.
//!
//! # What lost
//! - The standard library's sort: it may panic where a comparison is inconsistent, and it is not linear.

use core::ops::Range;

use super::{Arena, put};

/// Buffer for sorting `count` keys and values.
pub(crate) struct SortBuffer<'a> {
    keys: &'a mut [u64],
    values: &'a mut [u32],
}

impl<'a> SortBuffer<'a> {
    pub fn take(arena: &mut Arena<'a>, count: usize) -> Option<Self> {
        Some(Self { keys: arena.take(count)?, values: arena.take(count)? })
    }
}

/// Sorts `values` by `keys`, which are as many; equal keys keep their order. The buffer was taken for at least that
/// number.
pub(crate) fn sort_by_key(keys: &mut [u64], values: &mut [u32], buffer: &mut SortBuffer<'_>) {
    sort_with(0..8, keys, values, buffer.keys, buffer.values);
}

/// Sorts `keys` by a range of their eight-bit digits; digit 0 is the lowest. The other digits move with them. Keys that are
/// equal there keep their order. `buffer` is at least as long as `keys`.
pub(crate) fn sort_by_digits(digits: Range<u32>, keys: &mut [u64], buffer: &mut [u64]) {
    sort_with(digits, keys, &mut [], buffer, &mut []);
}

/// Sorts `keys` by their upper half, as [`sort_by_digits`] does: the lower half is a value that moves with it.
pub(crate) fn sort_by_upper_half(keys: &mut [u64], buffer: &mut [u64]) {
    sort_by_digits(4..8, keys, buffer);
}

/// Sorts by a range of the keys' eight-bit digits, the lowest digit first. There are as many `values` as keys, or none.
fn sort_with(
    digits: Range<u32>,
    keys: &mut [u64],
    values: &mut [u32],
    buffer: &mut [u64],
    value_buffer: &mut [u32],
) {
    let count = keys.len();
    let (Some(mut other_keys), Some(mut other_values)) =
        (buffer.get_mut(..count), value_buffer.get_mut(..values.len()))
    else {
        debug_assert!(false, "the sort buffer is too short");
        return;
    };
    let (mut keys, mut values) = (keys, values);
    let mut swapped = false;
    for digit in digits {
        let digit_of = |key: u64| (key >> (8 * digit)) as usize & 0xff;
        let mut starts = [0_u32; 256];
        for &key in keys.iter() {
            starts[digit_of(key)] += 1;
        }
        if starts.iter().any(|&n| n as usize == count) {
            continue;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += core::mem::replace(start, sum);
        }
        let mut offset_of = |key: u64| {
            let start = &mut starts[digit_of(key)];
            core::mem::replace(start, *start + 1) as usize
        };
        if values.is_empty() {
            for &key in keys.iter() {
                put(other_keys, offset_of(key), key);
            }
        } else {
            for (&key, &value) in keys.iter().zip(values.iter()) {
                let offset = offset_of(key);
                put(other_keys, offset, key);
                put(other_values, offset, value);
            }
        }
        core::mem::swap(&mut keys, &mut other_keys);
        core::mem::swap(&mut values, &mut other_values);
        swapped = !swapped;
    }
    if swapped {
        // After an odd number of passes `keys` is the buffer and `other_keys` the caller's slice.
        for (to, from) in other_keys.iter_mut().zip(keys.iter()) {
            *to = *from;
        }
        for (to, from) in other_values.iter_mut().zip(values.iter()) {
            *to = *from;
        }
    }
}

/// Finds the key that would be at `index` if the keys were sorted; `index` is below their number. 0 without keys. Keys are
/// moved and overwritten.
///
/// Radix selection: the keys that share the digits found so far are kept, and counted by their next digit.
pub(crate) fn nth_smallest(keys: &mut [u64], index: usize) -> u64 {
    let (mut count, mut index) = (keys.len(), index);
    for digit in (0..8).rev() {
        let digit_of = |key: u64| (key >> (8 * digit)) as usize & 0xff;
        let mut counts = [0_u32; 256];
        for &key in keys.iter().take(count) {
            counts[digit_of(key)] += 1;
        }
        let mut found = 0;
        for (value, &n) in counts.iter().enumerate() {
            found = value;
            if index < n as usize {
                break;
            }
            index -= n as usize;
        }
        let mut kept = 0;
        for at in 0..count {
            let key = keys.get(at).copied().unwrap_or(0);
            put(keys, kept, key);
            kept += usize::from(digit_of(key) == found);
        }
        count = kept;
    }
    keys.first().copied().filter(|_| count > 0).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec::Vec;

    #[test]
    fn the_nth_smallest_is_where_sorting_puts_it() {
        let mut random = 1_u64;
        for (count, bits) in [(1, 64), (2, 64), (100, 64), (1000, 9), (1000, 50), (257, 1)] {
            let keys: Vec<u64> = (0..count)
                .map(|_| {
                    random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    random >> (64 - bits)
                })
                .collect();
            let mut sorted = keys.clone();
            sorted.sort_unstable();
            for index in [0, count / 3, count / 2, count - 1] {
                assert_eq!(nth_smallest(&mut keys.clone(), index), sorted[index]);
            }
        }
        assert_eq!(nth_smallest(&mut [], 0), 0);
    }
}
