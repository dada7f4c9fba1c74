//! The wide BVH: a BVH8 in `f32`, nodes of up to eight boxes over leaves of up to eight triangles.
//!
//! ```text
//! words:  rows of eight words: head | upper nodes, breadth first | what is below them, each depth first
//! head:   link of the root, its edge, the largest coordinate, rows of upper nodes, zeros | zeros
//! node:   lo.x[8] | hi.x[8] | lo.y[8] | hi.y[8] | lo.z[8] | hi.z[8] | links[8] | edges[8]
//! leaf:   a.x[8] | a.y[8] | a.z[8] | b.x[8] | ... | c.z[8] | ids[8], of one child of a node or of several
//! link:   leaf bit | triangles - 1 (3 bits) | row (28 bits); 0 for no child
//! edge:   of a leaf, the largest component of its triangles' edges at corner a, or more; in the last 3 bits the
//!         lane of its first triangle
//! ```
//! - Each triangle lies in one leaf, and nowhere else: the index has no other copy.
//! - Nodes come from the binned surface-area heuristic (SAH), whose binary splits are collapsed: up to seven splits
//!   make a node. They are an octant split where all three axes pay. An axis is left alone, or split twice, where that
//!   pays more.
//! - The cluster tree is collapsed into the same nodes: a join of clusters is split into the two that were joined.
//! - A lane without a child has an empty box. Nodes and leaves begin at multiples of 64 bytes.
//! - Boxes and triangles are tested in `f32` with derived margins (see `simd::lanes`). The exact kernel decides
//!   whatever a margin cannot exclude.
//!
//! # What lost
//! - Splitting leaves of up to eight where their triangles lie apart, before leaves shared rows: 2% fewer instructions
//!   in a city for 14 bytes more a triangle, and no difference elsewhere.
//! - Leaves of up to four triangles, with leaf rows of four lanes instead of eight: 66 bytes a triangle in figure 3,
//!   where sharing rows takes 51, and 2 to 5% more instructions for addresses.
//! - Sorting a batch by octant and by the Morton code of the origins: rays of photons are up to a fifth faster then,
//!   but sorting takes as long as asking.
//! - Other orders of the rows: see `emit`.
//! - A first try of what became `wavefront`: 16 rays of a batch in queues by their next step (nodes, leaves, ends), with no branch in between. By simulation, a
//!   quarter fewer branch mispredictions, but a third more instructions and 0.55 to 0.8 of the speed, because the next
//!   step waits for the queue.
//! - Three, six or eight rays in turn instead of four, and a prefetch of half a node: no difference that stands out.
//! - Sixteen lanes: counted on splits collapsed further, a ray enters 10 to 17% fewer nodes, each of which is twice the
//!   work in AVX2. In AVX-512, registers of sixteen numbers have not paid so far: see `dispatch`.
//! - Cutting triangles in two before the build where they leave most of their boxes empty, 5 to 60% more of them: a ray
//!   enters up to 9% more nodes, a quarter more in a city, for at most 4% fewer tests, and no scene was faster.
//!   Embree's spatial splits make it 0.85 to 1.05 times as fast on the same scenes and rays, and its build 3 to 8 times
//!   as slow.
//!
//! # Source
//! H. Dammertz, J. Hanika, A. Keller, *Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of
//! Incoherent Rays*, 2008; I. Wald, C. Benthin, S. Boulos, *Getting Rid of Packets*, 2008.

mod check;
mod emit;
mod plan;
mod reader;
mod slices;

use reader::WideTree;
pub(crate) use slices::{SliceError, SlicedWords, Unsorted};

use super::dispatch;
use crate::error::BuildError;
use crate::input::{Executor, Options, SimdLevel};
use crate::memory::Words;
use crate::query::{BatchQuery, Hit, Query};
use crate::structure::{Described, DividedScene, Sections, Statistics, Structure, Weights};

/// Wide BVH: a BVH8 in `f32`, over the whole scene or, in a hierarchy, over its clusters. 50 to 55 bytes a triangle.
///
/// It holds the triangles, so it cannot lie [beside](crate::Scene::beside) a mesh.
pub enum WideBvh {}

/// Number of rows of the head.
pub(crate) const HEAD_ROWS: u32 = 2;

impl Described for WideBvh {
    const NAME: &'static str = "wide-bvh";
    const HIERARCHY_NAME: &'static str = "wide-bvh-hierarchy";
    const FORMAT: u32 = 9;
    const WEIGHTS: Weights = Weights { ray: 2.3, node: 9.5, test: 4.9 }; // +-9%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 65_300.0, node: 8_025.0, test: 1_942.0 }; // +-1%
}

impl Structure for WideBvh {
    const HOLDS_TRIANGLES: bool = true;

    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        super::scratch_bytes(triangle_count, options)
    }

    fn build(
        division: DividedScene<'_>,
        _: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<(), BuildError> {
        emit::build(division, words, scratch, executor)
    }

    #[inline]
    fn traverse<Q: Query>(sections: &Sections<'_>, simd_level: SimdLevel, query: &mut Q) {
        if !sections.words().is_empty() {
            dispatch::traverse(WideTree::of(sections.words()), simd_level, query);
        }
    }

    #[inline]
    fn traverse_each<Q: BatchQuery>(
        sections: &Sections<'_>,
        simd_level: SimdLevel,
        scratch: &mut [u8],
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        finish: impl FnMut(usize, Hit),
    ) {
        let tree = WideTree::of(sections.words());
        dispatch::traverse_each(tree, simd_level, scratch, count, start, finish);
    }

    fn check(sections: &Sections<'_>) -> Result<Statistics, u32> {
        check::check(sections).ok_or(0)
    }
}
