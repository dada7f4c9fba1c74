//! Leaves: runs of lanes in eight of them, which those of one node share where they fit.
//!
//! All eight are tested at once, however many are asked for. So small leaves cost no room of their own, and side by
//! side they lie on the same lines of the cache: a city takes 54 bytes a triangle instead of 56, the boxes of
//! figure 3, whose twelve triangles are leaves of two, two and eight, 51 instead of 85.

use core::ops::Range;

use super::{IDS_ROW, LANES, LEAF, LEAF_ROWS, NO_ID, ROW_MASK, Row};
use crate::{Triangle, Vec3};

/// Eight lanes: the corners of triangles, and their ids.
pub(in crate::indices) type Leaf = [Row; LEAF_ROWS as usize];

pub(super) const EMPTY_LEAF: Leaf = {
    let mut leaf = [[0; LANES]; LEAF_ROWS as usize];
    leaf[IDS_ROW] = [NO_ID; LANES];
    leaf
};

const COUNT_SHIFT: u32 = 28;
/// The bits of an edge that say in which lane the leaf begins.
const LANE_MASK: u32 = LANES as u32 - 1;

/// The link to a leaf, and what there is to say of it: its longest edge, rounded up to a number whose last bits say
/// in which lane it begins.
pub(super) fn leaf_link(row: u32, lanes: Range<usize>, longest_edge: f32) -> [u32; 2] {
    let count = lanes.len() as u32;
    let edge = longest_edge.to_bits().saturating_add(LANE_MASK) & !LANE_MASK;
    [LEAF | count.saturating_sub(1) << COUNT_SHIFT | row, edge | lanes.start as u32 & LANE_MASK]
}

/// How many triangles a leaf has.
#[inline(always)]
pub(super) fn leaf_count(link: u32) -> u32 {
    (link >> COUNT_SHIFT & 7) + 1
}

/// In which lane it begins.
#[inline(always)]
pub(super) fn first_lane(edge: u32) -> u32 {
    edge & LANE_MASK
}

/// The rows that a leaf lies in.
#[inline]
pub(super) fn leaf_at(rows: &[Row], link: u32) -> Option<&Leaf> {
    let row = (link & ROW_MASK) as usize;
    rows.get(row..row + LEAF_ROWS as usize)?.try_into().ok()
}

/// Puts a triangle where [`triangle_at`] finds it.
#[inline(always)]
pub(in crate::indices) fn set_triangle(leaf: &mut Leaf, lane: usize, triangle: &Triangle) {
    let Triangle { a, b, c } = triangle;
    let numbers = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z];
    for (row, number) in leaf.iter_mut().zip(numbers) {
        row[lane % LANES] = number.to_bits();
    }
}

#[inline(always)]
pub(super) fn triangle_at(leaf: &Leaf, lane: usize) -> Triangle {
    let lane = lane % LANES;
    let number = |row: usize| f32::from_bits(leaf[row][lane]);
    let corner = |row: usize| Vec3::new(number(row), number(row + 1), number(row + 2));
    Triangle::new(corner(0), corner(3), corner(6))
}

/// Puts the leaves of one node side by side, each where there is room first.
#[derive(Clone, Copy, Default)]
pub(super) struct Packing {
    /// Of each eight lanes, how many are taken.
    taken: [usize; LANES],
}

impl Packing {
    /// Of leaves of so many triangles.
    pub fn of(counts: impl Iterator<Item = usize>) -> Self {
        let mut packing = Self::default();
        for count in counts {
            packing.place(count);
        }
        packing
    }

    /// Room for a leaf of so many triangles: the number of the eight lanes, and which of them.
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

    /// Of each eight lanes, those that are not taken.
    pub fn unused(&self) -> impl Iterator<Item = Range<usize>> {
        self.taken.iter().filter(|&&taken| taken > 0).map(|&taken| taken..LANES)
    }

    /// The rows of all.
    pub fn rows(&self) -> u32 {
        self.taken.iter().filter(|&&taken| taken > 0).count() as u32 * LEAF_ROWS
    }
}
