//! Size classes: small and large primitives are separated before clustering.
//!
//! The box diagonals are divided at the largest ratios between neighbours in size, where a ratio is at least
//! [`LEAST_RATIO`]. On a log scale these are the widest gaps.
//!
//! The sizes on both sides of a gap differ in their exponents. So the diagonals are sorted by these alone, and only the
//! median of each class is looked for exactly.
//!
//! # Source
//! Cazals, Drettakis and Puech 1995, section 3: their filter divides a histogram of sizes on a log
//! scale where it is empty; gaps of the sorted sizes are the same without a bin width.

use core::mem::replace;
use core::ops::Range;

use arrayvec::ArrayVec;

use crate::geometry::Aabb;
use crate::input::Options;
use crate::memory::{nth_smallest, put, sort_by_digits};

/// The most classes.
pub(super) const MOST_CLASSES: usize = 4;

/// Least ratio of two neighbouring sizes that are divided. Triangles of one tessellated object differ by less from one
/// to the next.
const LEAST_RATIO: f64 = 2.0;

/// Divisor for the least number of primitives below a gap: a gap divides only if at least one in `LEAST_PART_BELOW` of
/// all primitives is below it. The few smallest triangles of a tessellation (at the pole of a sphere, the lid
/// of a teapot) are no class. Few *large* primitives are a class: a floor may be two triangles.
const LEAST_PART_BELOW: usize = 100;

/// The eight-bit digits of an `f64` that hold its exponent, and the four bits behind it.
const EXPONENT: Range<u32> = 6..8;

/// The digits [`EXPONENT`] of a key.
fn exponent(key: u64) -> u64 {
    key >> (8 * EXPONENT.start)
}

/// Size class: the primitives from a size on, up to the next class.
pub(super) struct SizeClass {
    /// The number of primitives.
    pub count: usize,
    /// The square of the least box diagonal.
    least_squared: f64,
    /// The square of the median box diagonal.
    pub typical_size_squared: f64,
}

/// Finds the class of a non-empty box, among those that it was divided into.
pub(super) fn class_of(bounds: &Aabb, classes: &[SizeClass]) -> u32 {
    let above = classes.iter().skip(1);
    above.filter(|class| bounds.diagonal_squared() >= class.least_squared).count() as u32
}

/// Divides the non-empty boxes by diagonal into at most `options.size_classes` classes, that of the smallest primitives
/// first. `keys` and `buffer` have a word for each box.
pub(super) fn divide(
    boxes: &[Aabb],
    options: &Options,
    keys: &mut [u64],
    buffer: &mut [u64],
) -> ArrayVec<SizeClass, MOST_CLASSES> {
    // 1. Sort the squares of the diagonals by their exponents. The bits of non-negative floats sort like the floats.
    let mut count = 0;
    for bounds in boxes.iter().filter(|bounds| !bounds.is_empty()) {
        put(keys, count, bounds.diagonal_squared().to_bits());
        count += 1;
    }
    let keys = keys.get_mut(..count).unwrap_or_default();
    sort_by_digits(EXPONENT, keys, buffer);

    // 2. Find the widest gaps, as (ratio of squares, index of the first primitive above); of equal ones, the lowest.
    // Gaps lie between runs of equal exponents.
    let mut gaps = ArrayVec::<(f64, usize), MOST_CLASSES>::new();
    let (mut rest, mut largest) = (&*keys, 0.0);
    while let Some(&first) = rest.first() {
        let position = count - rest.len();
        let length = rest.iter().take_while(|&&key| exponent(key) == exponent(first)).count();
        let (run, after) = rest.split_at_checked(length).unwrap_or_default();
        rest = after;
        let range =
            run.iter().fold((u64::MAX, 0), |(least, most), &key| (key.min(least), key.max(most)));
        let (least, most) = (f64::from_bits(range.0), f64::from_bits(range.1));
        let below = replace(&mut largest, most);
        let is_wide = least >= below * (LEAST_RATIO * LEAST_RATIO) && below > 0.0;
        if !is_wide || position < count.div_ceil(LEAST_PART_BELOW) {
            continue;
        }
        let ratio = least / below;
        // Insertion sort, wider gaps first. `Vec::insert` could panic.
        let mut carried = (ratio, position);
        let wider = gaps.iter().take_while(|gap| gap.0 >= ratio).count();
        for gap in gaps.iter_mut().skip(wider) {
            core::mem::swap(gap, &mut carried);
        }
        if gaps.len() < options.size_classes.saturating_sub(1) as usize {
            let pushed = gaps.try_push(carried).is_ok();
            debug_assert!(pushed, "at most three gaps are kept");
        }
    }

    // 3. Divide at the gaps.
    let mut classes = ArrayVec::new();
    let mut start = 0;
    while start < count {
        let end = gaps.iter().map(|gap| gap.1).filter(|&position| position > start).min();
        let end = end.unwrap_or(count);
        let keys = keys.get_mut(start..end).unwrap_or_default();
        let least = keys.iter().copied().min().unwrap_or(0);
        let class = SizeClass {
            count: keys.len(),
            least_squared: f64::from_bits(least),
            typical_size_squared: f64::from_bits(median(keys)),
        };
        let pushed = classes.try_push(class).is_ok();
        debug_assert!(pushed, "three gaps make four classes");
        start = end;
    }
    classes
}

/// The median of keys that are sorted by their exponents; of two, the larger. Keys are moved and overwritten.
fn median(keys: &mut [u64]) -> u64 {
    let middle = keys.len() / 2;
    let of_middle = keys.get(middle).map_or(0, |&key| exponent(key));
    let first = keys.partition_point(|&key| exponent(key) < of_middle);
    let end = keys.partition_point(|&key| exponent(key) <= of_middle);
    nth_smallest(keys.get_mut(first..end).unwrap_or_default(), middle - first)
}
