//! The default build: top-down by the binned surface-area heuristic (SAH), in a loop.
//!
//! Each part of the triangles goes through these phases, which look at its triangles one by one:
//!
//! ```text
//! Bound -> Fill x, y, z -> Partition -> Copy -> its node is written, and both halves go on the stack, the lower on top
//!      \             \
//!       \             +--> Leaf: no split is cheaper than a leaf, and it is not too large
//!        +--> both halves at once, or Leaf: beyond the depth where parts are split by SAH
//! ```
//! 1. `Bound`: the boxes around the triangles and around their centroids.
//! 2. `Fill`: along each axis, the box and the count of each bin, and then the plane of least cost between bins.
//! 3. `Partition`: the ids below the plane, then those above, each in their order, to the other buffer.
//! 4. `Copy`: back again.
//! 5. `Leaf`: the ids, to the words.
//!
//! There is no recursion: the parts that wait are those beside the way to the current one, at most one a level.

use arrayvec::ArrayVec;

use super::{
    BALANCED_FROM, BINS, CHILD_WORDS, LEAF, MAX_DEPTH, bin_of, push_inner, set_box, split_level,
};
use crate::cost::half_area;
use crate::error::BuildError;
use crate::geometry::Aabb;
use crate::input::{Mesh, Options};
use crate::memory::{Words, put};

/// Most parts that wait: one a level, and both halves of the current part.
const MOST_WAITING: usize = MAX_DEPTH as usize + 2;

/// Part of the triangles, whose subtree is to be written.
#[derive(Clone, Copy)]
struct Part {
    /// Where its ids lie.
    first: u32,
    end: u32,
    depth: u32,
    /// Offset of the words in the parent that take its box and its link; for the root, of the link alone.
    slot: u32,
}

/// What is being done with the triangles of a part.
#[derive(Clone, Copy)]
enum Phase {
    Bound,
    Fill { axis: usize },
    Partition { split: BinnedSplit, below: u32, above: u32 },
    Copy { middle: u32 },
    Leaf,
}

/// Partition of triangles by the bin of their centroid on an axis.
#[derive(Clone, Copy)]
struct BinnedSplit {
    axis: usize,
    /// The first bin of the upper part.
    bin: usize,
    /// The number of triangles of the lower part.
    middle: u32,
    cost: f64,
}

/// State of a build.
pub(super) struct BinnedBuild {
    /// Offset of the group's first word, from which links count.
    start: usize,
    waiting: ArrayVec<Part, MOST_WAITING>,
    part: Option<Part>,
    phase: Phase,
    bounds: Aabb,
    centroids: Aabb,
    counts: [u32; BINS],
    boxes: [Aabb; BINS],
    best: Option<BinnedSplit>,
}

impl BinnedBuild {
    /// Begins the build of a group of `count` triangles.
    pub fn new(count: usize, words: &mut Words<'_>) -> Self {
        let start = words.push(0);
        let mut waiting = ArrayVec::new();
        let root = Part { first: 0, end: count as u32, depth: 0, slot: start as u32 };
        let _ = waiting.try_push(root); // there is room
        Self {
            start,
            waiting,
            part: None,
            phase: Phase::Bound,
            bounds: Aabb::EMPTY,
            centroids: Aabb::EMPTY,
            counts: [0; BINS],
            boxes: [Aabb::EMPTY; BINS],
            best: None,
        }
    }

    /// Writes all words. `ids` are the group's, and `other` is a buffer as long.
    ///
    /// # Errors
    /// [`BuildError::TooMuchWork`].
    pub fn run(
        &mut self,
        triangles: Mesh<'_>,
        options: &Options,
        words: &mut Words<'_>,
        ids: &mut [u32],
        other: &mut [u32],
    ) -> Result<(), BuildError> {
        loop {
            let Some(part) = self.part else {
                let Some(part) = self.waiting.pop() else { return Ok(()) };
                words.spend(u64::from(part.end.saturating_sub(part.first)))?;
                (self.part, self.phase) = (Some(part), Phase::Bound);
                (self.bounds, self.centroids) = (Aabb::EMPTY, Aabb::EMPTY);
                continue;
            };
            let range = part.first as usize..part.end as usize;
            let ids = ids.get_mut(range.clone()).unwrap_or_default();
            let other = other.get_mut(range).unwrap_or_default();
            self.look_at_all(triangles, words, ids, other);
            self.end_phase(&part, ids.len(), options, words)?;
        }
    }

    /// Does what the phase does with each triangle of the part.
    fn look_at_all(
        &mut self,
        triangles: Mesh<'_>,
        words: &mut Words<'_>,
        ids: &mut [u32],
        other: &mut [u32],
    ) {
        let bounds_of =
            |id: u32| triangles.get(id).map_or(Aabb::EMPTY, |triangle| triangle.bounds());
        match &mut self.phase {
            Phase::Bound => {
                for &id in ids.iter() {
                    let triangle = bounds_of(id);
                    self.bounds = self.bounds.union(triangle);
                    self.centroids = self.centroids.with_point(triangle.centre());
                }
            }
            Phase::Fill { axis } => {
                for &id in ids.iter() {
                    let triangle = bounds_of(id);
                    let bin = bin_of(&self.centroids, *axis, &triangle);
                    if let (Some(count), Some(bounds)) =
                        (self.counts.get_mut(bin), self.boxes.get_mut(bin))
                    {
                        *count += 1;
                        *bounds = bounds.union(triangle);
                    }
                }
            }
            Phase::Partition { split, below, above } => {
                for &id in ids.iter() {
                    let is_below = bin_of(&self.centroids, split.axis, &bounds_of(id)) < split.bin;
                    let next = if is_below { &mut *below } else { &mut *above };
                    put(other, *next as usize, id);
                    *next += 1;
                }
            }
            Phase::Copy { .. } => {
                for (to, from) in ids.iter_mut().zip(other.iter()) {
                    *to = *from;
                }
            }
            Phase::Leaf => words.extend(ids),
        }
    }

