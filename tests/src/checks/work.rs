//! Bounds on the work of builds.

use arboleda::{Level, Options, Resolution};

/// Returns the most steps of a build of `triangle_count` triangles with automatic level and resolution: 80 `n log2 n`.
///
/// The 80 divide as follows: 16 for the search of a resolution, or 6 for that of a level, 40 for split planes chosen by
/// cost, and the rest for the tree.
pub fn most_steps(triangle_count: usize) -> u64 {
    let levels = usize::BITS - triangle_count.leading_zeros();
    80 * triangle_count as u64 * u64::from(levels)
}

/// Tells whether level and resolution are automatic. Given ones may require more work than [`most_steps`].
pub fn is_found(options: &Options) -> bool {
    options.level == Level::Automatic && options.resolution == Resolution::Automatic
}
