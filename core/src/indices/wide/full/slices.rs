//! Both passes in slices, for those who must not wait for a whole build.

use super::emit::{Writer, check_count, word_count};
use super::plan::Planner;
use crate::error::BuildError;
use crate::geometry::Aabb;
use crate::indices::wide::build::collapse::{BinarySplit, Forest, Subtree};
use crate::indices::wide::build::least_steps;
use crate::indices::wide::build::primitive::Primitive;
use crate::indices::wide::build::slices::SlicedSort;
use crate::indices::wide::rows::Row;
use crate::input::{Mesh, Sequential};
use crate::memory::{Arena, Words, size_of_slice};

/// Looks at a triangle that planning an upper node, or joining its boxes, is worth.
const LOOKS_PER_NODE: usize = 8;

/// Build of the words, as far as it has come.
pub(crate) struct SlicedWords<'s> {
    primitives: &'s mut [Primitive],
    splits: &'s mut [BinarySplit],
    work_limit: u64,
    sort: SlicedSort,
    phase: Phase,
}

/// What is done next.
enum Phase {
    Sort,
    /// The first pass is done; the table of all.
    Plan(Forest, Planner),
    /// Write what is below the upper node.
    Below(Forest, Planner, usize),
    /// Join the boxes of the upper nodes before this one.
    Join(Forest, Planner, usize),
    Done(usize),
}

impl<'s> SlicedWords<'s> {
    /// The scratch bytes of a build.
    pub const fn scratch_bytes(count: usize) -> usize {
        size_of_slice::<Primitive>(count).saturating_add(size_of_slice::<BinarySplit>(count))
    }

    /// Takes the memory of a build. `None` if the scratch is too small.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`], and [`BuildError::TooMuchWork`] if no tree takes so few steps.
    pub fn new(
        count: usize,
        mut scratch: Arena<'s>,
        work_limit: u64,
    ) -> Result<Option<Self>, BuildError> {
        check_count(count)?;
        Words::limited(&mut [], work_limit).spend(least_steps(count))?;
        let (Some(primitives), Some(splits)) = (scratch.take(count), scratch.take(count)) else {
            return Ok(None);
        };
        let phase = if count > 0 { Phase::Sort } else { Phase::Done(0) };
        Ok(Some(Self { primitives, splits, work_limit, sort: SlicedSort::new(), phase }))
    }

    /// The box of the scene, once all is sorted.
    pub fn bounds(&self) -> Aabb {
        self.sort.bounds().bounds.aabb()
    }

    /// The number of words, once they are written; `None` before.
    pub fn word_count(&self) -> Option<usize> {
        match self.phase {
            Phase::Done(count) => Some(count),
            _ => None,
        }
    }

    /// Goes on until the words are written, or no look is left. Takes the looks from `looks`. `slots` are the same
    /// memory each time.
    ///
    /// # Errors
    /// The number of words needed, if there are not as many slots; [`BuildError::TooMuchWork`].
    pub fn go_on(
        &mut self,
        triangles: Mesh<'_>,
        slots: &mut [u32],
        looks: &mut usize,
    ) -> Result<(), SliceError> {
        while *looks > 0 {
            // 1. First pass.
            if matches!(self.phase, Phase::Sort) {
                let sorted = self.sort.go_on(triangles, self.primitives, self.splits, looks);
                let Some(forest) = sorted else { return Ok(()) };
                Words::limited(&mut [], self.work_limit).spend(forest.steps)?;
                self.phase = Phase::Plan(forest, Planner::default());
            }
            let forest = match &self.phase {
                Phase::Plan(forest, _) | Phase::Below(forest, ..) | Phase::Join(forest, ..) => {
                    forest
                }
                Phase::Sort | Phase::Done(_) => return Ok(()),
            };
            // 2. Second pass: the rows behind the head.
            let root = Subtree::root(self.primitives, self.splits, forest);
            let needed = word_count(&root);
            let words = slots.get_mut(..needed).ok_or(SliceError::Words(needed))?;
            let rows: &mut [Row] = bytemuck::try_cast_slice_mut(words).unwrap_or_default();
            let Some((head, rows)) = rows.split_first_chunk_mut() else {
                return Err(SliceError::Words(needed));
            };
            let largest = self.sort.bounds().bounds.largest_coordinate();
            let done = match &mut self.phase {
                Phase::Plan(_, planner) => {
                    let count = looks.div_ceil(LOOKS_PER_NODE);
                    let before = planner.planned();
                    let is_planned = planner.go_on(rows, root, count);
                    *looks = looks.saturating_sub((planner.planned() - before) * LOOKS_PER_NODE);
                    is_planned
                }
                Phase::Below(_, planner, at) => {
                    let writer = Writer::new(triangles, root, planner, &Sequential);
                    let written = writer.below_one(rows, *at);
                    *looks = looks.saturating_sub(written.unwrap_or(0).max(1));
                    *at += 1;
                    written.is_none()
                }
                Phase::Join(_, planner, end) => {
                    let writer = Writer::new(triangles, root, planner, &Sequential);
                    let count = looks.div_ceil(LOOKS_PER_NODE);
                    let start = writer.join_some(rows, *end, count);
                    *looks = looks.saturating_sub((*end - start) * LOOKS_PER_NODE);
                    *end = start;
                    if start == 0 {
                        writer.finish(largest, head, rows);
                    }
                    start == 0
                }
                Phase::Sort | Phase::Done(_) => false,
            };
            if done {
                self.phase = match core::mem::replace(&mut self.phase, Phase::Sort) {
                    Phase::Plan(forest, planner) => Phase::Below(forest, planner, 0),
                    Phase::Below(forest, planner, _) => {
                        let end = planner.planned();
                        Phase::Join(forest, planner, end)
                    }
                    Phase::Join(..) => Phase::Done(needed),
                    other => other,
                };
            }
        }
        Ok(())
    }
}

/// Reason why a build in slices ends early.
pub(crate) enum SliceError {
    /// The number of words needed.
    Words(usize),
    Build(BuildError),
}

impl From<BuildError> for SliceError {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}