    /// Decides what follows on a phase that has looked at all `count` triangles of the part.
    fn end_phase(
        &mut self,
        part: &Part,
        count: usize,
        options: &Options,
        words: &mut Words<'_>,
    ) -> Result<(), BuildError> {
        match self.phase {
            Phase::Bound => {
                let too_large = count > options.leaf_capacity.max(1) as usize;
                if part.depth >= split_level(options) {
                    self.begin_leaf(part, count, words);
                } else if part.depth < BALANCED_FROM {
                    self.best = None;
                    self.begin_axis(0);
                } else if too_large {
                    self.halve(part, count as u32 / 2, words)?;
                } else {
                    self.begin_leaf(part, count, words);
                }
            }
            Phase::Fill { axis } => {
                self.sweep(axis, count);
                if axis < 2 {
                    self.begin_axis(axis + 1);
                } else if let Some(split) = self.cheaper_than_leaf(count, options) {
                    self.phase = Phase::Partition { split, below: 0, above: split.middle };
                } else {
                    self.begin_leaf(part, count, words);
                }
            }
            Phase::Partition { split, .. } => self.phase = Phase::Copy { middle: split.middle },
            Phase::Copy { middle } => self.halve(part, middle, words)?,
            Phase::Leaf => self.part = None,
        }
        Ok(())
    }

    fn begin_axis(&mut self, axis: usize) {
        (self.counts, self.boxes) = ([0; BINS], [Aabb::EMPTY; BINS]);
        self.phase = Phase::Fill { axis };
    }

    /// Writes the number of the leaf's triangles; the ids follow.
    fn begin_leaf(&mut self, part: &Part, count: usize, words: &mut Words<'_>) {
        let offset = words.push(count as u32);
        self.link(part, (offset - self.start) as u32 | LEAF, words);
        self.phase = Phase::Leaf;
    }

    /// Writes the part's node, and lets both halves wait.
    fn halve(&mut self, part: &Part, middle: u32, words: &mut Words<'_>) -> Result<(), BuildError> {
        let boxes = push_inner(words);
        self.link(part, (boxes - self.start) as u32, words);
        let (depth, slot, middle) = (part.depth + 1, boxes as u32, part.first + middle);
        let below = Part { end: middle, depth, slot, ..*part };
        let above = Part { first: middle, depth, slot: slot + CHILD_WORDS, ..*part };
        // There is room for one a level.
        self.waiting.try_push(above).map_err(|_| BuildError::TooLarge)?;
        self.waiting.try_push(below).map_err(|_| BuildError::TooLarge)?;
        self.part = None;
        Ok(())
    }

    /// Fills in the part's box and link in its parent.
    fn link(&self, part: &Part, link: u32, words: &mut Words<'_>) {
        let slot = part.slot as usize;
        if part.depth == 0 {
            words.set(slot, link);
        } else {
            set_box(words, slot, &self.bounds, link);
        }
    }

    /// Finds the plane of least SAH cost on an axis whose bins are filled.
    fn sweep(&mut self, axis: usize, count: usize) {
        // Upwards for the costs of the lower parts, then downwards for the upper parts and the sums.
        let mut lower = [0.0; BINS];
        let (mut sum, mut part) = (0, Aabb::EMPTY);
        for ((cost, &count), bounds) in lower.iter_mut().zip(&self.counts).zip(&self.boxes) {
            sum += count;
            part = part.union(*bounds);
            *cost = half_area(part.extent()) * f64::from(sum);
        }
        let (mut sum, mut part) = (0, Aabb::EMPTY);
        for bin in (1..BINS).rev() {
            sum += self.counts[bin % BINS];
            part = part.union(self.boxes[bin % BINS]);
            if sum == 0 || sum as usize == count {
                continue;
            }
            let cost = lower[(bin - 1) % BINS] + half_area(part.extent()) * f64::from(sum);
            if self.best.as_ref().is_none_or(|best| cost < best.cost) {
                self.best = Some(BinnedSplit { axis, bin, middle: count as u32 - sum, cost });
            }
        }
    }

    /// The best partition; `None` if a leaf is cheaper and not too large.
    fn cheaper_than_leaf(&self, count: usize, options: &Options) -> Option<BinnedSplit> {
        let split = self.best?;
        let model = options.cost_model();
        let whole = half_area(self.bounds.extent());
        let divided = model.traversal * 2.0 * whole + model.intersection * split.cost;
        let leaf = model.intersection * whole * count as f64;
        let too_large = count > options.leaf_capacity as usize;
        (too_large || divided < leaf).then_some(split)
    }
}
