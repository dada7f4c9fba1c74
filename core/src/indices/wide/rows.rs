//! Rows of eight words, of which nodes and leaves consist: structure of arrays (SoA), one lane for each box or
//! triangle.
//!
//! ```text
//! node:   lo.x[8] | hi.x[8] | lo.y[8] | hi.y[8] | lo.z[8] | hi.z[8] | links[8] | edges[8]
//! leaf:   a.x[8] | a.y[8] | a.z[8] | b.x[8] | ... | c.z[8] | ids[8], of one child of a node or of several
//! link:   leaf bit | triangles - 1 (3 bits) | row (28 bits); 0 for no child
//! edge:   of a leaf, the largest component of its triangles' edges at corner a, or more; in the last 3 bits the
//!         lane of its first triangle
//! ```
//! A leaf is a run of lanes. Leaves of one node share the eight lanes of a leaf's rows where they fit. All eight lanes
//! are tested at once, however many are used. So small leaves take no rows of their own, and side by side they lie on
//! the same cache lines.
//!
//! # Measured
//! - A city takes 54 bytes a triangle instead of 56 without sharing.
//! - In figure 3, the twelve triangles of a box are three leaves, of two, two and eight: 51 bytes a triangle, 85
//!   without sharing.
//!
//! # Why `% LANES` and `% 3`
//! The reduction makes the index of a lane (or of an axis) provably smaller than the array's length. So the compiler
//! leaves out the bounds check, and no panic path is left. The value does not change, since it is in range already. By
//! 8 the reduction is at most an `and`; by 3 it disappears where the loop over the axes is unrolled. The same holds for
//! `% 4`, `% N` and `% CHUNK_WORDS` in this family.

use core::ops::Range;

use crate::Vec3;
use crate::geometry::Triangle;
pub(crate) use crate::simd::{LANES, LEAF_ROWS, LeafRows, NODE_ROWS, Node, Row};

pub(crate) const LINKS_ROW: usize = 6;
pub(crate) const EDGES_ROW: usize = 7;
pub(crate) const IDS_ROW: usize = 9;

/// The bit of a link that leads to a leaf.
pub(crate) const LEAF_BIT: u32 = 1 << 31;
pub(crate) const ROW_MASK: u32 = (1 << 28) - 1;
/// The link of a lane without a child.
pub(crate) const EMPTY: u32 = 0;
/// The id in an unused lane of a leaf.
pub(crate) const NO_ID: u32 = u32::MAX;

/// A leaf's rows with all lanes unused.
pub(crate) const EMPTY_LEAF: LeafRows = {
    let mut leaf = [[0; LANES]; LEAF_ROWS as usize];
    leaf[IDS_ROW] = [NO_ID; LANES];
    leaf
};

const COUNT_SHIFT: u32 = 28;
/// The bits of an edge that hold the first lane of the leaf.
const LANE_MASK: u32 = LANES as u32 - 1;

/// Makes the link to a leaf, and its edge: the longest edge, rounded up to a number whose last bits are the leaf's
/// first lane.
pub(crate) fn leaf_link(row: u32, lanes: Range<usize>, longest_edge: f32) -> [u32; 2] {
    let count = lanes.len() as u32;
    let edge = longest_edge.to_bits().saturating_add(LANE_MASK) & !LANE_MASK;
    [LEAF_BIT | count.saturating_sub(1) << COUNT_SHIFT | row, edge | lanes.start as u32 & LANE_MASK]
}

/// The number of triangles of a leaf.
#[inline(always)]
pub(crate) fn leaf_count(link: u32) -> u32 {
    (link >> COUNT_SHIFT & 7) + 1
}

/// The first lane of a leaf.
#[inline(always)]
pub(crate) fn first_lane(edge: u32) -> u32 {
    edge & LANE_MASK
}

/// The rows of a node.
#[inline]
pub(crate) fn node_at(rows: &[Row], link: u32) -> Option<&Node> {
    let row = link as usize;
    rows.get(row..row.checked_add(NODE_ROWS as usize)?)?.try_into().ok()
}

/// The rows in which a leaf lies.
#[inline]
pub(crate) fn leaf_at(rows: &[Row], link: u32) -> Option<&LeafRows> {
    let row = (link & ROW_MASK) as usize;
    rows.get(row..row + LEAF_ROWS as usize)?.try_into().ok()
}

/// Writes a triangle into a lane, where [`triangle_at`] reads it.
#[inline(always)]
pub(crate) fn set_triangle(leaf: &mut LeafRows, lane: usize, triangle: &Triangle) {
    let Triangle { a, b, c } = triangle;
    let numbers = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z];
    for (row, number) in leaf.iter_mut().zip(numbers) {
        row[lane % LANES] = number.to_bits();
    }
}

#[inline(always)]
pub(crate) fn triangle_at(leaf: &LeafRows, lane: usize) -> Triangle {
    let lane = lane % LANES;
    let number = |row: usize| f32::from_bits(leaf[row][lane]);
    let corner = |row: usize| Vec3::new(number(row), number(row + 1), number(row + 2));
    Triangle::new(corner(0), corner(3), corner(6))
}

/// Packing of the leaves of one node side by side: first fit.
#[derive(Clone, Copy, Default)]
pub(crate) struct Packing {
    /// The number of lanes taken in each leaf's rows.
    taken: [usize; LANES],
}

impl Packing {
    /// Packs leaves of these numbers of triangles.
    pub fn of(counts: impl Iterator<Item = usize>) -> Self {
        let mut packing = Self::default();
        for count in counts {
            packing.place(count);
        }
        packing
    }

    /// Finds room for a leaf of `count` triangles: the index of the leaf's rows, and the lanes in them.
    pub fn place(&mut self, count: usize) -> (usize, Range<usize>) {
        let fits = |taken: &&mut usize| **taken + count <= LANES;
        let Some((number, taken)) =
            self.taken.iter_mut().enumerate().find(|(_, taken)| fits(taken))
        else {
            debug_assert!(false, "a node has at most eight leaves of at most eight");
            return (0, 0..0);
        };
        let first = *taken;
        *taken += count;
        (number, first..*taken)
    }

    /// The unused lanes of each leaf's rows.
    pub fn unused(&self) -> impl Iterator<Item = Range<usize>> {
        self.taken.iter().filter(|&&taken| taken > 0).map(|&taken| taken..LANES)
    }

    /// The number of rows that all leaves take.
    pub fn rows(&self) -> u32 {
        self.taken.iter().filter(|&&taken| taken > 0).count() as u32 * LEAF_ROWS
    }
}
