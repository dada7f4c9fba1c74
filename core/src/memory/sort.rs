//! A stable radix sort in caller-provided memory.
//!
//! LSD radix sort in eight passes of eight bits. A pass is skipped if all keys have the same digit.
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
    sort_by_digits(0..8, keys, values, buffer.keys, buffer.values);
}

/// Sorts `keys` by their upper half. The lower half is a value that moves with it. Equal upper halves keep their order.
/// `buffer` is at least as long as `keys`.
pub(crate) fn sort_by_upper_half(keys: &mut [u64], buffer: &mut [u64]) {
    sort_by_digits(4..8, keys, &mut [], buffer, &mut []);
}

/// Sorts by a range of the keys' eight-bit digits, the lowest digit first. There are as many `values` as keys, or none.
fn sort_by_digits(
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
