//! Reader of the wide BVH's rows, for the traversal.

use core::ops::ControlFlow;

use crate::Vec3;
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::indices::wide::rows::{
    EDGES_ROW, EMPTY, EMPTY_LEAF, IDS_ROW, LANES, LEAF_ROWS, LINKS_ROW, ROW_MASK, Row, first_lane,
    leaf_at, leaf_count, node_at, triangle_at,
};
use crate::indices::wide::tree::{InLanes, Step, Tree};
use crate::query::{Query, TriangleId};
use crate::simd::{Lanes, decide_each};

/// Wide BVH: its rows, and the contents of its head.
#[derive(Clone, Copy)]
pub(crate) struct WideTree<'a> {
    pub rows: &'a [Row],
    root: Step,
    largest: f32,
}

impl<'a> WideTree<'a> {
    /// Casts words to rows. If the words are no whole rows, there are none, and nothing is hit.
    #[inline]
    pub fn of(words: &'a [u32]) -> Self {
        let rows: &[Row] = bytemuck::try_cast_slice(words).unwrap_or(&[]);
        let &[link, edge, largest, ..] = rows.first().unwrap_or(&[EMPTY, 0, 0, 0, 0, 0, 0, 0]);
        let root = Step { link, edge };
        Self { rows, root, largest: f32::from_bits(largest) }
    }
}

impl Tree for WideTree<'_> {
    #[inline(always)]
    fn root(self) -> Step {
        self.root
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        self.largest
    }

    fn for_each_child(
        self,
        link: u32,
        mut show: impl FnMut(usize, Step, Aabb) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some(node) = node_at(self.rows, link) else { return ControlFlow::Continue(()) };
        for (lane, (&link, &edge)) in node[LINKS_ROW].iter().zip(&node[EDGES_ROW]).enumerate() {
            let number = |row: usize| f32::from_bits(node[row][lane]);
            let lo = Vec3::new(number(0), number(2), number(4));
            let hi = Vec3::new(number(1), number(3), number(5));
            if link != EMPTY {
                show(lane, Step { link, edge }, Aabb::new(lo, hi))?;
            }
        }
        ControlFlow::Continue(())
    }

    fn decide_leaf<Q: Query>(self, step: Step, query: &mut Q) -> ControlFlow<()> {
        let Some(leaf) = leaf_at(self.rows, step.link) else { return ControlFlow::Continue(()) };
        let (first, count) = (first_lane(step.edge), leaf_count(step.link));
        query.count_tests(count);
        for lane in (first..first + count).map(|lane| lane as usize % LANES) {
            query.decide(TriangleId(leaf[IDS_ROW][lane]), &triangle_at(leaf, lane))?;
        }
        ControlFlow::Continue(())
    }
}

impl<L: Lanes> InLanes<L> for WideTree<'_> {
    #[inline(always)]
    fn meet_node(self, link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys> {
        Some(L::meet_boxes(node_at(self.rows, link)?, ray, last))
    }

    #[inline(always)]
    fn child(self, link: u32, lane: usize) -> Option<Step> {
        let node = node_at(self.rows, link)?;
        let lane = lane % LANES;
        Some(Step { link: node[LINKS_ROW][lane], edge: node[EDGES_ROW][lane] })
    }

    #[inline(always)]
    fn test_leaf<Q: Query>(
        self,
        step: Step,
        ray: &LaneRay,
        last: f32,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let Some(leaf) = leaf_at(self.rows, step.link) else { return ControlFlow::Continue(()) };
        let count = leaf_count(step.link);
        query.count_tests(count);
        let edges = L::all(f32::from_bits(step.edge));
        let lanes = ((1 << count) - 1) << first_lane(step.edge);
        let candidates = L::meet_triangles::<Q>(leaf, ray, edges, last).of(lanes, query)?;
        let triangle = |lane| (TriangleId(leaf[IDS_ROW][lane]), triangle_at(leaf, lane));
        decide_each::<L, Q>(candidates, ray, query, triangle)
    }

    #[inline(always)]
    fn links(self, link: u32) -> Option<Row> {
        Some(node_at(self.rows, link)?[LINKS_ROW])
    }

    #[inline(always)]
    fn filter_leaf<Q: Query>(self, step: Step, ray: &LaneRay, last: f32) -> Candidates {
        let Some(leaf) = leaf_at(self.rows, step.link) else { return Candidates::NONE };
        let edges = L::all(f32::from_bits(step.edge));
        let lanes = ((1 << leaf_count(step.link)) - 1) << first_lane(step.edge);
        L::meet_triangles::<Q>(leaf, ray, edges, last).within(lanes)
    }

    #[inline(always)]
    fn triangle(self, step: Step, lane: usize) -> (TriangleId, Triangle) {
        let leaf = leaf_at(self.rows, step.link).unwrap_or(&EMPTY_LEAF);
        (TriangleId(leaf[IDS_ROW][lane % LANES]), triangle_at(leaf, lane))
    }

    #[inline(always)]
    fn prefetch(self, link: u32) {
        // The lines of a leaf; a node has one less.
        L::prefetch(self.rows, (link & ROW_MASK) as usize, LEAF_ROWS as usize / 2);
    }
}
