//! Unpacking, eight at once; what is unpacked is tested as in the wide octree.

use super::{BLOCK_HEAD, BLOCK_WORDS, Block, Node, corner_at, vertex_count};
use crate::indices::wide_octree::lanes::{Eight, FAR, LaneRay, Lanes, Portable, meet_planes};
use crate::indices::wide_octree::{LANES, Leaf};

/// Lanes that can read nodes and blocks.
pub(super) trait Unpack: Lanes {
    /// As [`Lanes::meet_boxes`].
    fn meet_node(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys;

    /// The corners of a block's triangles; of unused lanes, anything. No ids.
    fn unpack(block: &Block) -> Leaf;

    /// The keys of the first lanes, `FAR` in the others.
    fn first(keys: Self::Keys, count: usize) -> Self::Keys;
}

/// With all bits set in lanes from a count on.
pub(super) const LANES_FROM: [[u16; LANES]; LANES + 1] = {
    let mut masks = [[FAR; LANES]; LANES + 1];
    let mut count = 0;
    while count <= LANES {
        let mut lane = 0;
        while lane < count {
            masks[count][lane] = 0;
            lane += 1;
        }
        count += 1;
    }
    masks
};

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

    #[inline(always)]
    fn first(keys: Self::Keys, count: usize) -> Self::Keys {
        let beyond = LANES_FROM[count.min(LANES)];
        core::array::from_fn(|lane| keys[lane] | beyond[lane])
    }
}
