//! Build of a BVH8, in two passes.
//!
//! ```text
//! 1. sort:  primitives --partition, binned_sah--> order of the leaves --collapse--> nodes of up to eight, and their rows
//! 2. emit:  subtrees --full or quantised--> words
//! ```
//! 1. The primitives are partitioned in two again and again, down to leaves of up to eight. On the way back, the binary
//!    splits are collapsed into nodes, which gives the length of each subtree.
//! 2. Each subtree is written to where it belongs.
//!
//! Both passes go down the tree in branches that share no state. So an executor may run them in parallel, and the bytes
//! are the same. A dry run is the first pass alone.
//!
//! `slices` is the first pass in slices, for a build that pauses.
//!
//! The quantised indices begin with the first pass too, and write its [`Subtree`]s in their own form.

mod binned_sah;
mod bins;
mod box8;
pub(crate) mod collapse;
mod partition;
pub(crate) mod primitive;
pub(crate) mod slices;

use super::rows::LANES;
use crate::cluster::MAX_TREE_DEPTH;
use crate::error::BuildError;
use crate::input::{Executor, MOST_TRIANGLES};
use crate::memory::{Arena, Words, put, size_of_slice};
use crate::structure::DividedScene;
use collapse::{BinarySplit, Forest, Subtree};
use partition::{Divider, Subset};
use primitive::Primitive;

/// Bounds the scratch bytes of the first pass.
pub(crate) const fn scratch_bytes(triangle_count: usize) -> usize {
    let counts = size_of_slice::<u32>(triangle_count.saturating_mul(2));
    size_of_slice::<Primitive>(triangle_count)
        .saturating_add(size_of_slice::<BinarySplit>(triangle_count))
        .saturating_add(counts)
}

/// Result of the first pass: the primitives in the order of the leaves, at least one.
pub(crate) struct Sorted<'s> {
    pub root: Subtree<'s>,
    /// The largest absolute value of any triangle's coordinates.
    pub largest: f32,
}

/// Runs the first pass, in `scratch_bytes` of scratch.
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
    // Branches may run in parallel and do not share a count, so the steps are known only at the end. The depth bounds
    // them. A `work_limit` below the fewest of all is refused before sorting.
    let least = least_steps(count);
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

/// The steps of a balanced tree, the fewest of all.
pub(crate) fn least_steps(count: usize) -> u64 {
    count as u64 * u64::from((count / LEAF_TRIANGLES).checked_ilog2().unwrap_or(0) + 1)
}

/// Leaf size: the most triangles in a leaf, in all three forms. Leaves of one node share rows, so small leaves cost
/// memory only where they leave lanes unused. [`Options::leaf_capacity`](crate::Options::leaf_capacity) is not read.
/// The documentation of `full` lists the other sizes that were measured.
///
/// Another size is no other format, and old bytes still open. It changes the trees: golden counters and digests, the
/// limits of bytes in `host/tests`, the weights and the table of stacks follow.
pub(crate) const LEAF_TRIANGLES: usize = 8;
const _: () = assert!(LEAF_TRIANGLES.is_power_of_two() && LEAF_TRIANGLES <= LANES);

/// Depth within a cluster from which on primitives are split equally.
const BALANCED_FROM: u32 = 32;
/// Levels that equal splits of the largest scene take down to full leaves: 27.
const EQUAL_SPLITS: u32 = MOST_TRIANGLES.ilog2() - LEAF_TRIANGLES.ilog2();
/// Largest depth: the levels of the cluster tree, and those of a cluster. At worst each binary split is a node.
pub(crate) const MAX_DEPTH: u32 = MAX_TREE_DEPTH as u32 + BALANCED_FROM + EQUAL_SPLITS;

/// Number of primitives from which on branches are offered to the executor.
const LARGE: usize = 4096;

/// Runs both closures, by the executor if `count` primitives are many.
pub(crate) fn both<A: Send, B: Send>(
    executor: &impl Executor,
    count: usize,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if count >= LARGE { executor.join(a, b) } else { (a(), b()) }
}

/// First pass.
struct Sorter<'b, E> {
    divider: Divider<'b>,
    executor: &'b E,
}

impl<E: Executor> Sorter<'_, E> {
    /// Sorts a subset of primitives into the order of its leaves, and stores its splits. `from` is the index of its
    /// first primitive. The recursion is as deep as the splits.
    fn sort(
        &self,
        primitives: &mut [Primitive],
        splits: &mut [BinarySplit],
        from: u32,
        subset: &Subset,
    ) -> Forest {
        let count = primitives.len();
        if count <= LEAF_TRIANGLES {
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
        put(splits, length, split);
        forest
    }
}
