//! Form of the compact BVH: leaves hold the triangles, as tables of shared vertices.
//!
//!
//! ```text
//! link:   leaf bit | word (31 bits)
//! leaf:   one chunk or several
//! chunk:  edge and counts | corners a, b, c: a word each, 4 bits a triangle | x.. | y.. | z.. | ids..
//! counts: more chunks (1 bit) | vertices - 1 (4 bits) | triangles - 1 (3 bits)
//! ```
//! - A chunk lists each of its vertices once, as the exact floats that it was built from. A triangle says which three
//!   are its corners.
//! - A chunk has up to 16 vertices. Triangles that need more vertices start another chunk.
//! - The edge is the largest component of the triangles' edges at corner a. It is stored as the upper 16 bits of a
//!   float, rounded up.
//! - The corners of eight triangles are unpacked at once.
//! - The words end with as many zeros as the largest chunk has words, so that any chunk can be read in one piece.

use arrayvec::ArrayVec;

use super::reader::Packed;
use super::views::Unpack;
use super::{CompactBvh, EMPTY, Form, LEAF_BIT, NODE_WORDS, QuantisedNode};
use crate::Vec3;
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::indices::wide::rows::{LANES, Row};
use crate::input::Mesh;
use crate::memory::Words;
use crate::query::{Query, TriangleId};
use crate::structure::{Described, Weights};

/// Form of the compact BVH.
#[derive(Clone, Copy)]
pub enum Chunks {}

/// Largest number of vertices in a chunk.
const MOST_VERTICES: usize = 16;
/// Number of words before the vertices: edge and counts, and the corners.
pub(super) const CHUNK_HEAD: usize = 4;
/// Number of words of the largest chunk.
pub(super) const CHUNK_WORDS: usize = CHUNK_HEAD + 3 * MOST_VERTICES + LANES;
/// The bit of the counts that says that another chunk of the leaf follows.
const MORE_CHUNKS: u32 = 1 << 7;
/// The bits of a chunk's first word that are the edge.
const EDGE: u32 = 0xffff_0000;

/// Window of as many words as the largest chunk has, from the start of a chunk.
pub(super) type Chunk = [u32; CHUNK_WORDS];

/// The number of triangles of a chunk, 1 to 8.
#[inline(always)]
fn triangle_count(chunk: &Chunk) -> usize {
    (chunk[0] & 7) as usize + 1
}

/// The number of vertices of a chunk, 1 to 16.
#[inline(always)]
pub(super) fn vertex_count(chunk: &Chunk) -> usize {
    (chunk[0] >> 3 & 15) as usize + 1
}

/// The number of words of a chunk.
fn chunk_length(chunk: &Chunk) -> usize {
    CHUNK_HEAD + 3 * vertex_count(chunk) + triangle_count(chunk)
}

#[inline(always)]
fn chunk_at(words: &[u32], offset: usize) -> Option<&Chunk> {
    words.get(offset..offset + CHUNK_WORDS)?.try_into().ok()
}

#[inline(always)]
fn id_at(chunk: &Chunk, lane: usize) -> u32 {
    let offset = CHUNK_HEAD + 3 * vertex_count(chunk) + lane % LANES;
    chunk[offset % CHUNK_WORDS]
}

/// The index in the table of vertices of a triangle's corner 0, 1 or 2.
#[inline(always)]
pub(super) fn corner_at(chunk: &Chunk, corner: usize, lane: usize) -> usize {
    (chunk[1 + corner % 3] >> (4 * (lane % LANES)) & 15) as usize
}

#[inline(always)]
fn triangle_at(chunk: &Chunk, lane: usize) -> Triangle {
    let count = vertex_count(chunk);
    let corner = |corner: usize| {
        let offset = CHUNK_HEAD + corner_at(chunk, corner, lane);
        // At most 4 + 15 + 32, which is less than `CHUNK_WORDS`: the reduction changes nothing (see `rows`).
        let number = |axis: usize| f32::from_bits(chunk[(offset + axis * count) % CHUNK_WORDS]);
        Vec3::new(number(0), number(1), number(2))
    };
    Triangle::new(corner(0), corner(1), corner(2))
}

#[inline(always)]
fn node_at(words: &[u32], link: u32) -> Option<&QuantisedNode> {
    let offset = link as usize;
    let words: &[u32; NODE_WORDS] = words.get(offset..offset + NODE_WORDS)?.try_into().ok()?;
    Some(bytemuck::must_cast_ref(words))
}

impl Described for CompactBvh {
    const NAME: &'static str = "compact-bvh";
    const HIERARCHY_NAME: &'static str = "compact-bvh-hierarchy";
    const FORMAT: u32 = 10;
    const WEIGHTS: Weights = Weights { ray: 0.7, node: 11.5, test: 6.3 }; // +-8%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 65_300.0, node: 11_120.0, test: 1_942.0 }; // +-1%
}

