//! The form of the compact BVH: leaves hold the triangles, over tables of the vertices that they share.
//!
//! ```text
//! link:   leaf bit | word (31 bits)
//! leaf:   one block or several
//! block:  edge, counts | corners a, b, c: half a byte a triangle each | x.. | y.. | z.. | ids..
//! counts: more blocks (1 bit) | vertices - 1 (4 bits) | triangles - 1 (3 bits)
//! ```
//! A block lists its vertices once, as the exact floats that they were, and a triangle says which three are its
//! own. A block has no more than 16 vertices; triangles that need others come in a block of their own. The edge,
//! the largest component of the triangles' edges at corner a, is kept as the upper 16 bits of a float, rounded
//! up.
//!
//! The corners of eight triangles are unpacked at once. The zeros at the end of an image are as many as the
//! largest block is long, so that a block can be read in one piece.

use core::ops::ControlFlow;

use arrayvec::ArrayVec;

use super::lanes::Unpack;
use super::tree::Packed;
use super::{Form, LEAF, NODE_WORDS, Node};
use crate::indices::wide_bvh::LANES;
use crate::indices::wide_bvh::lanes::LaneRay;
use crate::indices::wide_bvh::walk::{decide_each, last_t};
use crate::memory::Words;
use crate::query::{Query, TriangleId};
use crate::{Mesh, Triangle, Vec3};

/// The form of the compact BVH.
#[derive(Clone, Copy)]
pub enum Blocks {}

const MOST_VERTICES: usize = 16;
/// Before the vertices: the counts and the corners.
pub(super) const BLOCK_HEAD: usize = 4;
/// Of the largest block.
pub(super) const BLOCK_WORDS: usize = BLOCK_HEAD + 3 * MOST_VERTICES + LANES;
const MORE_BLOCKS: u32 = 1 << 7;
/// The bits of the edge.
const EDGE: u32 = 0xffff_0000;

/// As many words as the largest block has, from where a block begins.
pub(super) type Block = [u32; BLOCK_WORDS];

/// The number of triangles of a block, 1 to 8.
#[inline(always)]
fn triangle_count(block: &Block) -> usize {
    (block[0] & 7) as usize + 1
}

/// The number of vertices of a block, 1 to 16.
#[inline(always)]
pub(super) fn vertex_count(block: &Block) -> usize {
    (block[0] >> 3 & 15) as usize + 1
}

