//! The form of the lean octree: leaves name the triangles, which lie elsewhere.
//!
//! ```text
//! link:   leaf bit | children or triangles - 1 (3 bits) | word (28 bits)
//! node:   anchor.xyz | step.xyz | x.lo.. x.hi.. y.lo.. ... z.hi.., 16 bits each, in whole words | links..
//! leaf:   ids..
//! ```
//! A node has the planes and links of its children only: with room for eight, an image would be 0.7 bytes a
//! triangle longer, and 4 on figure 3. It is read as one of eight, and what lies in unused lanes is passed over.
//!
//! At a leaf the corners of its triangles are gathered into rows, and tested as those of the wide octree. Their
//! longest edge is found there too: kept in a word of each leaf, as the compact octree does, it would cost 0.6
//! to 1.0 bytes a triangle, and save 2% of the instructions of a photon.

use core::ops::ControlFlow;

use super::lanes::Unpack;
use super::tree::Packed;
use super::{EMPTY, Form, LEAF, Node};
use crate::indices::wide_octree::lanes::{Eight, LaneRay};
use crate::indices::wide_octree::walk::finite;
use crate::indices::wide_octree::{LANES, Leaf, triangle_at};
use crate::memory::Words;
use crate::query::{Query, TriangleId};
use crate::{Mesh, Triangle};

/// The form of the lean octree.
#[derive(Clone, Copy)]
pub enum Ids {}

const COUNT_SHIFT: u32 = 28;
/// Of a node: the anchor and the step.
const SCALE_WORDS: usize = 6;
/// Of the largest node, without its links. So many zeros are at the end of an image, so that any node's boxes can
/// be read in one piece.
const WINDOW: usize = SCALE_WORDS + 6 * LANES / 2;

/// The place, and how many children or triangles there are.
#[inline(always)]
fn decoded(link: u32) -> (usize, usize) {
    ((link & Ids::PLACE) as usize, (link >> COUNT_SHIFT & 7) as usize + 1)
}

/// The words of one side of all children's boxes.
#[inline(always)]
fn side_words(children: usize) -> usize {
    children.div_ceil(2)
}

/// A node without its links. In unused lanes lies what comes next.
#[inline(always)]
fn boxes_at(words: &[u32], link: u32) -> Option<Node> {
    let (place, children) = decoded(link);
    let (scale, rest) = words.get(place..)?.first_chunk::<WINDOW>()?.split_first_chunk()?;
    let [anchor, step]: [[f32; 3]; 2] = bytemuck::must_cast::<[u32; SCALE_WORDS], _>(*scale);
    let length = side_words(children);
    let side = |number: usize| rest.get(number * length..)?.first_chunk::<4>().copied();
    let planes = [side(0)?, side(1)?, side(2)?, side(3)?, side(4)?, side(5)?];
    Some(Node { planes, anchor, step, links: [EMPTY; LANES] })
}

/// The ids of a leaf. None for an unused lane, whose link leads past the end.
#[inline(always)]
fn ids_at(words: &[u32], link: u32) -> Option<&[u32]> {
    let (place, count) = decoded(link);
    words.get(place..place + count)
}

/// Triangles in rows; zeros in unused lanes.
#[inline(always)]
fn gather(triangles: Mesh<'_>, ids: &[u32]) -> Leaf {
    let mut leaf = Leaf::default();
    for (lane, &id) in ids.iter().enumerate().take(LANES) {
        let triangle = triangles.get(id).unwrap_or_default();
        let corners = [triangle.a, triangle.b, triangle.c].into_iter();
        for (row, number) in leaf.iter_mut().zip(corners.flat_map(|corner| corner.to_array())) {
            row[lane] = number.to_bits();
        }
    }
    leaf
}

/// The largest component of the edges at corner a.
#[inline(always)]
fn longest_edge(leaf: &Leaf) -> f32 {
    let length = |at: usize| (Eight::of(&leaf[at]) - Eight::of(&leaf[at % 3])).abs();
    (4..9).fold(length(3), |longest, at| longest.larger(length(at))).largest()
}

