//! The contract between a traversal and the form in which nodes and leaves are written down.

// Forced, because the traversal must be compiled for the instructions of its lanes, not called from there.
#![allow(clippy::inline_always)]

use core::ops::ControlFlow;

use super::rows::{EMPTY, LANES};
use super::simd::{LaneRay, Lanes};
use crate::geometry::kernel::Verdict;
use crate::geometry::{Aabb, Triangle};
use crate::query::{Query, TriangleId};

/// A tree of nodes of up to eight boxes, and of leaves.
pub(crate) trait Tree: Copy {
    /// Where a walk begins.
    fn root(self) -> Step;

    /// The largest coordinate of any triangle.
    fn largest(self) -> f32;

    /// Shows the children of a node, each with its lane, until `show` breaks.
    fn for_each_child(
        self,
        link: u32,
        show: impl FnMut(usize, Step, Aabb) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// Shows the triangles of a leaf, and counts them.
    fn decide_leaf<Q: Query>(self, step: Step, query: &mut Q) -> ControlFlow<()>;
}

/// A tree that can be read in lanes.
pub(crate) trait InLanes<L: Lanes>: Tree {
    /// As [`Lanes::meet_boxes`]; `None` for a link that leads nowhere.
    fn meet_node(self, link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys>;

    /// The child in one lane of a node.
    fn child(self, link: u32, lane: usize) -> Option<Step>;

    /// Decides about the triangles of a leaf that the ray may hit up to `last`, and counts all.
    fn test_leaf<Q: Query>(
        self,
        step: Step,
        ray: &LaneRay,
        last: f32,
        query: &mut Q,
    ) -> ControlFlow<()>;

    /// Asks the memory for what a link leads to.
    #[inline(always)]
    fn prefetch(self, _: u32) {}
}

/// A node or a leaf to be entered.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    /// Where it is; a leaf where [`LEAF`] is set.
    pub link: u32,
    /// What a node has to say of a leaf, if it does.
    pub edge: u32,
}

impl Step {
    /// Nothing to be entered.
    pub const NOWHERE: Self = Self { link: EMPTY, edge: 0 };
}

/// A query's last `t` as lanes compare with it. Read anew for each node: kept in the walk, compilers load it in one
/// with its neighbours, and the processor waits until they are all written.
#[inline(always)]
pub(crate) fn last_t<Q: Query>(query: &Q) -> f32 {
    let t = query.last_t();
    if t < f32::MAX { t } else { f32::MAX }
}

/// Decides about the triangles of which a bit is set; [`Lanes::judge`] is asked first.
#[inline(always)]
pub(crate) fn decide_each<L: Lanes, Q: Query>(
    mut candidates: u32,
    ray: &LaneRay,
    query: &mut Q,
    triangle: impl Fn(usize) -> (TriangleId, Triangle),
) -> ControlFlow<()> {
    while candidates != 0 {
        let lane = candidates.trailing_zeros() as usize % LANES;
        candidates &= candidates - 1;
        let (id, corners) = triangle(lane);
        match L::judge(&corners, ray, query.last_t()) {
            Verdict::Missed => {}
            Verdict::Hit(hit) => query.accept(id, hit)?,
            // Read once more: kept until here, the corners of every triangle would be written to the stack.
            doubt => query.judge(id, &triangle(lane).1, doubt)?,
        }
    }
    ControlFlow::Continue(())
}
