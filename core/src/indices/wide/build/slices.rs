//! The first pass in slices: it pauses after some looks at triangles, and has a stack of its own.
//!
//! ```text
//! prepare -> many primitives: bin -> partition -> measure -> the same for both sides -> join
//!            few:             all at once
//! ```
//! Each task is a loop over primitives that can go on where it stopped. What it computes does not depend on where that
//! was: the minima, maxima and counts of bins and boxes are exact, and the partition goes through the primitives in
//! their order. So the splits are those of [`Sorter::sort`].

use arrayvec::ArrayVec;

use super::binned_sah::{BINS, FEW, Partition, stride_of};
use super::bins::{Binned, Bins};
use super::collapse::{BinarySplit, Forest};
use super::partition::{Divider, Subset};
use super::primitive::{Primitive, PrimitiveBounds};
use super::{BALANCED_FROM, Sorter};
use crate::input::{MOST_TRIANGLES, Mesh, Sequential};
use crate::memory::put;

/// Most primitives that are sorted at once, in one call without a pause. Fewer where the crate is fuzzed, so that small
/// scenes are divided too.
const AT_ONCE: usize = if cfg!(fuzzing) { FEW } else { 512 };
const _: () = assert!(AT_ONCE >= FEW, "more primitives have all bins");

/// Largest number of subsets whose halves are being sorted, each inside the one before: as many as have more than
/// `AT_ONCE` primitives.
const MOST_OPEN: usize = (BALANCED_FROM + MOST_TRIANGLES.ilog2() - AT_ONCE.ilog2()) as usize + 1;

/// Run of primitives that is to be sorted.
#[derive(Clone, Copy)]
struct PrimitiveRun {
    from: usize,
    count: usize,
    depth: u32,
    bounds: PrimitiveBounds,
}

/// Subset whose halves are being sorted.
struct OpenSplit {
    from: usize,
    count: usize,
    depth: u32,
    half_area: f32,
    /// The length of the first half.
    length: usize,
    half: Half,
}

/// The half that is being sorted, and what is known of the other.
enum Half {
    /// The first; the bounds of the second.
    First(PrimitiveBounds),
    /// The second; the table of the first.
    Second(Forest),
}

/// What is done next.
enum Task {
    /// Make the primitives from `next` on. The bounds are those of all before.
    Prepare {
        next: usize,
        bounds: PrimitiveBounds,
    },
    /// Add the primitives from `next` on to their bins.
    Bin {
        part: PrimitiveRun,
        bins: Bins,
        next: usize,
    },
    Partition {
        part: PrimitiveRun,
        partition: Partition,
    },
    /// Compute the bounds of both sides, of which the first has `length` primitives.
    Measure {
        part: PrimitiveRun,
        length: usize,
        next: usize,
        sides: [PrimitiveBounds; 2],
    },
    /// Go on above a subset that is sorted.
    Join(Forest),
}

/// First pass, as far as it has come.
pub(crate) struct SlicedSort {
    /// `None` once all is sorted.
    task: Option<Task>,
    above: ArrayVec<OpenSplit, MOST_OPEN>,
    binned: Binned<BINS>,
    /// The bounds of all primitives, once they are prepared.
    bounds: PrimitiveBounds,
}

impl SlicedSort {
    pub const fn new() -> Self {
        let bounds = PrimitiveBounds::EMPTY;
        Self {
            task: Some(Task::Prepare { next: 0, bounds }),
            above: ArrayVec::new_const(),
            binned: Binned::EMPTY,
            bounds,
        }
    }

    /// The bounds of all primitives, once they are sorted.
    pub fn bounds(&self) -> &PrimitiveBounds {
        &self.bounds
    }