impl Form for Ids {
    const NAME: &'static str = "lean-octree";
    const HIERARCHY_NAME: &'static str = "lean-octree-hierarchy";
    const KIND: u32 = 11;
    const HOLDS_TRIANGLES: bool = false;
    const ZEROS: usize = WINDOW;
    const PLACE: u32 = (1 << COUNT_SHIFT) - 1;

    fn write_node(node: &Node, children: usize, place: usize, words: &mut Words<'_>) -> u32 {
        let scale = node.anchor.into_iter().chain(node.step).map(f32::to_bits);
        let length = side_words(children);
        let planes = node.planes.iter().flat_map(|side| side.iter().take(length)).copied();
        let links = node.links.iter().take(children).copied();
        for (place, word) in (place..).zip(scale.chain(planes).chain(links)) {
            words.set(place, word);
        }
        (children as u32).saturating_sub(1) << COUNT_SHIFT | place as u32
    }

    fn node_words(children: usize) -> usize {
        SCALE_WORDS + 6 * side_words(children) + children
    }

    fn node_at(words: &[u32], link: u32) -> Option<(Node, usize)> {
        let mut node = boxes_at(words, link)?;
        let (_, children) = decoded(link);
        for (lane, slot) in node.links.iter_mut().enumerate().take(children) {
            *slot = Self::child(words, link, lane)?;
        }
        Some((node, Self::node_words(children)))
    }

    #[inline(always)]
    fn meet_node<L: Unpack>(words: &[u32], link: u32, ray: &LaneRay, last: f32) -> Option<L::Keys> {
        let keys = L::meet_node(&boxes_at(words, link)?, ray, last);
        Some(L::first(keys, decoded(link).1))
    }

    #[inline(always)]
    fn child(words: &[u32], link: u32, lane: usize) -> Option<u32> {
        let (place, children) = decoded(link);
        words.get(place + SCALE_WORDS + 6 * side_words(children) + lane).copied()
    }

    fn write(_: Mesh<'_>, ids: impl Iterator<Item = u32>, words: &mut Words<'_>) -> u32 {
        let place = words.len();
        for id in ids {
            words.push(id);
        }
        let count = (words.len() - place) as u32;
        LEAF | count.saturating_sub(1) << COUNT_SHIFT | place as u32
    }

    #[inline(always)]
    fn decide<Q: Query>(tree: Packed<'_, Self>, link: u32, query: &mut Q) -> ControlFlow<()> {
        let Some(ids) = ids_at(tree.words, link) else { return ControlFlow::Continue(()) };
        query.count_tests(ids.len() as u32);
        for &id in ids {
            query.decide(TriangleId(id), &tree.triangles.get(id).unwrap_or_default())?;
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn test<L: Unpack, Q: Query>(
        tree: Packed<'_, Self>,
        link: u32,
        ray: &LaneRay,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let Some(ids) = ids_at(tree.words, link) else { return ControlFlow::Continue(()) };
        query.count_tests(ids.len() as u32);
        let leaf = gather(tree.triangles, ids);
        let edge = longest_edge(&leaf);
        let candidates = L::meet_triangles(&leaf, ray, edge, finite(query.last_t()));
        let id = |lane| TriangleId(ids.get(lane).copied().unwrap_or(0));
        let triangle = |lane| (id(lane), triangle_at(&leaf, lane));
        let judge = |triangle: &Triangle, last| L::judge(triangle, ray, last);
        L::decide_each(candidates & ((1 << ids.len()) - 1), query, triangle, judge)
    }

    fn check(words: &[u32], link: u32, triangle_count: u32) -> Option<(usize, u32)> {
        let ids = ids_at(words, link)?;
        ids.iter().all(|&id| id < triangle_count).then_some((ids.len(), ids.len() as u32))
    }
}
