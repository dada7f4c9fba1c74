//! Contract between the traversal and the forms in which nodes and leaves are written.

use core::ops::ControlFlow;

use super::rows::{EMPTY, LANES, Row};
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::query::{Query, TriangleId};
use crate::simd::{Lanes, decide_each, last_t};

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

    /// Up to eight triangles of a leaf, which are tested at once. Most leaves have one bundle.
    type Bundle: Copy;

    /// The first bundle of a leaf; `None` for a link that leads nowhere.
    fn first_bundle(self, leaf: Step) -> Option<Self::Bundle>;

    /// The next bundle of the same leaf.
    #[inline(always)]
    fn next_bundle(self, _: Self::Bundle) -> Option<Self::Bundle> {
        None
    }

    /// The lanes of a bundle that hold triangles, one bit each.
    fn lanes(self, bundle: Self::Bundle) -> u32;

    /// The triangle in one lane of a bundle.
    fn triangle(self, bundle: Self::Bundle, lane: usize) -> (TriangleId, Triangle);

    /// Shows the query the triangles of a leaf, without a filter, and counts them.
    fn decide_leaf<Q: Query>(self, leaf: Step, query: &mut Q) -> ControlFlow<()> {
        let mut next = self.first_bundle(leaf);
        while let Some(bundle) = next {
            let lanes = self.lanes(bundle);
            query.count_tests(lanes.count_ones());
            for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
                let (id, triangle) = self.triangle(bundle, lane);
                query.decide(id, &triangle)?;
            }
            next = self.next_bundle(bundle);
        }
        ControlFlow::Continue(())
    }
}

/// Tree that can be read by the lanes `L`.
// Some methods are for the wavefront, which other targets have not.
#[cfg_attr(not(all(target_arch = "x86_64", target_feature = "sse2")), allow(dead_code))]
pub(crate) trait InLanes<L: Lanes>: Tree {
    /// Tests the boxes of a node; see [`Lanes::meet_boxes`]. `None` for a link that leads nowhere.
    fn meet_node(self, link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys>;

    /// The child in one lane of a node.
    fn child(self, link: u32, lane: usize) -> Option<Step>;

    /// Filters the triangles of a bundle: those that the ray may hit up to `last`. The bits of unused lanes are
    /// arbitrary.
    fn filter<Q: Query>(self, bundle: Self::Bundle, ray: &LaneRay, last: f32) -> Candidates;

    /// Tests the triangles of a leaf: counts all, and lets the query judge those that the ray may hit.
    #[inline(always)]
    fn test_leaf<Q: Query>(self, leaf: Step, ray: &LaneRay, query: &mut Q) -> ControlFlow<()> {
        let Some(mut bundle) = self.first_bundle(leaf) else { return ControlFlow::Continue(()) };
        loop {
            let lanes = self.lanes(bundle);
            query.count_tests(lanes.count_ones());
            let candidates =
                self.filter::<Q>(bundle, ray, last_t(query)).within(lanes).of(query)?;
            // A triangle is read once more, because few are candidates, and rows kept for them would cost more.
            decide_each::<L, Q>(candidates, ray, query, |lane| self.triangle(bundle, lane))?;
            match self.next_bundle(bundle) {
                Some(next) => bundle = next,
                None => return ControlFlow::Continue(()),
            }
        }
    }

    /// The links of all children of a node, by lane. Not copied, so that one of them can be read without the others.
    fn links(&self, link: u32) -> Option<&Row>;

    /// Prefetches the triangles that a bundle names, if they lie elsewhere.
    #[inline(always)]
    fn prefetch_triangles(self, _: Self::Bundle) {}

    /// Prefetches what a link leads to.
    #[inline(always)]
    fn prefetch(self, _: u32) {}

    /// As [`prefetch`](Self::prefetch), where the form can with no line too many, for a few instructions more.
    #[inline(always)]
    fn prefetch_exactly(self, link: u32) {
        self.prefetch(link);
    }
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
