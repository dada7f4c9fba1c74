//! From the wide octree, built in the scratch, to the compact one.

use super::{
    BLOCK_HEAD, BLOCK_WORDS, EDGE, HEAD_WORDS, LEAF, MORE_BLOCKS, MOST_VERTICES, MOST_WORDS,
    NODE_WORDS, Node,
};
use crate::geometry::Aabb;
use crate::indices::wide_octree::tree::WideTree;
use crate::indices::wide_octree::walk::Tree;
use crate::indices::wide_octree::{
    self, HEAD_ROWS, IDS_ROW, LANES, LEAF_ROWS, NODE_ROWS, WideOctree,
};
use crate::indices::{Division, Structure};
use crate::memory::{Arena, Words, size_of_slice};
use crate::{BuildError, Executor, Options, Triangle};

/// The most words of a wide octree over so many triangles: each a leaf of its own, at worst. Nodes of eight
/// children are then a seventh as many at most. The others have more than eight triangles, all of them in leaves
/// right below, so they are at most a ninth as many as there are triangles.
fn wide_words(triangle_count: usize) -> usize {
    let nodes = triangle_count / 7 + triangle_count / 9 + 1;
    let rows = triangle_count
        .saturating_mul(LEAF_ROWS as usize)
        .saturating_add(nodes.saturating_mul(NODE_ROWS as usize))
        .saturating_add(HEAD_ROWS as usize);
    rows.saturating_mul(LANES)
}

/// Beside the scratch of the wide octree.
pub(super) fn scratch_bytes(triangle_count: usize) -> usize {
    size_of_slice::<u32>(wide_words(triangle_count))
}

pub(super) fn build(
    mut division: Division<'_>,
    options: &Options,
    words: &mut Words<'_>,
    scratch: &mut [u8],
    executor: &impl Executor,
) -> Result<(), BuildError> {
    let triangles = division.triangles;
    let count = triangles.len();
    if count == 0 {
        return Ok(());
    }
    let needed = WideOctree::scratch_bytes(count, options).saturating_add(scratch_bytes(count));
    let full = BuildError::ScratchFull { needed, given: scratch.len() };
    let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
    let slots = arena.take::<u32>(wide_words(count)).ok_or(full)?;
    let mut written = Words::new(&mut *slots);
    let again = Division { nodes: &mut *division.nodes, ..division };
    WideOctree::build(again, options, &mut written, arena.into_rest(), executor)?;
    debug_assert!(written.len() <= wide_words(count), "a proven bound");
    let wide = WideTree::of(slots);

    let head = words.len();
    words.extend(&[0; HEAD_WORDS]);
    let link = Encoder { triangles, wide, words: &mut *words }.subtree(wide.root().link);
    words.set(head, link);
    words.set(head + 1, wide.largest().to_bits());
    words.extend(&[0; BLOCK_WORDS]);
    if words.len() > MOST_WORDS {
        return Err(BuildError::TooLarge);
    }
    division.first_owns(words.len());
    Ok(())
}

struct Encoder<'e, 'w> {
    triangles: &'e [Triangle],
    wide: WideTree<'e>,
    words: &'e mut Words<'w>,
}

impl Encoder<'_, '_> {
    /// Appends what a link of the wide octree leads to, and returns the link to it. As deep a recursion as the
    /// tree.
    fn subtree(&mut self, link: u32) -> u32 {
        let place = self.words.len() as u32;
        if link & wide_octree::LEAF != 0 {
            if let Some(leaf) = wide_octree::leaf_at(self.wide.rows, link) {
                let ids = leaf[IDS_ROW].iter().take(wide_octree::leaf_count(link) as usize);
                self.leaf(ids.copied().collect());
            }
            return LEAF | place;
        }
        let mut children = heapless::Vec::<u32, LANES>::new();
        let mut boxes = heapless::Vec::<Aabb, LANES>::new();
        self.wide.for_each_child(link, |child, bounds| {
            let pushed = children.push(child).is_ok() && boxes.push(bounds).is_ok();
            debug_assert!(pushed, "a node has eight lanes");
        });
        self.words.extend(Node::of(&boxes).words());
        let links = place as usize + NODE_WORDS - LANES;
        for (lane, &child) in children.iter().enumerate() {
            let link = self.subtree(child);
            self.words.set(links + lane, link);
        }
        place
    }

    /// Appends a leaf: as few blocks as it takes with the triangles in their order.
    fn leaf(&mut self, ids: heapless::Vec<u32, LANES>) {
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
