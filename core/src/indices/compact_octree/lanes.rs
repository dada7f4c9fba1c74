//! Unpacking, eight at once; what is unpacked is tested as in the wide octree.

use super::{BLOCK_HEAD, BLOCK_WORDS, Block, Node, corner_at, vertex_count};
use crate::indices::wide_octree::lanes::{
    EARLIER, FAR, LATER, LaneRay, Lanes, Portable, UNDERFLOW, key, larger, smaller,
};
use crate::indices::wide_octree::{LANES, Leaf};

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
        let mut entry = [0.0; LANES];
        let mut exit = [f32::INFINITY; LANES];
        for axis in 0..3 {
            let sign = ray.signs[axis] as usize & 1;
            let (anchor, step) = (node.anchor[axis], node.step[axis]);
            let origin = ray.origin[axis];
            let inverse = ray.inverse[axis];
            for lane in 0..LANES {
                let plane = |side| f32::from(node.quantum(axis, side, lane)) * step + anchor;
                entry[lane] = larger((plane(sign) - origin) * inverse, entry[lane]);
                exit[lane] = smaller((plane(1 - sign) - origin) * inverse, exit[lane]);
            }
        }
        let mut keys = [FAR; LANES];
        for lane in 0..LANES {
            let entry = larger(entry[lane] * EARLIER, ray.t_min);
            let exit = smaller(exit[lane] * LATER, last) + UNDERFLOW;
            if entry <= exit {
                keys[lane] = key(entry);
            }
        }
        keys
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