/// The words of a block.
fn block_length(block: &Block) -> usize {
    BLOCK_HEAD + 3 * vertex_count(block) + triangle_count(block)
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
pub(super) fn corner_at(block: &Block, corner: usize, lane: usize) -> usize {
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

#[inline(always)]
fn node_at(words: &[u32], link: u32) -> Option<&Node> {
    let place = link as usize;
    let words: &[u32; NODE_WORDS] = words.get(place..place + NODE_WORDS)?.try_into().ok()?;
    Some(bytemuck::must_cast_ref(words))
}

impl Form for Blocks {
    const NAME: &'static str = "compact-bvh";
    const HIERARCHY_NAME: &'static str = "compact-bvh-hierarchy";
    const KIND: u32 = 10;
    const HOLDS_TRIANGLES: bool = true;
    const ZEROS: usize = BLOCK_WORDS;
    const PLACE: u32 = !LEAF;

    fn write_node(node: &Node, _: usize, place: usize, words: &mut Words<'_>) -> u32 {
        for (place, &word) in (place..).zip(node.words()) {
            words.set(place, word);
        }
        place as u32
    }

    fn node_words(_: usize) -> usize {
        NODE_WORDS
    }

    fn node_at(words: &[u32], link: u32) -> Option<(Node, usize)> {
        Some((*node_at(words, link)?, NODE_WORDS))
    }

    #[inline(always)]
    fn meet_node<L: Unpack>(words: &[u32], link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys> {
        Some(L::meet_node(node_at(words, link)?, ray, last))
    }

    #[inline(always)]
    fn child(words: &[u32], link: u32, lane: usize) -> Option<u32> {
        Some(node_at(words, link)?.links[lane % LANES])
    }

    /// As few blocks as it takes with the triangles in their order.
    fn write(triangles: Mesh<'_>, ids: impl Iterator<Item = u32>, words: &mut Words<'_>) -> u32 {
        let place = words.len() as u32;
        let mut block = Filling::default();
        for id in ids {
            let triangle = triangles.get(id).unwrap_or_default();
            if !block.add(&triangle, id) {
                block.write(MORE_BLOCKS, words);
                block = Filling::default();
                // Three vertices fit an empty block.
                let added = block.add(&triangle, id);
                debug_assert!(added);
            }
        }
        block.write(0, words);
        LEAF | place
    }

    #[inline(always)]
    fn decide<Q: Query>(tree: Packed<'_, Self>, link: u32, query: &mut Q) -> ControlFlow<()> {
        for block in leaf_at(tree.words, link) {
            query.count_tests(triangle_count(block) as u32);
            for lane in 0..triangle_count(block) {
                query.decide(TriangleId(id_at(block, lane)), &triangle_at(block, lane))?;
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn test<L: Unpack, Q: Query>(
        tree: Packed<'_, Self>,
        link: u32,
        ray: &LaneRay,
        _: f32,
        query: &mut Q,
    ) -> ControlFlow<()> {
        for block in leaf_at(tree.words, link) {
            let count = triangle_count(block);
            query.count_tests(count as u32);
            let (leaf, edges) = (L::unpack(block), L::all(f32::from_bits(block[0] & EDGE)));
            let last = last_t(query);
            let candidates = L::meet_triangles::<Q>(&leaf, ray, edges, last);
            let candidates = candidates.of((1 << count) - 1, query)?;
            let triangle = |lane| (TriangleId(id_at(block, lane)), triangle_at(block, lane));
            decide_each::<L, Q>(candidates, ray, query, triangle)?;
        }
        ControlFlow::Continue(())
    }

    fn check(words: &[u32], link: u32, triangle_count: u32) -> Option<(usize, u32)> {
        let place = (link & Self::PLACE) as usize;
        let (mut end, mut count) = (place, 0);
        loop {
            let block = block_at(words, end)?;
            check_block(block, triangle_count)?;
            count += self::triangle_count(block) as u32;
            end += block_length(block);
            if block[0] & MORE_BLOCKS == 0 {
                return Some((end - place, count));
            }
        }
    }
}

/// The blocks of a leaf; none for the link of an unused lane, which leads past the end.
#[inline(always)]
fn leaf_at(words: &[u32], link: u32) -> impl Iterator<Item = &Block> {
    let mut next = Some((link & Blocks::PLACE) as usize);
    core::iter::from_fn(move || {
        let place = next?;
        let block = block_at(words, place)?;
        next = (block[0] & MORE_BLOCKS != 0).then(|| place + block_length(block));
        Some(block)
    })
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

/// A block that is being filled.
#[derive(Default)]
struct Filling {
    longest: f32,
    /// See the module's documentation.
    corners: [u32; BLOCK_HEAD - 1],
    /// Their bits, so that each comes back as it was, zeros too.
    vertices: ArrayVec<[u32; 3], MOST_VERTICES>,
    ids: ArrayVec<u32, LANES>,
}

impl Filling {
    /// Adds a triangle, if its vertices fit.
    fn add(&mut self, triangle: &Triangle, id: u32) -> bool {
        let Self { longest, corners, vertices, ids } = self;
        let known = vertices.len();
        let lane = ids.len();
        for (corner, word) in [triangle.a, triangle.b, triangle.c].iter().zip(corners.iter_mut()) {
            let bits = corner.to_array().map(f32::to_bits);
            let place = vertices.iter().position(|vertex| *vertex == bits);
            let place = place.unwrap_or_else(|| vertices.len());
            if place == vertices.len() && vertices.try_push(bits).is_err() {
                vertices.truncate(known);
                // The corners of this lane are those of the block that follows.
                for word in corners {
                    *word &= !(15 << (4 * (lane % LANES)));
                }
                return false;
            }
            *word |= (place as u32) << (4 * (lane % LANES));
        }
        for edge in [triangle.b - triangle.a, triangle.c - triangle.a] {
            for length in edge.abs().to_array() {
                *longest = if length > *longest { length } else { *longest };
            }
        }
        ids.try_push(id).is_ok()
    }

    /// The edge, rounded up to the bits that there are for it.
    fn edge(&self) -> u32 {
        self.longest.to_bits().saturating_add(!EDGE) & EDGE
    }

    /// Appends the block.
    fn write(&self, more: u32, words: &mut Words<'_>) {
        let vertices = (self.vertices.len() as u32).saturating_sub(1);
        let triangles = (self.ids.len() as u32).saturating_sub(1);
        words.push(self.edge() | more | vertices << 3 | triangles);
        words.extend(&self.corners);
        for axis in 0..3 {
            for vertex in &self.vertices {
                words.push(vertex[axis]);
            }
        }
        words.extend(&self.ids);
    }
}
