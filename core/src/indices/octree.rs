//! The octree: cells halved along all three axes until few triangles are left in each.
//!
//! The planes follow from the cell, so they are not stored. See `octants` for the rest.
//!
//! # Source
//! A. Glassner, *Space Subdivision for Fast Ray Tracing*, 1984; Revelles, Ureña and Lastra 2000.

use super::cell::Cell;
use super::octants::{Division, Octants, Planes};
use super::{Group, Local, forward_local_index};
use crate::auto::CostModel;

/// The octree, alone or as the local index of the octree hierarchy.
pub enum Octree {}

impl Division for Octree {
    const AXES: u32 = 0;
    const LOOKS: u64 = 0;

    fn choose(_: &Group<'_>, _: &[u32], cell: &Cell, _: &CostModel) -> Planes {
        let middle = cell.middle();
        let divisible =
            (0..3).all(|axis| cell.lo[axis] < middle[axis] && middle[axis] < cell.hi[axis]);
        if divisible { middle.map(Some) } else { [None; 3] }
    }

    #[inline]
    fn planes(_: &Local<'_>, _: u32, _: u32, cell: &Cell) -> Planes {
        cell.middle().map(Some)
    }
}

forward_local_index!(Octree, Octants, 2, "octree", 3.0);
