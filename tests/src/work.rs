//! How much work a build may take.

use arboleda::{Level, Options, Resolution};

/// The most steps of a build of `triangle_count` triangles whose level and resolution are found: 80 `n log2 n`.
///
/// 16 for the search of a level or a resolution, 40 where planes are chosen by cost, and the tree itself.
pub fn most_steps(triangle_count: usize) -> u64 {
    let levels = usize::BITS - triangle_count.leading_zeros();
    80 * triangle_count as u64 * u64::from(levels)
}

/// Whether a build finds its level and its resolution; else they say how much work it is.
pub fn is_found(options: &Options) -> bool {
    options.level == Level::Automatic && options.resolution == Resolution::Automatic
}
