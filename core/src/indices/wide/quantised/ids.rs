//! Form of the lean BVH: leaves name the triangles, which lie elsewhere.
//!
//!
//! ```text
//! link:   leaf bit | children or triangles - 1 (3 bits) | word (28 bits)
//! node:   anchor.xyz | step.xyz | links.. | x.. | y.. | z..
//! x:      lo | hi, 16 bits each, the lower half first; y and z likewise
//! leaf:   ids..
//! ```
//! - A node has links and planes of its children only. It is read in place as a node of eight, and the garbage in
//!   unused lanes is ignored.
//! - Both planes of a box share a word, and links come first. So an odd number of children leaves no gap, lanes choose
//!   between near and far planes without a copy of the node, and a link is found without the number of children.
//! - At a leaf, the corners of its triangles are gathered into rows, and tested as those of the wide BVH. Their longest
//!   edges are computed there, too.
//!
//! # What lost
//! - Links and planes for eight children in every node: 0.9 to 1.4 bytes a triangle more.
//! - The longest edge in a word of each leaf, as in the compact BVH: 0.6 to 1.0 bytes a triangle more, for 1% fewer
//!   instructions of a photon.

use super::node::plane;
use super::reader::Packed;
use super::views::{FewBoxes, Known, Unpack};
use super::{Form, LEAF_BIT, LeanBvh, QuantisedNode};
use crate::Vec3;
use crate::geometry::{Aabb, Candidates, LaneRay, Triangle};
use crate::indices::wide::rows::{LANES, Row};
use crate::input::Mesh;
use crate::memory::Words;
use crate::query::{Query, TriangleId};
use crate::structure::{Described, Weights};

/// Form of the lean BVH.
#[derive(Clone, Copy)]
pub enum Ids {}

const COUNT_SHIFT: u32 = 28;
/// Number of words of a node's anchor and step.
const SCALE_WORDS: usize = 6;
/// Number of words of the largest node. The words end with as many zeros, so that any node can be read in one piece.
const WINDOW: usize = SCALE_WORDS + 4 * LANES;

/// Decodes a link: the offset, and the last lane that is used.
#[inline(always)]
fn decoded(link: u32) -> (usize, usize) {
    ((link & Ids::OFFSET) as usize, (link >> COUNT_SHIFT & 7) as usize)
}

#[inline(always)]
/// Reads a node without its links.
fn boxes_at(words: &[u32], link: u32) -> Option<FewBoxes<'_>> {
    let (offset, last_lane) = decoded(link);
    let words: &[u32; WINDOW] = words.get(offset..offset + WINDOW)?.try_into().ok()?;
    let (scale, rest) = words.split_first_chunk::<SCALE_WORDS>()?;
    let [anchor, step]: &[[f32; 3]; 2] = bytemuck::must_cast_ref(scale);
    let row = |number: usize| rest.get(number * (last_lane + 1)..)?.first_chunk();
    Some(FewBoxes { anchor, step, sides: [row(1)?, row(2)?, row(3)?], last_lane })
}

/// Reads the ids of a leaf in place, and the last lane that is used; other lanes hold the words that follow. `None` for
/// the link of an unused lane, which leads past the end.
#[inline(always)]
fn ids_at(words: &[u32], link: u32) -> Option<(&Row, usize)> {
    let (offset, last_lane) = decoded(link);
    Some((words.get(offset..offset + LANES)?.try_into().ok()?, last_lane))
}

impl Described for LeanBvh {
    const NAME: &'static str = "lean-bvh";
    const HIERARCHY_NAME: &'static str = "lean-bvh-hierarchy";
    const FORMAT: u32 = 11;
    const WEIGHTS: Weights = Weights { ray: 2.6, node: 10.6, test: 11.1 }; // +-13%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 65_300.0, node: 12_600.0, test: 1_942.0 }; // +-1%
}

impl Form for Ids {
    type Bundle<'w> = Known<'w>;

    const HOLDS_TRIANGLES: bool = false;
    const ZEROS: usize = WINDOW;
    const OFFSET: u32 = (1 << COUNT_SHIFT) - 1;
    const LINES: usize = 3;

