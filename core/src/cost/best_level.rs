//! Search for the level of a tree at which its estimated cost stops falling.

use crate::error::BuildError;
use crate::memory::Words;

/// Finds the level of `0..=most` at which the cost stops falling.
///
/// `cost_at` writes the tree of a level, and returns its cost. Levels are tried from 0 upwards, so the last ones
/// dominate the work. The search ends
/// - at the second level in a row that is no better,
/// - where two levels in a row cost the same, because the next level would make the same tree,
/// - before a level whose tree would take the search beyond its `budget` of steps.
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
        // A dry run, limited to the steps that are left.
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

/// Bounds the steps that the search for a level or a resolution may take: a multiple of `n log2 n`. Choosing a plane
/// looks at each triangle `looks` times.
///
/// # Measured
/// - On the built-in scenes, a search takes up to 13 `n log2 n` steps for the octree (figure 3), 15 for the BSP tree,
///   17 for grids and 34 for the octree-R, which looks six times. All of these searches end by themselves.
/// - Where triangles lie in one place, a factor of 64 instead of 16 took four times the work, and found levels at which
///   rays cost as much.
pub(crate) fn search_steps(triangle_count: usize, looks: u64) -> u64 {
    let count = triangle_count as u64;
    let levels = u64::from(u64::BITS - count.leading_zeros());
    count.saturating_mul(levels).saturating_mul(16 + 4 * looks)
}

/// Factor by which a level has to reduce the cost: a smaller saving is not worth its memory. It is close to 1, because
/// most of the cost of a tree around far clusters is that of reaching them.
const LEAST_FALL: f64 = 0.9995;
