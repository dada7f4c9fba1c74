//! The compact octree: the wide octree in half the memory.
//!
//! ```text
//! words:  link of the root, the largest coordinate | nodes and leaves, depth first, the root first | zeros
//! node:   x.lo[8] x.hi[8] y.lo[8] ... z.hi[8], 16 bits each | anchor.xyz | step.xyz | links[8]
//! leaf:   one block or several
//! block:  edge, counts | corners a, b, c: half a byte a triangle each | x.. | y.. | z.. | ids..
//! link:   leaf bit | word (31 bits)
//! counts: more blocks (1 bit) | vertices - 1 (4 bits) | triangles - 1 (3 bits)
//! ```
//! The tree is that of the wide octree, and so are the walk and the triangle tests. What differs is how nodes
//! and leaves are written down:
//!
//! - The planes of a node's boxes are `anchor + q * step`, `q` a number of 16 bits; rounded outwards, and kept
//!   where they can be: see `node`. An unused lane has a link past the end.
//! - A leaf lists its vertices once, as the exact floats that they were, and a triangle says which three are
//!   its own. A block has no more than 16 vertices; triangles that need others come in a block of their own.
//!   The edge, the largest component of the triangles' edges at corner a, is kept as the upper 16 bits of a
//!   float, rounded up.
//!
//! Eight planes, or the corners of eight triangles, are unpacked at once. The zeros at the end are as many as
//! the largest block is long, so that a block can be read in one piece.
//!
//! # Source
//! C. Benthin, I. Wald, S. Woop, A. Áfra, *Compressed-Leaf Bounding Volume Hierarchies*, 2018, for the idea of
//! quantised nodes over leaves with a vertex table of their own.

// Forced, because the walk must be compiled for the instructions of its lanes, not called from there.
#![allow(clippy::inline_always)]

#[cfg(target_arch = "x86_64")]
mod avx2;
mod encode;
mod lanes;
mod node;
mod tree;

use bytemuck::{Pod, Zeroable};
use tree::Packed;

use super::wide_octree::walk::{walk, walk_each};
use super::wide_octree::{LANES, MAX_DEPTH, STACK, WideOctree};
use super::{Division, Statistics, Structure};
use crate::memory::{Image, Words};
use crate::query::Query;
use crate::{BuildError, Executor, Options, Triangle, Vec3, Vectors};

/// The compact octree, alone or as the local index of a hierarchy.
pub enum CompactOctree {}

const HEAD_WORDS: usize = 2;
const NODE_WORDS: usize = 38;
const LEAF: u32 = 1 << 31;
/// The link of an unused lane: a leaf past the end of the longest image.
const EMPTY: u32 = u32::MAX;
/// Links have 31 bits, and `EMPTY` lies behind all.
const MOST_WORDS: usize = (1 << 31) - 1 - BLOCK_WORDS;

const MOST_VERTICES: usize = 16;
/// Before the vertices: the counts and the corners.
const BLOCK_HEAD: usize = 4;
/// Of the largest block.
const BLOCK_WORDS: usize = BLOCK_HEAD + 3 * MOST_VERTICES + LANES;
const MORE_BLOCKS: u32 = 1 << 7;
/// The bits of the edge.
const EDGE: u32 = 0xffff_0000;

/// Eight boxes and what is in them.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Node {
    /// Of each axis the lower planes, then the upper; the lower half of a word first.
    planes: [[u32; 4]; 6],
    anchor: [f32; 3],
    step: [f32; 3],
    links: [u32; LANES],
}

/// As many words as the largest block has, from where a block begins.
type Block = [u32; BLOCK_WORDS];

/// The number of triangles of a block, 1 to 8.
#[inline(always)]
fn triangle_count(block: &Block) -> usize {
    (block[0] & 7) as usize + 1
}

/// The number of vertices of a block, 1 to 16.
#[inline(always)]
fn vertex_count(block: &Block) -> usize {
    (block[0] >> 3 & 15) as usize + 1
}

/// The words of a block.
fn block_length(block: &Block) -> usize {
    BLOCK_HEAD + 3 * vertex_count(block) + triangle_count(block)
}

#[inline(always)]
fn node_at(words: &[u32], link: u32) -> Option<&Node> {
    let place = link as usize;
    let words: &[u32; NODE_WORDS] = words.get(place..place + NODE_WORDS)?.try_into().ok()?;
    Some(bytemuck::must_cast_ref(words))
}

