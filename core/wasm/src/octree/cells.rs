//! The cells of an octree down to a level.

use arboleda_ffi::parts::{Caller, Output, apart, borrowed, reported};
use arboleda_ffi::{arb_error, arb_index, arb_status};
use arrayvec::ArrayVec;

use super::{Cell, Node, Octrees, WAITING};
use crate::records::{NONE, Records, bits_of};

/// Words of a cell: lower corner, upper corner, cluster, level, triangles.
const CELL_WORDS: usize = 9;

/// Writes the cells of all octrees of an index, as if no cell below `level` were divided: the leaves above, and the
/// cells of that level. The root of each cluster is level 0. Cells in which no triangle is filed do not exist.
///
/// - `cells`: room for `capacity` records of 9 words: the box, the lower corner first; the number of the cluster; the
///   level; the number of triangles that are filed in the cell, `0xffff_ffff` if it is divided further.
/// - `cell_count`: receives the number of cells, also if there are more than `capacity`.
///
/// Cost: linear in the number of cells.
///
/// Errors: `ARB_INVALID_OPTION` if the index is neither an octree nor an octree-R, alone or in a hierarchy;
/// `ARB_NULL_POINTER`, `ARB_MISALIGNED_POINTER`, `ARB_LENGTH_OVERFLOW`, `ARB_OVERLAP`, `ARB_NOT_OPEN`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_octree_cells(
    index: *const arb_index,
    level: u32,
    cells: *mut u32,
    capacity: usize,
    cell_count: *mut usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let index = caller.index(index)?;
        let octrees = Octrees::of(index)?;
        let room = Output::check(cells, capacity.saturating_mul(CELL_WORDS), "cells")?;
        let count = Output::one(cell_count, "cell_count")?;
        apart(&[room.region(), count.region()], &borrowed(index))?;
        let mut records = Records::new(caller.borrow_mut(room));
        write(&octrees, level, &mut records);
        caller.write(count, records.count());
        Ok(())
    })
}

fn write(octrees: &Octrees<'_>, most_level: u32, records: &mut Records<'_, CELL_WORDS>) {
    for (number, cluster) in octrees.clusters() {
        let octree = octrees.octree(cluster);
        let mut waiting = ArrayVec::<(u32, Cell, u32), WAITING>::new();
        let mut next = Some((octree.root(), Cell::of(cluster), 0));
        while let Some((link, cell, level)) = next {
            let node = octree.node(link, &cell);
            match node {
                Node::Inner(inner) if level < most_level => {
                    for octant in (0..8).rev().filter(|octant| inner.mask >> octant & 1 == 1) {
                        let child =
                            (octree.child(&inner, octant), cell.child(&inner.planes, octant));
                        let pushed = waiting.try_push((child.0, child.1, level + 1)).is_ok();
                        debug_assert!(pushed, "opening bounds the depth");
                    }
                }
                _ => {
                    let (lo, hi) = cell.corners();
                    let [a, b, c, d, e, f] = bits_of(lo, hi);
                    let triangles = match node {
                        Node::Leaf(ids) => ids.len() as u32,
                        Node::Inner(_) => NONE,
                    };
                    records.push([a, b, c, d, e, f, number, level, triangles]);
                }
            }
            next = waiting.pop();
        }
    }
}
