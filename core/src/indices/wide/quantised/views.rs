//! Unpacking of nodes and leaves, eight lanes at once. The results are tested as in the wide BVH.

use super::{CHUNK_HEAD, CHUNK_WORDS, Chunk, QuantisedNode, corner_at, vertex_count};
use crate::geometry::Triangle;
use crate::geometry::{Candidates, LaneRay, Numbers};
use crate::indices::wide::rows::{LANES, LeafRows, Row, set_triangle};
use crate::input::Mesh;
use crate::query::Query;
use crate::simd::portable::{Eight, meet_planes};
use crate::simd::{FAR, Lanes, Portable};

/// Node without its links, in place. Unused lanes hold the words that follow.
pub(super) struct FewBoxes<'w> {
    pub anchor: &'w [f32; 3],
    pub step: &'w [f32; 3],
    /// For each axis a word a lane: the lower plane in the lower half, the upper plane in the upper half.
    pub sides: [&'w Row; 3],
    pub last_lane: usize,
}

/// Leaf of the lean BVH: the ids of its triangles, and the mesh that has them.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub triangles: &'a Mesh<'a>,
    pub ids: &'a Row,
    pub last_lane: usize,
}

impl Known<'_> {
    #[inline(always)]
    pub fn triangle(&self, id: u32) -> Triangle {
        self.triangles.get(id).unwrap_or_default()
    }
}

/// Lanes that can unpack quantised nodes and leaves.
pub(super) trait Unpack: Lanes {
    /// Tests the boxes of a node; see [`Lanes::meet_boxes`].
    fn meet_node(node: &QuantisedNode, ray: &LaneRay, last: f32) -> Self::Keys;

    /// Unpacks the corners of a chunk's triangles. The contents of unused lanes are arbitrary; ids are left out.
    fn unpack(chunk: &Chunk) -> LeafRows;

    /// Tests the boxes of a node of the lean BVH; see [`Lanes::meet_boxes`]. Unused lanes get `FAR`.
    fn meet_few(boxes: &FewBoxes<'_>, ray: &LaneRay, last: f32) -> Self::Keys;

    /// Tests the triangles of a leaf of the lean BVH; see [`Lanes::meet_triangles`]. The bits of unused lanes are
    /// arbitrary.
    fn meet_known<Q: Query>(known: &Known<'_>, ray: &LaneRay, last: f32) -> Candidates;
}

/// Masks with all bits set in the lanes behind the last that is used, by that lane's number.
pub(super) const UNUSED: [[u16; LANES]; LANES] = {
    let mut masks = [[FAR; LANES]; LANES];
    let mut last = 0;
    while last < LANES {
        let mut lane = 0;
        while lane <= last {
            masks[last][lane] = 0;
            lane += 1;
        }
        last += 1;
    }
    masks
};

impl Unpack for Portable {
    #[inline(always)]
    fn meet_node(node: &QuantisedNode, ray: &LaneRay, last: f32) -> Self::Keys {
        let (anchor, step) = (node.anchor.map(Eight::all), node.step.map(Eight::all));
        meet_planes(ray, last, |axis| {
            ray.sides(axis).map(|side| {
                let quantum = |lane| f32::from(node.quantum(axis, side, lane)).to_bits();
                Eight::of(&core::array::from_fn(quantum)) * step[axis % 3] + anchor[axis % 3]
            })
        })
    }

    #[inline(always)]
    fn unpack(chunk: &Chunk) -> LeafRows {
        let mut leaf = LeafRows::default();
        let count = vertex_count(chunk);
        for (row, numbers) in leaf.iter_mut().enumerate().take(9) {
            let (corner, axis) = (row / 3, row % 3);
            for (lane, number) in numbers.iter_mut().enumerate() {
                let offset = CHUNK_HEAD + corner_at(chunk, corner, lane) + axis * count;
                *number = chunk[offset % CHUNK_WORDS];
            }
        }
        leaf
    }

    #[inline(always)]
    fn meet_few(boxes: &FewBoxes<'_>, ray: &LaneRay, last: f32) -> Self::Keys {
        let (anchor, step) = (boxes.anchor.map(Eight::all), boxes.step.map(Eight::all));
        let keys = meet_planes(ray, last, |axis| {
            ray.sides(axis).map(|side| {
                let quantum = |sides: u32| f32::from((sides >> (16 * side)) as u16).to_bits();
                let quanta = Eight::of(&boxes.sides[axis % 3].map(quantum));
                quanta * step[axis % 3] + anchor[axis % 3]
            })
        });
        let beyond = UNUSED[boxes.last_lane % LANES];
        core::array::from_fn(|lane| keys[lane] | beyond[lane])
    }

    #[inline(always)]
    fn meet_known<Q: Query>(known: &Known<'_>, ray: &LaneRay, last: f32) -> Candidates {
        let mut leaf = LeafRows::default();
        for (lane, &id) in known.ids.iter().enumerate().take(known.last_lane + 1) {
            set_triangle(&mut leaf, lane, &known.triangle(id));
        }
        Self::meet_triangles::<Q>(&leaf, ray, Self::edges(&leaf), last)
    }
}
