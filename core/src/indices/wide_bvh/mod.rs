//! The wide BVH: nodes of up to eight boxes, tested at once, over leaves of up to eight triangles.
//!
//! ```text
//! words:  rows of eight words: head | upper nodes, breadth first | what is below them, each depth first
//! head:   link of the root, its edge, the largest coordinate, rows of upper nodes, zeros | zeros
//! node:   lo.x[8] | hi.x[8] | lo.y[8] | hi.y[8] | lo.z[8] | hi.z[8] | links[8] | edges[8]
//! leaf:   a.x[8] | a.y[8] | a.z[8] | b.x[8] | ... | c.z[8] | ids[8], of one child of a node or of several
//! link:   leaf bit | triangles - 1 (3 bits) | row (28 bits); 0 for no child
//! edge:   of a leaf, the largest component of its triangles' edges at corner a, or more, and in the last 3 bits the
//!         lane of its first triangle
//! ```
//! Each triangle lies in one leaf, and nowhere else: the image has no other copy. Triangles are divided in two
//! where the estimated tests are fewest, and up to seven divisions make a node: an octant split where all three
//! axes pay, and an axis left alone, or divided twice, where that pays more. The cluster tree is collapsed into
//! the same nodes: as long as a part is a join of clusters, it is divided into the two that were joined. Lanes
//! without a child have an empty box. Nodes and leaves begin at multiples of 64 bytes.
//!
//! Boxes and triangles are tested in `f32` with derived margins (see `lanes`); whatever a margin
//! cannot exclude is decided by the exact kernel.
//!
//! # What lost
//! - Leaves of fewer than eight, where their triangles lie apart: 2% fewer instructions in a city for 14 bytes more a
//!   triangle, when leaves did not share rows, and no difference elsewhere.
//! - Leaves of up to four with rows of four words: 66 bytes a triangle in figure 3, where sharing rows takes 51, and
//!   2 to 5% more instructions for addresses.
//! - Sorting a batch by octant and by the Morton code of the origins: rays of photons are up to a fifth faster then,
//!   but sorting takes as long as asking.
//! - Other orders of the rows: see `write`.
//! - 16 rays of a batch in queues by what they do next, nodes, leaves, ends, with no branch in between: by simulation
//!   a quarter fewer branches mispredicted, but a third more instructions and 0.55 to 0.8 of the speed, because what
//!   comes next waits for the queue.
//! - Three, six or eight rays in turn instead of four, and a prefetch of half a node: no difference that stands out.
//! - Sixteen lanes: counted on divisions collapsed further, a ray enters 10 to 17% fewer nodes, each of which is twice the
//!   work in AVX2. In AVX-512, registers of sixteen numbers have not paid so far: see `avx512`.
//! - Triangles cut in two where they leave most of their boxes empty, before the build, 5 to 60% more of them: a ray enters
//!   up to 9% more nodes, a quarter more in a city, for at most 4% fewer tests, and no scene was faster. Embree's spatial
//!   splits make it 0.85 to 1.05 times as fast on the same scenes and rays, and its build 3 to 8 times as slow.
//!
//! # Source
//! H. Dammertz, J. Hanika, A. Keller, *Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of
//! Incoherent Rays*, 2008; I. Wald, C. Benthin, S. Boulos, *Getting Rid of Packets*, 2008.

// Forced, because the walk must be compiled for the instructions of its lanes, not called from there.
#![allow(clippy::inline_always)]

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(super) mod avx2;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(super) mod avx512;
pub(super) mod build;
mod check;
pub(super) mod collapse;
mod divide;
mod halve;
pub(super) mod item;
pub(super) mod lanes;
pub(super) mod leaf;
pub(super) mod portable;
mod tree;
pub(super) mod walk;
mod write;

use tree::WideTree;

use super::{Division, Statistics, Structure};
use crate::cluster::MAX_TREE_DEPTH;
use crate::memory::{Image, Words};
use crate::query::Query;
use crate::{BuildError, Executor, Options, Vectors};

/// The wide BVH, alone or as the local index of a hierarchy.
pub enum WideBvh {}

/// Eight words; a row of a node or of a leaf.
pub(super) type Row = [u32; LANES];

pub(super) const LANES: usize = 8;
type Node = [Row; NODE_ROWS as usize];

const HEAD_ROWS: u32 = 2;
const NODE_ROWS: u32 = 8;
const LEAF_ROWS: u32 = 10;
const LINKS_ROW: usize = 6;
const EDGES_ROW: usize = 7;
const IDS_ROW: usize = 9;

const LEAF: u32 = 1 << 31;
const ROW_MASK: u32 = (1 << 28) - 1;
const EMPTY: u32 = 0;
/// An unused lane of a leaf.
const NO_ID: u32 = u32::MAX;

/// So many divisions into a cluster, triangles are divided into equal parts, which takes at most 25 more.
const BALANCED_FROM: u32 = 32;
/// The levels of the cluster tree, and those of a cluster: at worst a node for each division.
pub(super) const MAX_DEPTH: u32 = MAX_TREE_DEPTH as u32 + BALANCED_FROM + 27;
/// Each level leaves one entry.
pub(super) const STACK: usize = MAX_DEPTH as usize;

/// The rows of a node.
#[inline]
fn node_at(rows: &[Row], link: u32) -> Option<&Node> {
    let row = (link & ROW_MASK) as usize;
    rows.get(row..row + NODE_ROWS as usize)?.try_into().ok()
}

/// See [`Structure::scratch_bytes`].
pub(super) const fn scratch_bytes(triangle_count: usize, _: &Options) -> usize {
    build::scratch_bytes(triangle_count)
}

impl Structure for WideBvh {
    const NAME: &'static str = "wide-bvh";
    const HIERARCHY_NAME: &'static str = "wide-bvh-hierarchy";
    const KIND: u32 = 9;
    const HOLDS_TRIANGLES: bool = true;

    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        scratch_bytes(triangle_count, options)
    }

    fn build(
        division: Division<'_>,
        _: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<(), BuildError> {
        build::build(division, words, scratch, executor)
    }

    #[inline]
    fn traverse<Q: Query>(image: &Image<'_>, vectors: Vectors, query: &mut Q) {
        if !image.words().is_empty() {
            walk::walk(WideTree::of(image.words()), vectors, query);
        }
    }

    #[inline]
    fn traverse_each<Q: Query>(
        image: &Image<'_>,
        vectors: Vectors,
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        finish: impl FnMut(usize, &Q),
    ) {
        walk::walk_each(WideTree::of(image.words()), vectors, count, start, finish);
    }

    fn check(image: &Image<'_>) -> Result<Statistics, u32> {
        check::check(image).ok_or(0)
    }
}
