//! The rows, as a walk reads them.

use core::ops::ControlFlow;

use super::lanes::{Candidates, LaneRay, Lanes};
use super::portable::Portable;
use super::walk::{InLanes, Step, Tree};
use super::{
    EDGES_ROW, EMPTY, IDS_ROW, LINKS_ROW, Leaf, Row, leaf_at, leaf_count, node_at, triangle_at,
};
use crate::geometry::Aabb;
use crate::geometry::kernel::Verdict;
use crate::query::{Query, TriangleId};
use crate::{Triangle, Vec3};

/// The rows, and what their head says.
#[derive(Clone, Copy)]
pub(in crate::indices) struct WideTree<'a> {
    pub rows: &'a [Row],
    root: Step,
    largest: f32,
}

impl<'a> WideTree<'a> {
    /// The rows of some words; none where they are not whole, and nothing is to be hit.
    #[inline]
    pub fn of(words: &'a [u32]) -> Self {
        let rows: &[Row] = bytemuck::try_cast_slice(words).unwrap_or(&[]);
        let &[link, edge, largest, ..] = rows.first().unwrap_or(&[EMPTY, 0, 0, 0, 0, 0, 0, 0]);
        let root = Step { link, edge: f32::from_bits(edge) };
        Self { rows, root, largest: f32::from_bits(largest) }
    }

    /// Counts the triangles of a leaf, and decides about those that `candidates` names.
    #[inline(always)]
    fn decide<L: Lanes, Q: Query>(
        self,
        link: u32,
        query: &mut Q,
        candidates: impl FnOnce(&Leaf) -> Candidates,
        judge: impl Fn(&Triangle, f32) -> Verdict,
    ) -> ControlFlow<()> {
        let Some(leaf) = leaf_at(self.rows, link) else { return ControlFlow::Continue(()) };
        let count = leaf_count(link);
        query.count_tests(count);
        let triangle = |lane| (TriangleId(leaf[IDS_ROW][lane]), triangle_at(leaf, lane));
        let candidates = candidates(leaf).of(count as usize, query)?;
        L::decide_each(candidates, query, triangle, judge)
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

    fn for_each_child(self, link: u32, mut show: impl FnMut(u32, Aabb)) {
        let Some(node) = node_at(self.rows, link) else { return };
        for (lane, &child) in node[LINKS_ROW].iter().enumerate() {
            let number = |row: usize| f32::from_bits(node[row][lane]);
            let lo = Vec3::new(number(0), number(2), number(4));
            let hi = Vec3::new(number(1), number(3), number(5));
            if child != EMPTY {
                show(child, Aabb::new(lo, hi));
            }
        }
    }

    fn decide_leaf<Q: Query>(self, link: u32, query: &mut Q) -> ControlFlow<()> {
        self.decide::<Portable, _>(link, query, |_| Candidates::ALL, |_, _| Verdict::InDoubt)
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
        Some(Step { link: node[LINKS_ROW][lane], edge: f32::from_bits(node[EDGES_ROW][lane]) })
    }

    #[inline(always)]
    fn test_leaf<Q: Query>(
        self,
        step: Step,
        ray: &LaneRay,
        last: f32,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let candidates = |leaf: &Leaf| L::meet_triangles::<Q>(leaf, ray, L::all(step.edge), last);
        self.decide::<L, _>(step.link, query, candidates, |triangle, last| {
            L::judge(triangle, ray, last)
        })
    }

    #[inline(always)]
    fn prefetch(self, link: u32) {
        L::prefetch(self.rows, link);
    }
}
