//! The default build: top-down by the binned surface-area heuristic (SAH), in a loop.
//!
//! 1. Bound the triangles of a subset, and their centroids.
//! 2. Along each axis, fill the bins, and find the plane of least cost between two of them.
//! 3. Partition the ids by the plane, write the node, and go on with the lower half; the upper half waits. Or write a
//!    leaf.
//!
//! There is no recursion: the subsets that wait are those beside the way to the current one, at most one a level.

use core::ops::Range;

use arrayvec::ArrayVec;

use super::{BALANCED_FROM, BINS, CHILD_WORDS, MAX_DEPTH, bin_of, push_inner, push_leaf, set_box};
use crate::error::BuildError;
use crate::geometry::Aabb;
use crate::indices::cost::half_area;
use crate::input::{Level, Mesh, Options};
use crate::memory::{Words, put};

/// Subset of the triangles whose subtree is to be written.
struct Waiting {
    /// The run of its ids.
    ids: Range<usize>,
    depth: u32,
    /// Offset of the words in the parent that take its box and its link; for the root, of the link alone.
    slot: usize,
}

/// Partition of triangles by the bin of their centroid on an axis.
struct BinnedSplit {
    axis: usize,
    /// The first bin of the upper part.
    bin: usize,
    /// The number of triangles of the lower part.
    middle: usize,
    cost: f64,
}

/// Boxes around some triangles, and around their centroids.
struct Bounds {
    triangles: Aabb,
    centroids: Aabb,
}

/// Build over the triangles of a group.
pub(super) struct BinnedBuild<'b> {
    pub triangles: Mesh<'b>,
    pub options: &'b Options,
}

impl BinnedBuild<'_> {
    /// Writes all words. `ids` are the group's, and `other` is a buffer as long.
    ///
    /// # Errors
    /// [`BuildError::TooMuchWork`].
    pub fn write(
        &self,
        words: &mut Words<'_>,
        ids: &mut [u32],
        other: &mut [u32],
    ) -> Result<(), BuildError> {
        // Links count from the first word, the root's.
        let start = words.push(0);
        let mut waiting = ArrayVec::<Waiting, { MAX_DEPTH as usize + 1 }>::new();
        let mut next = Some(Waiting { ids: 0..ids.len(), depth: 0, slot: start });
        while let Some(subset) = next.take().or_else(|| waiting.pop()) {
            let Range { start: first, end } = subset.ids;
            let ids = ids.get_mut(first..end).unwrap_or_default();
            let other = other.get_mut(first..end).unwrap_or_default();
            words.spend(ids.len() as u64)?;
            let bounds = self.bounds(ids);
            let link = match self.divide(subset.depth, &bounds, ids, other) {
                None => push_leaf(words, start, ids.iter().copied()),
                Some(length) => {
                    let (boxes, middle, depth) =
                        (push_inner(words), first + length, subset.depth + 1);
                    let slot = boxes + CHILD_WORDS as usize;
                    let pushed =
                        waiting.try_push(Waiting { ids: middle..end, depth, slot }).is_ok();
                    debug_assert!(pushed, "one for each level");
                    next = Some(Waiting { ids: first..middle, depth, slot: boxes });
                    (boxes - start) as u32
                }
            };
            if subset.depth == 0 {
                words.set(subset.slot, link);
            } else {
                set_box(words, subset.slot, &bounds.triangles, link);
            }
        }
        Ok(())
    }

    fn bounds_of(&self, id: u32) -> Aabb {
        self.triangles.get(id).map_or(Aabb::EMPTY, |triangle| triangle.bounds())
    }

    fn bounds(&self, ids: &[u32]) -> Bounds {
        let mut bounds = Bounds { triangles: Aabb::EMPTY, centroids: Aabb::EMPTY };
        for &id in ids {
            let triangle = self.bounds_of(id);
            bounds.triangles = bounds.triangles.union(triangle);
            bounds.centroids = bounds.centroids.with_point(triangle.centre());
        }
        bounds
    }

    /// Divides a subset in two, the lower part in front, and returns the length of that. `None` if it is to be a leaf:
    /// at the largest depth, or where SAH or the size of the leaf asks for one.
    fn divide(
        &self,
        depth: u32,
        bounds: &Bounds,
        ids: &mut [u32],
        other: &mut [u32],
    ) -> Option<usize> {
        let most_depth = match self.options.level {
            Level::Automatic => MAX_DEPTH,
            Level::AtMost(level) => level.min(MAX_DEPTH),
        };
        if depth >= most_depth {
            return None;
        }
        if depth >= BALANCED_FROM {
            let too_large = ids.len() > self.options.leaf_capacity.max(1) as usize;
            return too_large.then_some(ids.len() / 2);
        }
        let split = self.split(bounds, ids)?;
        self.partition(&bounds.centroids, &split, ids, other);
        Some(split.middle)
    }

    /// Finds the partition of least SAH cost; `None` if a leaf is cheaper and not too large.
    // Not inlined: the bins need not be on the stack while triangles are partitioned.
    #[inline(never)]
    fn split(&self, bounds: &Bounds, ids: &[u32]) -> Option<BinnedSplit> {
        let mut best: Option<BinnedSplit> = None;
        for axis in 0..3 {
            // 1. Fill the bins.
            let mut counts = [0_u32; BINS];
            let mut boxes = [Aabb::EMPTY; BINS];
            for &id in ids {
                let triangle = self.bounds_of(id);
                let bin = bin_of(&bounds.centroids, axis, &triangle);
                if let (Some(count), Some(bounds)) = (counts.get_mut(bin), boxes.get_mut(bin)) {
                    *count += 1;
                    *bounds = bounds.union(triangle);
                }
            }
            // 2. Sweep upwards for the costs of the lower parts, then downwards for the upper parts and the sums.
            let mut lower = [0.0; BINS];
            let (mut sum, mut part) = (0, Aabb::EMPTY);
            for ((cost, &count), bounds) in lower.iter_mut().zip(&counts).zip(&boxes) {
                sum += count;
                part = part.union(*bounds);
                *cost = half_area(part.extent()) * f64::from(sum);
            }
            let (mut sum, mut part) = (0, Aabb::EMPTY);
            for bin in (1..BINS).rev() {
                sum += counts[bin % BINS];
                part = part.union(boxes[bin % BINS]);
                if sum == 0 || sum as usize == ids.len() {
                    continue;
                }
                let cost = lower[(bin - 1) % BINS] + half_area(part.extent()) * f64::from(sum);
                if best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(BinnedSplit { axis, bin, middle: ids.len() - sum as usize, cost });
                }
            }
        }
        // 3. Compare the best partition with a leaf.
        let split = best?;
        let model = self.options.cost_model();
        let whole = half_area(bounds.triangles.extent());
        let divided = model.traversal * 2.0 * whole + model.intersection * split.cost;
        let leaf = model.intersection * whole * ids.len() as f64;
        let too_large = ids.len() > self.options.leaf_capacity as usize;
        (too_large || divided < leaf).then_some(split)
    }

    /// Partitions `ids`: moves the lower part to the front, and keeps the order within both parts.
    fn partition(&self, centroids: &Aabb, split: &BinnedSplit, ids: &mut [u32], other: &mut [u32]) {
        let (mut below, mut above) = (0, split.middle);
        for &id in ids.iter() {
            let is_below = bin_of(centroids, split.axis, &self.bounds_of(id)) < split.bin;
            let next = if is_below { &mut below } else { &mut above };
            put(other, *next, id);
            *next += 1;
        }
        for (to, from) in ids.iter_mut().zip(other.iter()) {
            *to = *from;
        }
    }
}
