//! Contract between the traversal and the forms in which nodes and leaves are written.

use core::ops::ControlFlow;

use super::rows::{EMPTY, Row};
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::query::{Query, TriangleId};
use crate::simd::Lanes;

/// Tree of nodes of up to eight boxes, and of leaves of up to eight triangles.
pub(crate) trait Tree: Copy {
    /// The node or leaf where a traversal begins.
    fn root(self) -> Step;

    /// The largest absolute value of any triangle's coordinates.
    fn largest(self) -> f32;

    /// Calls `show` with each child of a node and its lane, until it breaks.
    fn for_each_child(
        self,
        link: u32,
        show: impl FnMut(usize, Step, Aabb) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// Shows the query the triangles of a leaf, without a filter, and counts them.
    fn decide_leaf<Q: Query>(self, step: Step, query: &mut Q) -> ControlFlow<()>;
}

/// Tree that can be read by the lanes `L`.
// Some methods are for the wavefront, which other targets have not.
#[cfg_attr(not(all(target_arch = "x86_64", target_feature = "sse2")), allow(dead_code))]
pub(crate) trait InLanes<L: Lanes>: Tree {
    /// Tests the boxes of a node; see [`Lanes::meet_boxes`]. `None` for a link that leads nowhere.
    fn meet_node(self, link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys>;

    /// The child in one lane of a node.
    fn child(self, link: u32, lane: usize) -> Option<Step>;

    /// Tests the triangles of a leaf: counts all, and lets the query judge those that the ray may hit up to `last`.
    fn test_leaf<Q: Query>(
        self,
        step: Step,
        ray: &LaneRay,
        last: f32,
        query: &mut Q,
    ) -> ControlFlow<()>;

    /// The links of all children of a node, by lane.
    fn links(self, link: u32) -> Option<Row>;

    /// Prefetches what a leaf names.
    #[inline(always)]
    fn prefetch_named(self, _: Step) {}

    /// Filters the triangles of a leaf, or of its first part: those that the ray may hit up to `last`. The bits are the
    /// lanes of the triangles.
    fn filter_leaf<Q: Query>(self, step: Step, ray: &LaneRay, last: f32) -> Candidates;

    /// The triangle in one lane of a leaf, or of its first part.
    fn triangle(self, step: Step, lane: usize) -> (TriangleId, Triangle);

    /// What is left of a leaf after its first part.
    #[inline(always)]
    fn rest_of_leaf(self, _: Step) -> Option<Step> {
        None
    }

    /// Prefetches what a link leads to.
    #[inline(always)]
    fn prefetch(self, _: u32) {}
}

/// Node or leaf to be entered.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    /// The link; to a leaf if [`LEAF_BIT`](super::rows::LEAF) is set.
    pub link: u32,
    /// Leaf metadata kept in the parent (longest edge and first lane; see `rows`), or 0 if the format has none.
    pub edge: u32,
}

impl Step {
    /// The step to nothing.
    pub const NOWHERE: Self = Self { link: EMPTY, edge: 0 };
}