    fn write_node(
        node: &QuantisedNode,
        children: usize,
        offset: usize,
        words: &mut Words<'_>,
    ) -> u32 {
        let scale = node.anchor.into_iter().chain(node.step).map(f32::to_bits);
        let links = node.links.iter().take(children).copied();
        let sides = (0..3).flat_map(|axis| {
            let quantum = move |side, lane| u32::from(node.quantum(axis, side, lane));
            (0..children).map(move |lane| quantum(0, lane) | quantum(1, lane) << 16)
        });
        for (offset, word) in (offset..).zip(scale.chain(links).chain(sides)) {
            words.set(offset, word);
        }
        (children as u32).saturating_sub(1) << COUNT_SHIFT | offset as u32
    }

    fn node_words(children: usize) -> usize {
        SCALE_WORDS + 4 * children
    }

    fn node_at(words: &[u32], link: u32) -> Option<(QuantisedNode, usize)> {
        let FewBoxes { anchor, step, sides, last_lane } = boxes_at(words, link)?;
        let mut node = QuantisedNode { anchor: *anchor, step: *step, ..QuantisedNode::default() };
        for lane in 0..=last_lane {
            for (axis, sides) in sides.iter().enumerate() {
                node.set_quantum(axis, 0, lane, sides[lane % LANES] as u16);
                node.set_quantum(axis, 1, lane, (sides[lane % LANES] >> 16) as u16);
            }
            node.links[lane % LANES] = Self::child(words, link, lane)?;
        }
        Some((node, Self::node_words(last_lane + 1)))
    }

    fn box_at(words: &[u32], link: u32, lane: usize) -> Option<Aabb> {
        let FewBoxes { anchor, step, sides, last_lane } = boxes_at(words, link)?;
        let side = |side: usize| {
            let along = |axis: usize| {
                let quantum = (sides[axis % 3][lane % LANES] >> (16 * side)) as u16;
                plane(quantum, anchor[axis % 3], step[axis % 3])
            };
            Vec3::new(along(0), along(1), along(2))
        };
        (lane <= last_lane).then(|| Aabb::new(side(0), side(1)))
    }

    #[inline(always)]
    fn meet_node<L: Unpack>(words: &[u32], link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys> {
        Some(L::meet_few(&boxes_at(words, link)?, ray, last))
    }

    #[inline(always)]
    fn child(words: &[u32], link: u32, lane: usize) -> Option<u32> {
        words.get(decoded(link).0 + SCALE_WORDS + lane).copied()
    }

    #[inline(always)]
    fn links(words: &[u32], link: u32) -> Option<&Row> {
        words.get(decoded(link).0 + SCALE_WORDS..)?.first_chunk()
    }

    fn write(_: Mesh<'_>, ids: impl Iterator<Item = u32>, words: &mut Words<'_>) -> u32 {
        let offset = words.len();
        for id in ids {
            words.push(id);
        }
        let count = (words.len() - offset) as u32;
        LEAF_BIT | count.saturating_sub(1) << COUNT_SHIFT | offset as u32
    }

    #[inline(always)]
    fn first_bundle(tree: Packed<'_, Self>, link: u32) -> Option<Known<'_>> {
        let (ids, last_lane) = ids_at(tree.words, link)?;
        Some(Known { triangles: tree.triangles(), ids, last_lane })
    }

    #[inline(always)]
    fn lanes(known: Known<'_>) -> u32 {
        (2 << known.last_lane) - 1
    }

    #[inline(always)]
    fn triangle(known: Known<'_>, lane: usize) -> (TriangleId, Triangle) {
        let id = known.ids[lane % LANES];
        (TriangleId(id), known.triangle(id))
    }

    #[inline(always)]
    fn prefetch_triangles<L: Unpack>(known: Known<'_>) {
        for &id in known.ids.iter().take(known.last_lane + 1) {
            match known.triangles {
                // A triangle may lie on two lines.
                Mesh::Triangles(triangles) => L::prefetch(triangles, id as usize, 2),
                Mesh::Indexed { vertices, corners } => {
                    for &corner in corners.get(id as usize).into_iter().flatten() {
                        L::prefetch(vertices, corner as usize, 1);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn filter<L: Unpack, Q: Query>(known: Known<'_>, ray: &LaneRay, last: f32) -> Candidates {
        L::meet_known::<Q>(&known, ray, last)
    }

    fn check(words: &[u32], link: u32, triangle_count: u32) -> Option<(usize, u32)> {
        let (ids, last_lane) = ids_at(words, link)?;
        let known = ids.iter().take(last_lane + 1).all(|&id| id < triangle_count);
        known.then_some((last_lane + 1, last_lane as u32 + 1))
    }
}