impl Form for Chunks {
    /// A chunk, and its offset.
    type Bundle<'w> = (&'w Chunk, usize);

    const HOLDS_TRIANGLES: bool = true;
    const ZEROS: usize = CHUNK_WORDS;
    const OFFSET: u32 = !LEAF_BIT;
    const LINES: usize = 4;

    fn write_node(node: &QuantisedNode, _: usize, offset: usize, words: &mut Words<'_>) -> u32 {
        for (offset, &word) in (offset..).zip(node.words()) {
            words.set(offset, word);
        }
        offset as u32
    }

    fn node_words(_: usize) -> usize {
        NODE_WORDS
    }

    fn node_at(words: &[u32], link: u32) -> Option<(QuantisedNode, usize)> {
        Some((*node_at(words, link)?, NODE_WORDS))
    }

    fn box_at(words: &[u32], link: u32, lane: usize) -> Option<Aabb> {
        let node = node_at(words, link)?;
        (node.links[lane % LANES] != EMPTY).then(|| node.bounds(lane))
    }

    #[inline(always)]
    fn meet_node<L: Unpack>(words: &[u32], link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys> {
        Some(L::meet_node(node_at(words, link)?, ray, last))
    }

    #[inline(always)]
    fn child(words: &[u32], link: u32, lane: usize) -> Option<u32> {
        Some(node_at(words, link)?.links[lane % LANES])
    }

    #[inline(always)]
    fn links(words: &[u32], link: u32) -> Option<&Row> {
        Some(&node_at(words, link)?.links)
    }

    /// Writes as few chunks as the triangles, in their order, need.
    fn write(triangles: Mesh<'_>, ids: impl Iterator<Item = u32>, words: &mut Words<'_>) -> u32 {
        let offset = words.len() as u32;
        let mut chunk = Filling::default();
        for id in ids {
            let triangle = triangles.get(id).unwrap_or_default();
            if !chunk.add(&triangle, id) {
                chunk.write(MORE_CHUNKS, words);
                chunk = Filling::default();
                // Three vertices fit an empty chunk.
                let added = chunk.add(&triangle, id);
                debug_assert!(added);
            }
        }
        chunk.write(0, words);
        LEAF_BIT | offset
    }

    #[inline(always)]
    fn first_bundle(tree: Packed<'_, Self>, link: u32) -> Option<(&Chunk, usize)> {
        let offset = (link & Self::OFFSET) as usize;
        Some((chunk_at(tree.words, offset)?, offset))
    }

    #[inline(always)]
    fn next_bundle<'w>(
        tree: Packed<'w, Self>,
        (chunk, offset): (&Chunk, usize),
    ) -> Option<(&'w Chunk, usize)> {
        let offset = (chunk[0] & MORE_CHUNKS != 0).then(|| offset + chunk_length(chunk))?;
        Some((chunk_at(tree.words, offset)?, offset))
    }

    #[inline(always)]
    fn lanes((chunk, _): (&Chunk, usize)) -> u32 {
        (1 << triangle_count(chunk)) - 1
    }

    #[inline(always)]
    fn triangle((chunk, _): (&Chunk, usize), lane: usize) -> (TriangleId, Triangle) {
        (TriangleId(id_at(chunk, lane)), triangle_at(chunk, lane))
    }

    #[inline(always)]
    fn filter<L: Unpack, Q: Query>(
        (chunk, _): (&Chunk, usize),
        ray: &LaneRay,
        last: f32,
    ) -> Candidates {
        let (leaf, edges) = (L::unpack(chunk), L::all(f32::from_bits(chunk[0] & EDGE)));
        L::meet_triangles::<Q>(&leaf, ray, edges, last)
    }

    fn check(words: &[u32], link: u32, triangle_count: u32) -> Option<(usize, u32)> {
        let offset = (link & Self::OFFSET) as usize;
        let (mut end, mut count) = (offset, 0);
        loop {
            let chunk = chunk_at(words, end)?;
            check_chunk(chunk, triangle_count)?;
            count += self::triangle_count(chunk) as u32;
            end += chunk_length(chunk);
            if chunk[0] & MORE_CHUNKS == 0 {
                return Some((end - offset, count));
            }
        }
    }
}

/// Checks that ids are those of triangles, corners are in the table, and triangles are finite.
fn check_chunk(chunk: &Chunk, triangle_count: u32) -> Option<()> {
    let vertices = vertex_count(chunk);
    for lane in 0..self::triangle_count(chunk) {
        let inside = (0..3).all(|corner| corner_at(chunk, corner, lane) < vertices);
        let known = id_at(chunk, lane) < triangle_count;
        if !inside || !known || !triangle_at(chunk, lane).is_finite() {
            return None;
        }
    }
    Some(())
}

/// Chunk that is being filled.
#[derive(Default)]
struct Filling {
    longest: f32,
    /// The corners a, b and c, 4 bits a triangle.
    corners: [u32; CHUNK_HEAD - 1],
    /// The bits of the vertices, so that each is restored as it was, -0.0 too.
    vertices: ArrayVec<[u32; 3], MOST_VERTICES>,
    ids: ArrayVec<u32, LANES>,
}

impl Filling {
    /// Adds a triangle. Returns false, and adds nothing, if its vertices do not fit.
    fn add(&mut self, triangle: &Triangle, id: u32) -> bool {
        let Self { longest, corners, vertices, ids } = self;
        let known = vertices.len();
        let lane = ids.len();
        for (corner, word) in [triangle.a, triangle.b, triangle.c].iter().zip(corners.iter_mut()) {
            let bits = corner.to_array().map(f32::to_bits);
            let index = vertices.iter().position(|vertex| *vertex == bits);
            let index = index.unwrap_or_else(|| vertices.len());
            if index == vertices.len() && vertices.try_push(bits).is_err() {
                vertices.truncate(known);
                // Undo the corners: this triangle's are those of the next chunk.
                for word in corners {
                    *word &= !(15 << (4 * (lane % LANES)));
                }
                return false;
            }
            *word |= (index as u32) << (4 * (lane % LANES));
        }
        for edge in [triangle.b - triangle.a, triangle.c - triangle.a] {
            for length in edge.abs().to_array() {
                *longest = if length > *longest { length } else { *longest };
            }
        }
        ids.try_push(id).is_ok()
    }

    /// The longest edge, rounded up to the bits stored.
    fn edge(&self) -> u32 {
        self.longest.to_bits().saturating_add(!EDGE) & EDGE
    }

    /// Appends the chunk to `words`; `more` is [`MORE_CHUNKS`] or 0.
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
