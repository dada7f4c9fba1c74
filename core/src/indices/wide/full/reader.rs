//! Reader of the wide BVH's rows, for the traversal.

use core::ops::ControlFlow;

use crate::Vec3;
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::indices::wide::rows::{
    EDGES_ROW, EMPTY, IDS_ROW, LANES, LEAF_BIT, LEAF_ROWS, LINKS_ROW, LeafRows, NODE_ROWS,
    ROW_MASK, Row, first_lane, leaf_at, leaf_count, node_at, triangle_at,
};
use crate::indices::wide::tree::{InLanes, Step, Tree};
use crate::query::{Query, TriangleId};
use crate::simd::Lanes;

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

impl<'a> Tree for WideTree<'a> {
    /// The rows of a leaf, and the step to it.
    type Bundle = (&'a LeafRows, Step);

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

    #[inline(always)]
    fn first_bundle(self, leaf: Step) -> Option<(&'a LeafRows, Step)> {
        Some((leaf_at(self.rows, leaf.link)?, leaf))
    }

    #[inline(always)]
    fn lanes(self, (_, leaf): (&LeafRows, Step)) -> u32 {
        ((1 << leaf_count(leaf.link)) - 1) << first_lane(leaf.edge)
    }

    #[inline(always)]
    fn triangle(self, (rows, _): (&LeafRows, Step), lane: usize) -> (TriangleId, Triangle) {
        (TriangleId(rows[IDS_ROW][lane % LANES]), triangle_at(rows, lane))
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
    fn links(&self, link: u32) -> Option<&Row> {
        Some(&node_at(self.rows, link)?[LINKS_ROW])
    }

    #[inline(always)]
    fn filter<Q: Query>(
        self,
        (rows, leaf): (&LeafRows, Step),
        ray: &LaneRay,
        last: f32,
    ) -> Candidates {
        L::meet_triangles::<Q>(rows, ray, L::all(f32::from_bits(leaf.edge)), last)
    }

    #[inline(always)]
    fn prefetch(self, link: u32) {
        // The lines of a leaf; a node has one less.
        L::prefetch(self.rows, (link & ROW_MASK) as usize, LEAF_ROWS as usize / 2);
    }

    #[inline(always)]
    fn prefetch_exactly(self, link: u32) {
        const LINES: usize = NODE_ROWS as usize / 2;
        let row = (link & ROW_MASK) as usize;
        L::prefetch(self.rows, row, LINES);
        // Of a leaf the fifth line, of a node the fourth again, which is cheaper than a branch.
        L::prefetch(self.rows, row + 2 * (LINES - 1 + usize::from(link & LEAF_BIT != 0)), 1);
    }
}
