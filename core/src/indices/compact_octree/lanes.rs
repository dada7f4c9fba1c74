//! Unpacking, eight at once; what is unpacked is tested as in the wide octree.

use super::{BLOCK_HEAD, BLOCK_WORDS, Block, Node, corner_at, vertex_count};
use crate::indices::wide_octree::Leaf;
use crate::indices::wide_octree::lanes::{Eight, LaneRay, Lanes, Portable, meet_planes};

/// Lanes that can read nodes and blocks.
pub(super) trait Unpack: Lanes {
    /// As [`Lanes::meet_boxes`].
    fn meet_node(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys;

    /// The corners of a block's triangles; of unused lanes, anything. No ids.
    fn unpack(block: &Block) -> Leaf;
}

impl Unpack for Portable {
    #[inline(always)]
    fn meet_node(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys {
        meet_planes(ray, last, |axis, side| {
            let quantum = |lane| f32::from(node.quantum(axis, side, lane)).to_bits();
            let quanta = Eight::of(&core::array::from_fn(quantum));
            quanta * Eight::all(node.step[axis % 3]) + Eight::all(node.anchor[axis % 3])
        })
    }

    #[inline(always)]
    fn unpack(block: &Block) -> Leaf {
        let mut leaf = Leaf::default();
        let count = vertex_count(block);
        for (row, numbers) in leaf.iter_mut().enumerate().take(9) {
            let (corner, axis) = (row / 3, row % 3);
            for (lane, number) in numbers.iter_mut().enumerate() {
                let place = BLOCK_HEAD + corner_at(block, corner, lane) + axis * count;
                *number = block[place % BLOCK_WORDS];
            }
        }
        leaf
    }
}
