//! Reader of the quantised indices' words, for the traversal of the wide BVH.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use super::views::Unpack;
use super::{EMPTY, Form};
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::indices::wide::rows::{LANES, Row};
use crate::indices::wide::tree::{InLanes, Step, Tree};
use crate::input::Mesh;
use crate::query::{Query, TriangleId};
use crate::structure::Sections;

/// Quantised index: its words, and the triangles that they name unless they hold them.
#[derive(Clone, Copy)]
pub(super) struct Packed<'a, F> {
    pub words: &'a [u32],
    /// The sections, for the triangles. By reference, because a mesh in this struct would be copied at every leaf.
    sections: &'a Sections<'a>,
    leaves: PhantomData<F>,
}

impl<'a, F> Packed<'a, F> {
    #[inline]
    pub fn of(sections: &'a Sections<'a>) -> Self {
        Self { words: sections.words(), sections, leaves: PhantomData }
    }

    #[inline(always)]
    pub fn triangles(&self) -> &'a Mesh<'a> {
        self.sections.mesh()
    }
}

impl<'a, F: Form> Tree for Packed<'a, F> {
    type Bundle = F::Bundle<'a>;

    #[inline(always)]
    fn root(self) -> Step {
        Step { link: self.words.first().copied().unwrap_or(EMPTY), edge: 0 }
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        self.words.get(1).map_or(0.0, |&bits| f32::from_bits(bits))
    }

    fn for_each_child(
        self,
        link: u32,
        mut show: impl FnMut(usize, Step, Aabb) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        for lane in 0..LANES {
            let child = F::child(self.words, link, lane);
            if let (Some(link), Some(bounds)) = (child, F::box_at(self.words, link, lane)) {
                show(lane, Step { link, edge: 0 }, bounds)?;
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn first_bundle(self, leaf: Step) -> Option<Self::Bundle> {
        F::first_bundle(self, leaf.link)
    }

    #[inline(always)]
    fn next_bundle(self, bundle: Self::Bundle) -> Option<Self::Bundle> {
        F::next_bundle(self, bundle)
    }

    #[inline(always)]
    fn lanes(self, bundle: Self::Bundle) -> u32 {
        F::lanes(bundle)
    }

    #[inline(always)]
    fn triangle(self, bundle: Self::Bundle, lane: usize) -> (TriangleId, Triangle) {
        F::triangle(bundle, lane)
    }
}

impl<L: Unpack, F: Form> InLanes<L> for Packed<'_, F> {
    #[inline(always)]
    fn meet_node(self, link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys> {
        F::meet_node::<L>(self.words, link, ray, last)
    }

    #[inline(always)]
    fn child(self, link: u32, lane: usize) -> Option<Step> {
        Some(Step { link: F::child(self.words, link, lane)?, edge: 0 })
    }

    #[inline(always)]
    fn links(&self, link: u32) -> Option<&Row> {
        F::links(self.words, link)
    }

    #[inline(always)]
    fn prefetch(self, link: u32) {
        // The lines in which a node may lie, and most leaves.
        L::prefetch(self.words, (link & F::OFFSET) as usize, F::LINES);
    }

    #[inline(always)]
    fn prefetch_triangles(self, bundle: Self::Bundle) {
        F::prefetch_triangles::<L>(bundle);
    }

    #[inline(always)]
    fn filter<Q: Query>(self, bundle: Self::Bundle, ray: &LaneRay, last: f32) -> Candidates {
        F::filter::<L, Q>(bundle, ray, last)
    }
}
