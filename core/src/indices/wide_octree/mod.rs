//! The wide octree: nodes of up to eight boxes, tested at once, over leaves of up to eight triangles.
//!
//! ```text
//! words:  rows of eight words; row 0: the root's link, zeros
//! node:   lo.x[8] | lo.y[8] | lo.z[8] | hi.x[8] | hi.y[8] | hi.z[8] | links[8]
//! leaf:   a.x[8] | a.y[8] | a.z[8] | b.x[8] | ... | c.z[8] | ids[8]
//! link:   leaf bit | triangles - 1 (3 bits) | row (28 bits); 0 for no child
//! ```
//! Each triangle lies in one leaf, and a node divides its triangles where the estimated tests are
//! fewest: an octant split where all three axes pay, and an axis left alone, or divided twice, where
//! that pays more. Lanes without a child have an empty box.
//!
//! Boxes and triangles are tested in `f32` with derived margins (see `lanes`); whatever a margin
//! cannot exclude is decided by the exact kernel.
//!
//! # Source
//! H. Dammertz, J. Hanika, A. Keller, *Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of
//! Incoherent Rays*, 2008; I. Wald, C. Benthin, S. Boulos, *Getting Rid of Packets*, 2008.

// Forced, because the walk must be compiled for the instructions of its lanes, not called from there.
#![allow(clippy::inline_always)]

#[cfg(target_arch = "x86_64")]
mod avx2;
mod build;
mod lanes;
mod walk;

use core::ops::ControlFlow;

use super::{Group, Local, LocalIndex, Statistics};
use crate::geometry::{RaySpan, Span};
use crate::memory::Words;
use crate::query::Query;
use crate::{BuildError, Options};

/// The wide octree, alone or as the local index of a hierarchy.
pub enum WideOctree {}

/// Eight words; a row of a node or of a leaf.
type Row = [u32; LANES];

const LANES: usize = 8;
const NODE_ROWS: u32 = 7;
const LEAF_ROWS: u32 = 10;
const LINKS_ROW: usize = 6;
const IDS_ROW: usize = 9;

const LEAF: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 28;
const ROW_MASK: u32 = (1 << COUNT_SHIFT) - 1;
const EMPTY: u32 = 0;
/// An unused lane of a leaf.
const NO_ID: u32 = u32::MAX;

/// From here on triangles are divided into equal parts, which needs at most 10 more levels.
const BALANCED_FROM: u32 = 20;
const MAX_DEPTH: u32 = 32;
/// Each node replaces itself by at most eight.
const STACK: usize = MAX_DEPTH as usize * (LANES - 1) + 1;

fn leaf_link(row: u32, count: u32) -> u32 {
    LEAF | (count - 1) << COUNT_SHIFT | row
}

fn leaf_count(link: u32) -> u32 {
    (link >> COUNT_SHIFT & 7) + 1
}

/// The words as rows.
fn rows<'a>(local: &Local<'a>) -> &'a [Row] {
    bytemuck::try_cast_slice(local.words).unwrap_or(&[])
}

/// The rows of a node.
#[inline]
fn node_at(rows: &[Row], link: u32) -> Option<&[Row; NODE_ROWS as usize]> {
    let row = (link & ROW_MASK) as usize;
    rows.get(row..row + NODE_ROWS as usize)?.try_into().ok()
}

/// The rows of a leaf.
#[inline]
fn leaf_at(rows: &[Row], link: u32) -> Option<&[Row; LEAF_ROWS as usize]> {
    let row = (link & ROW_MASK) as usize;
    rows.get(row..row + LEAF_ROWS as usize)?.try_into().ok()
}

impl LocalIndex for WideOctree {
    const NAME: &'static str = "wide-octree";
    const HIERARCHY_NAME: &'static str = "wide-octree-hierarchy";
    const KIND: u32 = 8;

    fn scratch_bytes(triangle_count: usize, _: &Options) -> usize {
        build::scratch_bytes(triangle_count)
    }

    fn build(
        group: &Group<'_>,
        _: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        build::build(group, words, scratch)
    }

    #[inline]
    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        walk::walk(local, ray, span, query)
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let rows = rows(local);
        let root = rows.first()?[0];
        let mut statistics = Statistics::default();
        let mut end = 1;
        let mut stack = heapless::Vec::<(u32, u32), STACK>::new();
        stack.push((root, 0)).ok()?;
        while let Some((link, depth)) = stack.pop() {
            // Depth-first order: each node begins where the one before ended.
            if link & ROW_MASK != end {
                return None;
            }
            if link & LEAF != 0 {
                let leaf = leaf_at(rows, link)?;
                let count = leaf_count(link);
                let (used, unused) = leaf[IDS_ROW].split_at_checked(count as usize)?;
                let known = used.iter().all(|&id| (id as usize) < local.triangles.len());
                if !known || unused.iter().any(|&id| id != NO_ID) {
                    return None;
                }
                statistics.add_leaf(count, depth);
                end += LEAF_ROWS;
            } else {
                let node = node_at(rows, link)?;
                if depth >= MAX_DEPTH {
                    return None;
                }
                statistics.inner_nodes += 1;
                end += NODE_ROWS;
                for &child in node[LINKS_ROW].iter().rev().filter(|&&child| child != EMPTY) {
                    stack.push((child, depth + 1)).ok()?;
                }
            }
        }
        (end as usize == rows.len()).then_some(statistics)
    }
}
