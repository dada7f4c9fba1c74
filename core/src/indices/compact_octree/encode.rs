//! From the sorted triangles of the wide octree's first pass to nodes and blocks.

use super::{
    BLOCK_HEAD, BLOCK_WORDS, EDGE, HEAD_WORDS, LEAF, MORE_BLOCKS, MOST_VERTICES, MOST_WORDS,
    NODE_WORDS, Node,
};
use crate::geometry::Aabb;
use crate::indices::Division;
use crate::indices::wide_octree::LANES;
use crate::indices::wide_octree::build::{Subtree, sort};
use crate::indices::wide_octree::divide::{Box4, Item};
use crate::memory::Words;
use crate::{BuildError, Executor, Triangle};

pub(super) fn build(
    mut division: Division<'_>,
    words: &mut Words<'_>,
    scratch: &mut [u8],
    executor: &impl Executor,
) -> Result<(), BuildError> {
    let triangles = division.triangles;
    if triangles.is_empty() {
        return Ok(());
    }
    let sorted = sort(&division, scratch, executor)?;
    let head = words.len();
    words.extend(&[0; HEAD_WORDS]);
    let (link, _) = Encoder { triangles, words: &mut *words }.subtree(sorted.root);
    words.set(head, link);
    words.set(head + 1, sorted.largest.to_bits());
    words.extend(&[0; BLOCK_WORDS]);
    if words.len() > MOST_WORDS {
        return Err(BuildError::TooLarge);
    }
    division.first_owns(words.len());
    Ok(())
}

struct Encoder<'e, 'w> {
    triangles: &'e [Triangle],
    words: &'e mut Words<'w>,
}

impl Encoder<'_, '_> {
    /// Appends a subtree, and returns the link to it and its box. As deep a recursion as the tree.
    fn subtree(&mut self, subtree: Subtree<'_>) -> (u32, Box4) {
        let items = subtree.items;
        if items.len() <= LANES {
            let place = self.words.len() as u32;
            self.leaf(items.iter().map(Item::id));
            return (LEAF | place, Box4::around(items));
        }
        // A node comes before its children, and knows their boxes after them.
        let place = self.words.reserve(NODE_WORDS);
        let mut bounds = Box4::EMPTY;
        let mut links = heapless::Vec::<u32, LANES>::new();
        let mut boxes = heapless::Vec::<Aabb, LANES>::new();
        for child in subtree.children() {
            let (link, child) = self.subtree(child);
            bounds = bounds.union(child);
            let pushed = links.push(link).is_ok() && boxes.push(child.aabb()).is_ok();
            debug_assert!(pushed, "a node has eight lanes");
        }
        let mut node = Node::of(&boxes);
        for (slot, link) in node.links.iter_mut().zip(links) {
            *slot = link;
        }
        for (place, &word) in (place..).zip(node.words()) {
            self.words.set(place, word);
        }
        (place as u32, bounds)
    }

    /// Appends a leaf: as few blocks as it takes with the triangles in their order.
    fn leaf(&mut self, ids: impl Iterator<Item = u32>) {
        let mut block = Block::default();
        for id in ids {
            let triangle = self.triangles.get(id as usize).copied().unwrap_or_default();
            if !block.add(&triangle, id) {
                self.write(&block, MORE_BLOCKS);
                block = Block::default();
                // Three vertices fit an empty block.
                let added = block.add(&triangle, id);
                debug_assert!(added);
            }
        }
        self.write(&block, 0);
    }

    fn write(&mut self, block: &Block, more: u32) {
        let vertices = (block.vertices.len() as u32).saturating_sub(1);
        let triangles = (block.ids.len() as u32).saturating_sub(1);
        self.words.push(block.edge() | more | vertices << 3 | triangles);
        self.words.extend(&block.corners);
        for axis in 0..3 {
            for vertex in &block.vertices {
                self.words.push(vertex[axis]);
            }
        }
        self.words.extend(&block.ids);
    }
}

/// A block that is being filled.
#[derive(Default)]
struct Block {
    longest: f32,
    /// See the module's documentation.
    corners: [u32; BLOCK_HEAD - 1],
    /// Their bits, so that each comes back as it was, zeros too.
    vertices: heapless::Vec<[u32; 3], MOST_VERTICES>,
    ids: heapless::Vec<u32, LANES>,
}

impl Block {
    /// Adds a triangle, if its vertices fit.
    fn add(&mut self, triangle: &Triangle, id: u32) -> bool {
        let Self { longest, corners, vertices, ids } = self;
        let known = vertices.len();
        let lane = ids.len();
        for (corner, word) in [triangle.a, triangle.b, triangle.c].iter().zip(corners.iter_mut()) {
            let bits = corner.to_array().map(f32::to_bits);
            let place = vertices.iter().position(|vertex| *vertex == bits);
            let place = place.unwrap_or_else(|| vertices.len());
            if place == vertices.len() && vertices.push(bits).is_err() {
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
        ids.push(id).is_ok()
    }

    /// The edge, rounded up to the bits that there are for it.
    fn edge(&self) -> u32 {
        self.longest.to_bits().saturating_add(!EDGE) & EDGE
    }
}
