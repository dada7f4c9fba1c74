//! BVH8 with boxes quantised to 16 bits a side: the compact BVH, and the lean BVH beside a mesh.
//!
//! ```text
//! words:  link of the root, the largest coordinate | nodes and leaves, depth first, the root first | zeros
//! node:   x.lo[8] x.hi[8] y.lo[8] ... z.hi[8], 16 bits each | anchor.xyz | step.xyz | links[8]
//! ```
//! - Of a node, the lean BVH stores only what its children need: see `ids`.
//! - The leaves of the compact BVH hold the triangles: see `chunks`.
//! - The tree is that of the wide BVH, and so are traversal and triangle tests. Only the form of nodes and leaves
//!   differs.
//! - The planes of a node's boxes are `anchor + q * step`, `q` a number of 16 bits. They are rounded outwards, and kept
//!   where they can be: see `node`. Eight planes are unpacked at once.
//! - An unused lane has a link past the end.
//!
//! # Measured
//! AVX-512 instead of AVX2, Zen 4, speed in figure 4(b), city and mesh:
//!
//! | | batch | any hit, batch | single |
//! |---|---|---|---|
//! | compact BVH | 1.03, 1.01, 1.08 | 1.03, 1.07, 1.10 | 1.01, 1.01, 1.02 |
//! | lean BVH | 1.06, 0.99, 1.08 | 1.11, 1.14, 1.11 | 0.99, 1.00, 1.00 |
//!
//! A compiler before Rust 1.95 made gathers of the corners of one triangle, and AVX-512 lost 5 to 8% on Zen 5.
//!
//! # Source
//! C. Benthin, I. Wald, S. Woop, A. Áfra, *Compressed-Leaf Bounding Volume Hierarchies*, 2018, for the idea of
//! quantised nodes over leaves with a vertex table of their own.

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod avx2;
mod chunks;
mod emit;
mod ids;
mod node;
mod reader;
mod views;

use core::marker::PhantomData;

use bytemuck::{Pod, Zeroable};
use chunks::{CHUNK_HEAD, CHUNK_WORDS, Chunk, Chunks, corner_at, vertex_count};
use ids::Ids;
use reader::Packed;
use views::Unpack;

use super::build::MAX_DEPTH;
use super::dispatch::{traverse, traverse_each};
use super::rows::{LANES, Row};
use crate::error::BuildError;
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::indices::depth_first::{self, check_depth_first};
use crate::input::{Executor, Mesh, Options, SimdLevel};
use crate::memory::Words;
use crate::query::{BatchQuery, Hit, Query, TriangleId};
use crate::structure::{Described, DividedScene, Sections, Statistics, Structure};

/// Compact BVH: a BVH8 in 16 bits, over the whole scene or, in a hierarchy, over its clusters. 25 to 30 bytes a
/// triangle, with all that queries need.
///
/// It holds the triangles, so it cannot lie [beside](crate::Scene::beside) a mesh.
pub type CompactBvh = QuantisedBvh<Chunks>;

/// Lean BVH: a BVH8 in 16 bits, over the whole scene or, in a hierarchy, over its clusters.
///
/// It is made to lie [beside](crate::Scene::beside) a mesh that is kept anyway: 7.3 to 9.4 bytes a triangle more on the
/// scenes of the host. On its own it takes 36 bytes a triangle more, for the triangles.
pub type LeanBvh = QuantisedBvh<Ids>;

/// BVH8 of quantised boxes, in the form `F`.
pub struct QuantisedBvh<F>(PhantomData<F>);

