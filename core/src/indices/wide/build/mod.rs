//! Building in two passes.
//!
//! First the triangles are sorted into the order of the leaves by dividing them in two again and again, and the
//! divisions are collapsed into nodes, which tells how much each subtree will take; then everything is written to
//! where it belongs. Both go down the tree in branches that know nothing of each other, so an executor may run
//! them at once, and the bytes are the same. Where nothing is to be written, the first pass says how much it
//! would be.
//!
//! Indices that write the same tree in another way begin with the first pass too, and go down a [`Subtree`].

mod binned_sah;
pub(crate) mod collapse;
mod partition;
pub(crate) mod primitive;

use super::rows::LANES;
use crate::cluster::MAX_TREE_DEPTH;
use crate::error::BuildError;
use crate::input::Executor;
use crate::memory::{Arena, Words, size_of_slice};
use crate::structure::DividedScene;
use collapse::{BinarySplit, Forest, Subtree};
use partition::{Divider, Subset};
use primitive::Primitive;

pub(crate) const fn scratch_bytes(triangle_count: usize) -> usize {
    let counts = size_of_slice::<u32>(triangle_count.saturating_mul(2));
    size_of_slice::<Primitive>(triangle_count)
        .saturating_add(size_of_slice::<BinarySplit>(triangle_count))
        .saturating_add(counts)
}

/// The triangles in the order of the leaves, one at least.
pub(crate) struct Sorted<'s> {
    pub root: Subtree<'s>,
    /// The largest coordinate of any triangle.
    pub largest: f32,
}

/// The first pass, in `scratch_bytes` of scratch.
///
/// # Errors
/// [`BuildError::ScratchFull`], [`BuildError::Misaligned`], [`BuildError::TooMuchWork`].
pub(crate) fn sort<'s>(
    division: &DividedScene<'_>,
    words: &mut Words<'_>,
    scratch: &'s mut [u8],
    executor: &impl Executor,
) -> Result<Sorted<'s>, BuildError> {
    let DividedScene { triangles, clusters, ref nodes, .. } = *division;
    let count = triangles.len();
    // Branches may be built at once and do not share a count, so the steps are known only at the end; the depth bounds
    // them. A limit below the steps of a balanced tree, the fewest of all, is refused here.
    let least = count as u64 * u64::from((count / LANES).checked_ilog2().unwrap_or(0) + 1);
    if least > words.steps_left() {
        words.spend(least)?;
    }
    let full = BuildError::ScratchFull { needed: scratch_bytes(count), given: scratch.len() };
    let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
    let primitives = arena.take::<Primitive>(count).ok_or(full)?;
    let splits = arena.take::<BinarySplit>(count).ok_or(full)?;
    let counts = arena.take::<u32>(nodes.len()).ok_or(full)?;
    let divider = Divider::new(primitives, counts, triangles, clusters, nodes);

    let subset = divider.root(primitives);
    let largest = divider.bounds(&subset).largest_coordinate();
    let forest = Sorter { divider, executor }.sort(primitives, splits, 0, &subset);
    words.spend(forest.steps)?;
    Ok(Sorted { root: Subtree::root(primitives, splits, &forest), largest })
}

/// So many divisions into a cluster, triangles are divided into equal parts, which takes at most 25 more.
const BALANCED_FROM: u32 = 32;
/// The levels of the cluster tree, and those of a cluster: at worst a node for each division.
pub(crate) const MAX_DEPTH: u32 = MAX_TREE_DEPTH as u32 + BALANCED_FROM + 27;

/// From so many primitives on, branches are offered to the executor.
const LARGE: usize = 4096;

/// Does both, at once if they are large.
pub(crate) fn both<A: Send, B: Send>(
    executor: &impl Executor,
    count: usize,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if count >= LARGE { executor.join(a, b) } else { (a(), b()) }
}

/// The first pass.
struct Sorter<'b, E> {
    divider: Divider<'b>,
    executor: &'b E,
}

impl<E: Executor> Sorter<'_, E> {
    /// Sorts the primitives of a part, of which the first has the number `from`, into the order of its leaves, and
    /// files how they are divided. As deep a recursion as they are divided.
    fn sort(
        &self,
        primitives: &mut [Primitive],
        splits: &mut [BinarySplit],
        from: u32,
        subset: &Subset,
    ) -> Forest {
        let count = primitives.len();
        if count <= LANES {
            return Forest::leaf(count);
        }
        let half_area = self.divider.bounds(subset).half_area();
        let (length, subsets) = self.divider.divide(primitives, subset);
        let at = from + length as u32;
        let halves = (primitives.split_at_mut_checked(length), splits.split_at_mut_checked(length));
        let (Some(primitives), Some(halves)) = halves else { return Forest::leaf(count) };
        let (left, right) = both(
            self.executor,
            count,
            || self.sort(primitives.0, halves.0, from, &subsets[0]),
            || self.sort(primitives.1, halves.1, at, &subsets[1]),
        );
        let (mut forest, split) = Forest::join(&left, &right, at, half_area);
        forest.steps += count as u64;
        if let Some(slot) = splits.get_mut(length) {
            *slot = split;
        }
        forest
    }
}
