//! The wide BVH in less memory: the compact BVH, and the lean BVH beside a mesh.
//!
//! ```text
//! words:  link of the root, the largest coordinate | nodes and leaves, depth first, the root first | zeros
//! node:   x.lo[8] x.hi[8] y.lo[8] ... z.hi[8], 16 bits each | anchor.xyz | step.xyz | links[8]
//! ```
//! The lean BVH keeps of a node what its children need: see `ids`. Leaves of the compact BVH hold the
//! triangles: see `blocks`.
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
mod blocks;
mod encode;
mod ids;
mod lanes;
mod node;
mod tree;

use core::marker::PhantomData;
use core::ops::ControlFlow;

use arrayvec::ArrayVec;

use blocks::{BLOCK_HEAD, BLOCK_WORDS, Block, Blocks, corner_at, vertex_count};
use bytemuck::{Pod, Zeroable};
use ids::Ids;
use lanes::Unpack;
use tree::Packed;

use super::wide_bvh::lanes::LaneRay;
use super::wide_bvh::walk::{walk, walk_each};
use super::wide_bvh::{LANES, MAX_DEPTH, STACK, scratch_bytes};
use super::{Division, Statistics, Structure};
use crate::memory::{Image, Words};
use crate::query::Query;
use crate::{BuildError, Executor, Mesh, Options, Vectors};

/// The compact BVH, alone or as the local index of a hierarchy: 25 to 30 bytes a triangle, with all that
/// answering needs.
pub type CompactBvh = QuantisedBvh<Blocks>;

/// The lean BVH, alone or as the local index of a hierarchy: made to lie [beside](crate::Scene::beside) a
/// mesh that is kept anyway: 7.3 to 9.4 bytes a triangle more on the scenes of the host.
pub type LeanBvh = QuantisedBvh<Ids>;

/// A BVH of quantised boxes, written down in some form.
pub struct QuantisedBvh<F>(PhantomData<F>);

/// How nodes and leaves are written down. Nodes have two to eight children, leaves one to eight triangles.
trait Form: Copy + 'static {
    /// The name of the index.
    const NAME: &'static str;
    /// The name of the hierarchy.
    const HIERARCHY_NAME: &'static str;
    /// See [`Structure::KIND`].
    const KIND: u32;
    /// See [`Structure::HOLDS_TRIANGLES`].
    const HOLDS_TRIANGLES: bool;
    /// So many zeros end an image.
    const ZEROS: usize;
    /// The bits of a link that are a place.
    const PLACE: u32;

    /// Writes a node to where room was reserved, and returns the link to it.
    fn write_node(node: &Node, children: usize, place: usize, words: &mut Words<'_>) -> u32;

    /// The words of a node with so many children.
    fn node_words(children: usize) -> usize;

    /// The whole of a node, and its words.
    fn node_at(words: &[u32], link: u32) -> Option<(Node, usize)>;

    /// As [`InLanes::meet_node`](super::wide_bvh::walk::InLanes::meet_node).
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
struct Node {
    /// Of each axis the lower planes, then the upper; the lower half of a word first.
    planes: [[[u32; 4]; 2]; 3],
    anchor: [f32; 3],
    step: [f32; 3],
    links: [u32; LANES],
}

/// The place of `EMPTY` lies behind all others.
fn most_words<F: Form>() -> usize {
    F::PLACE as usize - BLOCK_WORDS
}

impl<F: Form> Structure for QuantisedBvh<F> {
    const NAME: &'static str = F::NAME;
    const HIERARCHY_NAME: &'static str = F::HIERARCHY_NAME;
    const KIND: u32 = F::KIND;
    const HOLDS_TRIANGLES: bool = F::HOLDS_TRIANGLES;

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
        encode::build::<F>(division, words, scratch, executor)
    }

    #[inline]
    fn traverse<Q: Query>(image: &Image<'_>, vectors: Vectors, query: &mut Q) {
        if !image.words().is_empty() {
            walk(Packed::<F>::of(image), vectors.without_avx512(), query);
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
        walk_each(Packed::<F>::of(image), vectors.without_avx512(), count, start, finish);
    }

    fn check(image: &Image<'_>) -> Result<Statistics, u32> {
        check::<F>(image.words(), image.triangle_count()).ok_or(0)
    }
}

fn check<F: Form>(words: &[u32], triangle_count: u32) -> Option<Statistics> {
    let mut statistics = Statistics::default();
    if triangle_count == 0 {
        return words.is_empty().then_some(statistics);
    }
    if words.len() > most_words::<F>() {
        return None;
    }
    let mut end = HEAD_WORDS;
    let mut stack = ArrayVec::<(u32, u32), { STACK * LANES }>::new();
    stack.try_push((*words.first()?, 0)).ok()?;
    while let Some((link, depth)) = stack.pop() {
        // Depth-first order: each node begins where the one before ended.
        if (link & F::PLACE) as usize != end {
            return None;
        }
        if link & LEAF != 0 {
            let (length, count) = F::check(words, link, triangle_count)?;
            end += length;
            statistics.add_leaf(count, depth);
        } else {
            let (node, length) = F::node_at(words, link)?;
            if depth + 1 >= MAX_DEPTH {
                return None;
            }
            statistics.inner_nodes += 1;
            end += length;
            for &child in node.links.iter().rev().filter(|&&child| child != EMPTY) {
                stack.try_push((child, depth + 1)).ok()?;
            }
        }
    }
    let rest = words.get(end..)?;
    let ends = rest.len() == F::ZEROS && rest.iter().all(|&word| word == 0);
    let all = statistics.references == u64::from(triangle_count);
    (ends && all).then_some(statistics)
}
