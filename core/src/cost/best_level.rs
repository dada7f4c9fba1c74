//! How deep a tree is worth dividing.

use crate::error::BuildError;
use crate::memory::Words;

/// The level of `0..=most` at which the cost stops falling.
///
/// `cost_at` writes the tree of a level and returns its cost. Levels are tried from 0 upwards, so the work is
/// dominated by the last ones: the search ends at the second level in a row that is no better, where the next would
/// make the same tree, or before a level whose tree would take the search beyond its `budget` of steps.
///
/// # Errors
/// The errors of `cost_at`, and [`BuildError::TooMuchWork`] if `words` allow fewer steps than the budget.
pub(crate) fn best_level(
    most: u32,
    budget: u64,
    words: &mut Words<'_>,
    cost_at: &mut impl FnMut(u32, &mut Words<'_>) -> Result<f64, BuildError>,
) -> Result<u32, BuildError> {
    let mut best = (f64::INFINITY, 0);
    let mut last = f64::INFINITY;
    let mut left = budget;
    for level in 0..=most {
        // A dry run.
        let mut tried = Words::limited(&mut [], left.min(words.steps_left()));
        let cost = cost_at(level, &mut tried);
        words.spend(tried.steps())?;
        left = left.saturating_sub(tried.steps());
        let cost = match cost {
            Err(BuildError::TooMuchWork { .. }) => break,
            cost => cost?,
        };
        if cost == last {
            break;
        }
        last = cost;
        if cost < best.0 * LEAST_FALL {
            best = (cost, level);
        } else if level > best.1 + 1 {
            break;
        }
    }
    Ok(best.1)
}

/// The steps that the search for a level or a resolution may take where choosing a plane looks at each triangle
/// `looks` times: a multiple of `n log2 n`.
///
/// On the built-in scenes searches take up to 13 `n log2 n` for the octree (figure 3), 15 for the BSP tree, 17 for
/// grids and 34 for the octree-R, which looks six times: all of them end by themselves. Where triangles lie in one
/// place, 64 instead of 16 found levels that cost rays as much, after four times the work.
pub(crate) fn search_steps(triangle_count: usize, looks: u64) -> u64 {
    let count = triangle_count as u64;
    let levels = u64::from(u64::BITS - count.leading_zeros());
    count.saturating_mul(levels).saturating_mul(16 + 4 * looks)
}

/// A level that saves less than this is not worth its memory. It is small because the cost of a tree
/// around far clusters is mostly that of reaching them.
const LEAST_FALL: f64 = 0.9995;