/// Form of nodes and leaves. Nodes have two to eight children, leaves one to eight triangles.
// Some functions are for the wavefront, which other targets have not.
#[cfg_attr(not(all(target_arch = "x86_64", target_feature = "sse2")), allow(dead_code))]
trait Form: Copy + 'static {
    /// True if leaves hold the triangles; see [`Structure::HOLDS_TRIANGLES`].
    const HOLDS_TRIANGLES: bool;
    /// The number of zeros at the end of the words, so that nodes and leaves can be read in one piece.
    const ZEROS: usize;
    /// The bits of a link that are an offset.
    const OFFSET: u32;
    /// The number of cache lines to prefetch of what a link leads to.
    const LINES: usize;

    /// Writes a node at the reserved `offset`, and returns the link to it.
    fn write_node(
        node: &QuantisedNode,
        children: usize,
        offset: usize,
        words: &mut Words<'_>,
    ) -> u32;

    /// The number of words of a node with this number of children.
    fn node_words(children: usize) -> usize;

    /// Reads a node, and the number of its words; `None` past the end.
    fn node_at(words: &[u32], link: u32) -> Option<(QuantisedNode, usize)>;

    /// Decodes the box in one lane of a node; `None` for an unused lane.
    fn box_at(words: &[u32], link: u32, lane: usize) -> Option<Aabb>;

    /// Tests the boxes of a node; see [`InLanes::meet_node`](crate::indices::wide::tree::InLanes::meet_node).
    fn meet_node<L: Unpack>(words: &[u32], link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys>;

    /// Reads the link in one lane of a node.
    fn child(words: &[u32], link: u32, lane: usize) -> Option<u32>;

    /// Reads the links of all lanes of a node; those of unused lanes are arbitrary.
    fn links(words: &[u32], link: u32) -> Option<&Row>;

    /// Appends a leaf, and returns the link to it.
    fn write(triangles: Mesh<'_>, ids: impl Iterator<Item = u32>, words: &mut Words<'_>) -> u32;

    /// Up to eight triangles of a leaf; see [`Tree::Bundle`](super::tree::Tree::Bundle).
    type Bundle<'w>: Copy;

    /// Reads the first bundle of a leaf; `None` for a link that leads nowhere.
    fn first_bundle(tree: Packed<'_, Self>, link: u32) -> Option<Self::Bundle<'_>>;

    /// Reads the next bundle of the same leaf.
    #[inline(always)]
    fn next_bundle<'w>(_: Packed<'w, Self>, _: Self::Bundle<'w>) -> Option<Self::Bundle<'w>> {
        None
    }

    /// The lanes of a bundle that hold triangles, one bit each.
    fn lanes(bundle: Self::Bundle<'_>) -> u32;

    /// Reads the triangle in one lane of a bundle.
    fn triangle(bundle: Self::Bundle<'_>, lane: usize) -> (TriangleId, Triangle);

    /// Prefetches the triangles that a bundle names, if they lie elsewhere.
    #[inline(always)]
    fn prefetch_triangles<L: Unpack>(_: Self::Bundle<'_>) {}

    /// Filters the triangles of a bundle; see [`InLanes::filter`](super::tree::InLanes::filter).
    fn filter<L: Unpack, Q: Query>(
        bundle: Self::Bundle<'_>,
        ray: &LaneRay,
        last: f32,
    ) -> Candidates;

    /// Checks a leaf, and returns the numbers of its words and triangles. `None` if reading it could do harm.
    fn check(words: &[u32], link: u32, triangle_count: u32) -> Option<(usize, u32)>;
}

/// Number of words of the head.
const HEAD_WORDS: usize = 2;
/// Number of words of a [`QuantisedNode`].
const NODE_WORDS: usize = 38;
/// The bit of a link that leads to a leaf.
const LEAF_BIT: u32 = 1 << 31;
/// The link of an unused lane: a leaf past the end of the longest index.
const EMPTY: u32 = u32::MAX;

/// Node: eight boxes, and the links to what they hold.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct QuantisedNode {
    /// For each axis the planes of the lower sides, then those of the upper; lane 0 is in the lower half of the first
    /// word.
    planes: [[[u32; 4]; 2]; 3],
    anchor: [f32; 3],
    step: [f32; 3],
    links: [u32; LANES],
}

/// The largest number of words, so that the offset of `EMPTY` lies past the end.
fn most_words<F: Form>() -> usize {
    F::OFFSET as usize - CHUNK_WORDS
}

impl<F: Form> Structure for QuantisedBvh<F>
where
    Self: Described,
{
    const HOLDS_TRIANGLES: bool = F::HOLDS_TRIANGLES;

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
        emit::build::<F>(division, words, scratch, executor)
    }

    #[inline]
    fn traverse<Q: Query>(sections: &Sections<'_>, simd_level: SimdLevel, query: &mut Q) {
        if !sections.words().is_empty() {
            traverse(Packed::<F>::of(sections), simd_level, query);
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
        let tree = Packed::<F>::of(sections);
        traverse_each(tree, simd_level, scratch, count, start, finish);
    }

    fn check(sections: &Sections<'_>) -> Result<Statistics, u32> {
        check::<F>(sections.words(), sections.triangle_count()).ok_or(0)
    }
}

/// Checks the words of a tree that lies in depth-first order.
fn check<F: Form>(words: &[u32], triangle_count: u32) -> Option<Statistics> {
    const MOST: usize = MAX_DEPTH as usize * LANES;
    if triangle_count == 0 {
        return words.is_empty().then_some(Statistics::default());
    }
    if words.len() > most_words::<F>() {
        return None;
    }
    let offset_of = |link| link & F::OFFSET;
    let start = HEAD_WORDS as u32;
    let checked =
        check_depth_first::<MOST>(*words.first()?, start, offset_of, |link, depth, links| {
            if link & LEAF_BIT != 0 {
                let (words, references) = F::check(words, link, triangle_count)?;
                return Some(depth_first::CheckedNode::Leaf { words: words as u32, references });
            }
            let (node, words) = F::node_at(words, link).filter(|_| depth + 1 < MAX_DEPTH)?;
            links.follow(node.links.into_iter().filter(|&child| child != EMPTY))?;
            Some(depth_first::CheckedNode::Inner { words: words as u32 })
        });
    let (statistics, end) = checked?;
    let rest = words.get(end as usize..)?;
    let ends = rest.len() == F::ZEROS && rest.iter().all(|&word| word == 0);
    let all = statistics.references == u64::from(triangle_count);
    (ends && all).then_some(statistics)
}
