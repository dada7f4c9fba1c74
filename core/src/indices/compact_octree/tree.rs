//! The words, as a walk reads them; the walk is that of the wide octree.

use core::ops::ControlFlow;

use super::lanes::Unpack;
use super::{
    Block, EDGE, EMPTY, LEAF, MORE_BLOCKS, block_at, block_length, id_at, node_at, triangle_at,
    triangle_count,
};
use crate::Triangle;
use crate::geometry::Aabb;
use crate::geometry::kernel::Verdict;
use crate::indices::wide_octree::LANES;
use crate::indices::wide_octree::lanes::LaneRay;
use crate::indices::wide_octree::walk::{InLanes, Step, Tree, decide_each, finite};
use crate::query::{Query, TriangleId};

/// The words of an image.
#[derive(Clone, Copy)]
pub(super) struct Packed<'a> {
    pub words: &'a [u32],
}

impl Packed<'_> {
    /// Goes through the blocks of a leaf; `candidates` names some of the triangles of each.
    #[inline(always)]
    fn for_each_block<Q: Query>(
        self,
        link: u32,
        query: &mut Q,
        candidates: impl Fn(&Block, &Q) -> u32,
        judge: impl Fn(&Triangle, f32) -> Verdict,
    ) -> ControlFlow<()> {
        let mut place = (link & !LEAF) as usize;
        // An unused lane has a link past the end.
        while let Some(block) = block_at(self.words, place) {
            let count = triangle_count(block);
            query.count_tests(count as u32);
            let candidates = candidates(block, query) & ((1 << count) - 1);
            let triangle = |lane| (TriangleId(id_at(block, lane)), triangle_at(block, lane));
            decide_each(candidates, query, triangle, &judge)?;
            if block[0] & MORE_BLOCKS == 0 {
                break;
            }
            place += block_length(block);
        }
        ControlFlow::Continue(())
    }
}

impl Tree for Packed<'_> {
    #[inline(always)]
    fn root(self) -> Step {
        Step { link: self.words.first().copied().unwrap_or(EMPTY), edge: 0.0 }
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        self.words.get(1).map_or(0.0, |&bits| f32::from_bits(bits))
    }

    fn for_each_child(self, link: u32, mut show: impl FnMut(u32, Aabb)) {
        let Some(node) = node_at(self.words, link) else { return };
        for (lane, &child) in node.links.iter().enumerate() {
            if child != EMPTY {
                show(child, node.bounds(lane));
            }
        }
    }

    fn decide_leaf<Q: Query>(self, link: u32, query: &mut Q) -> ControlFlow<()> {
        self.for_each_block(link, query, |_, _| u32::MAX, |_, _| Verdict::InDoubt)
    }
}

impl<L: Unpack> InLanes<L> for Packed<'_> {
    #[inline(always)]
    fn meet_node(self, link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys> {
        Some(L::meet_node(node_at(self.words, link)?, ray, last))
    }

    #[inline(always)]
    fn child(self, link: u32, lane: usize) -> Option<Step> {
        Some(Step { link: node_at(self.words, link)?.links[lane % LANES], edge: 0.0 })
    }

    #[inline(always)]
    fn test_leaf<Q: Query>(
        self,
        step: Step,
        ray: &LaneRay,
        _: f32,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let candidates = |block: &Block, query: &Q| {
            let edge = f32::from_bits(block[0] & EDGE);
            L::meet_triangles(&L::unpack(block), ray, edge, finite(query.last_t()))
        };
        let judge = |triangle: &Triangle, last| L::judge(triangle, ray, last);
        self.for_each_block(step.link, query, candidates, judge)
    }
}
