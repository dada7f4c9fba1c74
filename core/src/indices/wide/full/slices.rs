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
    /// The table of all primitives, once they are sorted.
    forest: Option<Forest>,
    planner: Planner,
    stage: Stage,
}

/// Memory and limit of a build. It is small: a [`SlicedWords`] is made where it stays, from this.
pub(crate) struct Unsorted<'s> {
    primitives: &'s mut [Primitive],
    splits: &'s mut [BinarySplit],
    work_limit: u64,
}

/// Stage of the build: the work that the next slice begins with. Those after the first are the phases of `emit`.
#[derive(Clone, Copy)]
enum Stage {
    Sort,
    Plan,
    /// Write what is below the upper node of this number.
    Below(usize),
    /// Join the boxes of the upper nodes before this one.
    Join(usize),
    Done,
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
    pub fn prepare(
        count: usize,
        mut scratch: Arena<'s>,
        work_limit: u64,
    ) -> Result<Option<Unsorted<'s>>, BuildError> {
        check_count(count)?;
        Words::limited(&mut [], work_limit).spend(least_steps(count))?;
        let (Some(primitives), Some(splits)) = (scratch.take(count), scratch.take(count)) else {
            return Ok(None);
        };
        Ok(Some(Unsorted { primitives, splits, work_limit }))
    }

    /// A build that has done nothing yet.
    pub fn of(unsorted: Unsorted<'s>) -> Self {
        let Unsorted { primitives, splits, work_limit } = unsorted;
        let stage = if primitives.is_empty() { Stage::Done } else { Stage::Sort };
        let (sort, planner) = (SlicedSort::new(), Planner::default());
        Self { primitives, splits, work_limit, sort, forest: None, planner, stage }
    }

    /// The box of the scene, once all is sorted.
    pub fn bounds(&self) -> Aabb {
        self.sort.bounds().bounds.aabb()
    }

    /// The number of words, once they are written; `None` before.
    pub fn word_count(&self) -> Option<usize> {
        let Stage::Done = self.stage else { return None };
        Some(self.root().map_or(0, |root| word_count(&root)))
    }

    /// The subtree of all primitives, once they are sorted.
    fn root(&self) -> Option<Subtree<'_>> {
        let forest = self.forest.as_ref()?;
        Some(Subtree::root(self.primitives, self.splits, forest))
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
            self.stage = match self.stage {
                Stage::Done => return Ok(()),
                Stage::Sort => {
                    let sorted = self.sort.go_on(triangles, self.primitives, self.splits, looks);
                    let Some(forest) = sorted else { return Ok(()) };
                    Words::limited(&mut [], self.work_limit).spend(forest.steps)?;
                    self.forest = Some(forest);
                    Stage::Plan
                }
                stage => self.emit(stage, triangles, slots, looks)?,
            };
        }
        Ok(())
    }

    /// Does some of a stage of the second pass, and returns what is done next.
    fn emit(
        &mut self,
        stage: Stage,
        triangles: Mesh<'_>,
        slots: &mut [u32],
        looks: &mut usize,
    ) -> Result<Stage, SliceError> {
        let Some(forest) = &self.forest else { return Ok(Stage::Sort) };
        let root = Subtree::root(self.primitives, self.splits, forest);
        let needed = word_count(&root);
        let full = || SliceError::Words(needed);
        let words = slots.get_mut(..needed).ok_or_else(full)?;
        let rows: &mut [Row] = bytemuck::try_cast_slice_mut(words).unwrap_or_default();
        let (head, rows) = rows.split_first_chunk_mut().ok_or_else(full)?;
        let most_nodes = looks.div_ceil(LOOKS_PER_NODE);
        if let Stage::Plan = stage {
            let before = self.planner.planned();
            let is_planned = self.planner.go_on(rows, root, most_nodes);
            let planned = self.planner.planned() - before;
            *looks = looks.saturating_sub(planned * LOOKS_PER_NODE);
            return Ok(if is_planned { Stage::Below(0) } else { Stage::Plan });
        }
        let writer = Writer::new(triangles, root, &self.planner, &Sequential);
        Ok(match stage {
            Stage::Below(at) => match writer.below_one(rows, at) {
                Some(written) => {
                    *looks = looks.saturating_sub(written.max(1));
                    Stage::Below(at + 1)
                }
                None => Stage::Join(self.planner.planned()),
            },
            Stage::Join(end) => {
                let start = writer.join_some(rows, end, most_nodes);
                *looks = looks.saturating_sub((end - start) * LOOKS_PER_NODE);
                if start > 0 {
                    Stage::Join(start)
                } else {
                    writer.finish(self.sort.bounds().bounds.largest_coordinate(), head, rows);
                    Stage::Done
                }
            }
            other => other,
        })
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