    /// Goes on until all primitives are sorted, and returns the table of all; or until no look is left, which is `None`.
    /// Takes the looks from `looks`. At least one primitive, and as many splits.
    pub fn go_on(
        &mut self,
        triangles: Mesh<'_>,
        primitives: &mut [Primitive],
        splits: &mut [BinarySplit],
        looks: &mut usize,
    ) -> Option<Forest> {
        while *looks > 0 {
            let task = match self.task.take()? {
                Task::Prepare { next, bounds } => {
                    let end = (next + take(looks, primitives.len() - next)).min(primitives.len());
                    let run = primitives.get_mut(next..end).unwrap_or_default();
                    for (id, slot) in (next as u32..).zip(run.iter_mut()) {
                        *slot = Primitive::new(&triangles.get(id).unwrap_or_default(), id);
                    }
                    let bounds = bounds.with(run);
                    if end < primitives.len() {
                        Task::Prepare { next: end, bounds }
                    } else {
                        self.bounds = bounds;
                        let all =
                            PrimitiveRun { from: 0, count: primitives.len(), depth: 0, bounds };
                        self.begin(all, primitives, splits, looks)
                    }
                }
                Task::Bin { part, bins, next } => self.bin(part, bins, next, primitives, looks),
                Task::Partition { part, mut partition } => {
                    let run = run_of(part, primitives);
                    partition.go_on(run, take(looks, part.count - partition.next));
                    if partition.next < part.count {
                        Task::Partition { part, partition }
                    } else if partition.front == 0 || partition.front == part.count {
                        // Rounding put the plane outside the centroids.
                        measure(part, part.count / 2)
                    } else {
                        measure(part, partition.front)
                    }
                }
                Task::Measure { part, length, next, mut sides } => {
                    // A slice of one side, so that it ends where the other begins.
                    let (side, of_side) = if next < length { (0, length) } else { (1, part.count) };
                    let end = next + take(looks, of_side - next);
                    let run = run_of(part, primitives).get(next..end).unwrap_or_default();
                    if let Some(bounds) = sides.get_mut(side) {
                        *bounds = bounds.with(run);
                    }
                    if end < part.count {
                        Task::Measure { part, length, next: end, sides }
                    } else {
                        let [first, second] = sides;
                        let frame = OpenSplit {
                            from: part.from,
                            count: part.count,
                            depth: part.depth,
                            half_area: part.bounds.bounds.half_area(),
                            length,
                            half: Half::First(second),
                        };
                        let pushed = self.above.try_push(frame).is_ok();
                        debug_assert!(pushed, "one for each level");
                        let depth = part.depth + 1;
                        let half =
                            PrimitiveRun { from: part.from, count: length, depth, bounds: first };
                        self.begin(half, primitives, splits, looks)
                    }
                }
                Task::Join(forest) => match self.above.pop() {
                    Some(open) => self.go_on_above(open, forest, primitives, splits, looks),
                    None => return Some(forest),
                },
            };
            self.task = Some(task);
        }
        None
    }

    /// The first task of a part. Few primitives are sorted at once.
    fn begin(
        &mut self,
        part: PrimitiveRun,
        primitives: &mut [Primitive],
        splits: &mut [BinarySplit],
        looks: &mut usize,
    ) -> Task {
        if part.count <= AT_ONCE {
            let sorter = Sorter { divider: Divider::of_parts(), executor: &Sequential };
            let splits = splits.get_mut(part.from..part.from + part.count).unwrap_or_default();
            let subset = Subset::Inside(part.bounds, part.depth);
            let run = run_of(part, primitives);
            let forest = sorter.sort(run, splits, part.from as u32, &subset);
            *looks = looks.saturating_sub(forest.steps as usize);
            return Task::Join(forest);
        }
        if part.depth >= BALANCED_FROM {
            return measure(part, part.count / 2);
        }
        self.binned = Binned::EMPTY;
        Task::Bin { part, bins: Bins::new(&part.bounds, BINS), next: 0 }
    }

    /// Adds primitives to their bins, and finds the plane once all are in theirs.
    fn bin(
        &mut self,
        part: PrimitiveRun,
        bins: Bins,
        next: usize,
        primitives: &mut [Primitive],
        looks: &mut usize,
    ) -> Task {
        let stride = stride_of(part.count);
        // Each slice begins with a primitive that is binned.
        let binned = take(looks, (part.count - next).div_ceil(stride.into()));
        let end = (next + binned * usize::from(stride)).min(part.count);
        let run = run_of(part, primitives).get(next..end).unwrap_or_default();
        self.binned.add_all(run, stride, &bins);
        if end < part.count {
            return Task::Bin { part, bins, next: end };
        }
        match self.binned.best_plane(stride) {
            Some(plane) => Task::Partition { part, partition: Partition::new(&bins, &plane) },
            None => measure(part, part.count / 2),
        }
    }

    /// The first task above a half that is sorted, whose table is given: of the second half, or of what is above both.
    fn go_on_above(
        &mut self,
        mut open: OpenSplit,
        forest: Forest,
        primitives: &mut [Primitive],
        splits: &mut [BinarySplit],
        looks: &mut usize,
    ) -> Task {
        let at = open.from + open.length;
        match open.half {
            Half::First(bounds) => {
                let (count, depth) = (open.count - open.length, open.depth + 1);
                open.half = Half::Second(forest);
                let pushed = self.above.try_push(open).is_ok();
                debug_assert!(pushed, "it was just there");
                let second = PrimitiveRun { from: at, count, depth, bounds };
                self.begin(second, primitives, splits, looks)
            }
            Half::Second(first) => {
                let (mut both, split) = Forest::join(&first, &forest, at as u32, open.half_area);
                both.steps += open.count as u64;
                put(splits, at, split);
                Task::Join(both)
            }
        }
    }
}

/// Takes up to `wanted` looks.
fn take(looks: &mut usize, wanted: usize) -> usize {
    let taken = wanted.min(*looks);
    *looks -= taken;
    taken
}

/// The primitives of a part.
fn run_of(part: PrimitiveRun, primitives: &mut [Primitive]) -> &mut [Primitive] {
    primitives.get_mut(part.from..part.from + part.count).unwrap_or_default()
}

/// The task that computes the bounds of two sides.
fn measure(part: PrimitiveRun, length: usize) -> Task {
    Task::Measure { part, length, next: 0, sides: [PrimitiveBounds::EMPTY; 2] }
}
