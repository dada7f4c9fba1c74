//! The wide BVH in less memory: the compact BVH, and the lean BVH beside a mesh.
//!
//! ```text
//! words:  link of the root, the largest coordinate | nodes and leaves, depth first, the root first | zeros
//! node:   x.lo[8] x.hi[8] y.lo[8] ... z.hi[8], 16 bits each | anchor.xyz | step.xyz | links[8]
//! ```
//! The lean BVH keeps of a node what its children need: see `ids`. Leaves of the compact BVH hold the
//! triangles: see `chunks`.
//!
//! The tree is that of the wide BVH, and so are the walk and the triangle tests. What differs is how nodes
//! and leaves are written down. The planes of a node's boxes are `anchor + q * step`, `q` a number of 16 bits;
//! rounded outwards, and kept where they can be: see `node`. An unused lane has a link past the end. Eight
//! planes are unpacked at once. With AVX-512 allowed, AVX2 is used: for the former, compilers turn the corners of one
//! triangle into a gather, and rays take 5 to 8% longer on Zen 5.
//!
//! # Source
//! C. Benthin, I. Wald, S. Woop, A. Áfra, *Compressed-Leaf Bounding Volume Hierarchies*, 2018, for the idea of
//! quantised nodes over leaves with a vertex table of their own.

// Forced, because the walk must be compiled for the instructions of its lanes, not called from there.
#![allow(clippy::inline_always)]

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod avx2;
mod chunks;
mod emit;
mod ids;
mod node;
mod reader;
mod views;

use core::marker::PhantomData;
use core::ops::ControlFlow;

use bytemuck::{Pod, Zeroable};
use chunks::{CHUNK_HEAD, CHUNK_WORDS, Chunk, Chunks, corner_at, vertex_count};
use ids::Ids;
use reader::Packed;
use views::Unpack;

use super::build::MAX_DEPTH;
use super::dispatch::{traverse, traverse_each};
use super::rows::LANES;
use super::simd::LaneRay;
use crate::error::BuildError;
use crate::geometry::Aabb;
use crate::indices::depth_first::{self, check_depth_first};
use crate::input::{Executor, Mesh, Options, SimdLevel};
use crate::memory::Words;
use crate::query::Query;
use crate::structure::{Described, DividedScene, Sections, Statistics, Structure};

/// The compact BVH, alone or as the local index of a hierarchy: 25 to 30 bytes a triangle, with all that
/// answering needs.
pub type CompactBvh = QuantisedBvh<Chunks>;

/// The lean BVH, alone or as the local index of a hierarchy: made to lie [beside](crate::Scene::beside) a
/// mesh that is kept anyway: 7.3 to 9.4 bytes a triangle more on the scenes of the host.
pub type LeanBvh = QuantisedBvh<Ids>;

/// A BVH of quantised boxes, written down in some form.
pub struct QuantisedBvh<F>(PhantomData<F>);

/// How nodes and leaves are written down. Nodes have two to eight children, leaves one to eight triangles.
trait Form: Copy + 'static {
    /// See [`Structure::HOLDS_TRIANGLES`].
    const HOLDS_TRIANGLES: bool;
    /// So many zeros end an image.
    const ZEROS: usize;
    /// The bits of a link that are a offset.
    const OFFSET: u32;

    /// Writes a node to where room was reserved, and returns the link to it.
    fn write_node(
        node: &QuantisedNode,
        children: usize,
        offset: usize,
        words: &mut Words<'_>,
    ) -> u32;

    /// The words of a node with so many children.
    fn node_words(children: usize) -> usize;

    /// The whole of a node, and its words.
    fn node_at(words: &[u32], link: u32) -> Option<(QuantisedNode, usize)>;

    /// The box in one lane of a node; `None` for an unused lane.
    fn box_at(words: &[u32], link: u32, lane: usize) -> Option<Aabb>;

    /// As [`InLanes::meet_node`](crate::indices::wide::tree::InLanes::meet_node).
    fn meet_node<L: Unpack>(words: &[u32], link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys>;

    /// The link in one lane of a node.
    fn child(words: &[u32], link: u32, lane: usize) -> Option<u32>;

    /// Appends a leaf, and returns the link to it.
    fn write(triangles: Mesh<'_>, ids: impl Iterator<Item = u32>, words: &mut Words<'_>) -> u32;

    /// Decides about all triangles of a leaf, and counts them.
    fn decide<Q: Query>(tree: Packed<'_, Self>, link: u32, query: &mut Q) -> ControlFlow<()>;

    /// Decides about those that the ray may hit up to `last`, and counts all.
    fn test<L: Unpack, Q: Query>(
        tree: Packed<'_, Self>,
        link: u32,
        ray: &LaneRay,
        last: f32,
        query: &mut Q,
    ) -> ControlFlow<()>;

    /// The words and the triangles of a leaf, if reading it does no harm.
    fn check(words: &[u32], link: u32, triangle_count: u32) -> Option<(usize, u32)>;
}

const HEAD_WORDS: usize = 2;
const NODE_WORDS: usize = 38;
const LEAF: u32 = 1 << 31;
/// The link of an unused lane: a leaf past the end of the longest image.
const EMPTY: u32 = u32::MAX;

/// Eight boxes and what is in them.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct QuantisedNode {
    /// Of each axis the lower planes, then the upper; the lower half of a word first.
    planes: [[[u32; 4]; 2]; 3],
    anchor: [f32; 3],
    step: [f32; 3],
    links: [u32; LANES],
}

/// The offset of `EMPTY` lies behind all others.
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
            traverse(Packed::<F>::of(sections), simd_level.without_avx512(), query);
        }
    }

    #[inline]
    fn traverse_each<Q: Query>(
        sections: &Sections<'_>,
        simd_level: SimdLevel,
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        finish: impl FnMut(usize, &Q),
    ) {
        traverse_each(Packed::<F>::of(sections), simd_level.without_avx512(), count, start, finish);
    }

    fn check(sections: &Sections<'_>) -> Result<Statistics, u32> {
        check::<F>(sections.words(), sections.triangle_count()).ok_or(0)
    }
}

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
            if link & LEAF != 0 {
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