#[inline(always)]
fn block_at(words: &[u32], place: usize) -> Option<&Block> {
    words.get(place..place + BLOCK_WORDS)?.try_into().ok()
}

#[inline(always)]
fn id_at(block: &Block, lane: usize) -> u32 {
    let place = BLOCK_HEAD + 3 * vertex_count(block) + lane % LANES;
    block[place % BLOCK_WORDS]
}

/// The index of a corner (0, 1, 2) in the table of vertices.
#[inline(always)]
fn corner_at(block: &Block, corner: usize, lane: usize) -> usize {
    (block[1 + corner % 3] >> (4 * (lane % LANES)) & 15) as usize
}

#[inline(always)]
fn triangle_at(block: &Block, lane: usize) -> Triangle {
    let count = vertex_count(block);
    let corner = |corner: usize| {
        let place = BLOCK_HEAD + corner_at(block, corner, lane);
        // At most 4 + 15 + 32, and never as much as the block has.
        let number = |axis: usize| f32::from_bits(block[(place + axis * count) % BLOCK_WORDS]);
        Vec3::new(number(0), number(1), number(2))
    };
    Triangle::new(corner(0), corner(1), corner(2))
}

impl Structure for CompactOctree {
    const NAME: &'static str = "compact-octree";
    const HIERARCHY_NAME: &'static str = "compact-octree-hierarchy";
    const KIND: u32 = 10;
    const HOLDS_TRIANGLES: bool = true;

    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        WideOctree::scratch_bytes(triangle_count, options)
    }

    fn build(
        division: Division<'_>,
        _: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<(), BuildError> {
        encode::build(division, words, scratch, executor)
    }

    #[inline]
    fn traverse<Q: Query>(image: &Image<'_>, vectors: Vectors, query: &mut Q) {
        if !image.words().is_empty() {
            walk(Packed { words: image.words() }, vectors, query);
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
        walk_each(Packed { words: image.words() }, vectors, count, start, finish);
    }

    fn check(image: &Image<'_>) -> Result<Statistics, u32> {
        check(image.words(), image.triangle_count()).ok_or(0)
    }
}

fn check(words: &[u32], triangle_count: u32) -> Option<Statistics> {
    let mut statistics = Statistics::default();
    if triangle_count == 0 {
        return words.is_empty().then_some(statistics);
    }
    if words.len() > MOST_WORDS + BLOCK_WORDS {
        return None;
    }
    let mut end = HEAD_WORDS;
    let mut stack = heapless::Vec::<(u32, u32), { STACK * LANES }>::new();
    stack.push((*words.first()?, 0)).ok()?;
    while let Some((link, depth)) = stack.pop() {
        // Depth-first order: each node begins where the one before ended.
        if (link & !LEAF) as usize != end {
            return None;
        }
        if link & LEAF != 0 {
            let mut count = 0;
            loop {
                let block = block_at(words, end)?;
                check_block(block, triangle_count)?;
                count += self::triangle_count(block) as u32;
                end += block_length(block);
                if block[0] & MORE_BLOCKS == 0 {
                    break;
                }
            }
            statistics.add_leaf(count, depth);
        } else {
            let node = node_at(words, link)?;
            if depth + 1 >= MAX_DEPTH {
                return None;
            }
            statistics.inner_nodes += 1;
            end += NODE_WORDS;
            for &child in node.links.iter().rev().filter(|&&child| child != EMPTY) {
                stack.push((child, depth + 1)).ok()?;
            }
        }
    }
    let rest = words.get(end..)?;
    let ends = rest.len() == BLOCK_WORDS && rest.iter().all(|&word| word == 0);
    let all = statistics.references == u64::from(triangle_count);
    (ends && all).then_some(statistics)
}

/// Ids are known, corners are in the table, and triangles are finite.
fn check_block(block: &Block, triangle_count: u32) -> Option<()> {
    let vertices = vertex_count(block);
    for lane in 0..self::triangle_count(block) {
        let inside = (0..3).all(|corner| corner_at(block, corner, lane) < vertices);
        let known = id_at(block, lane) < triangle_count;
        if !inside || !known || !triangle_at(block, lane).is_finite() {
            return None;
        }
    }
    Some(())
}
