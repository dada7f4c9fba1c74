//! The BSP tree: cells halved in the middle, the axes in turn.
//!
//! An axis on which the cell is flat is passed over.
//!
//! # Source
//! K. Sung, P. Shirley, *Ray Tracing with the BSP Tree*, 1992.

use super::cell::Cell;
use super::plane_tree::{Division, Plane, PlaneTree};
use super::{Group, forward_local_index};
use crate::auto::CostModel;

/// The BSP tree, alone or as the local index of a hierarchy.
pub enum BspTree {}

impl Division for BspTree {
    const PAYS_BY_ITSELF: bool = false;
    const LOOKS: u64 = 0;

    fn choose(_: &Group<'_>, _: &[u32], cell: &Cell, depth: u32, _: &CostModel) -> Option<Plane> {
        let middle = cell.middle();
        (0..3).find_map(|turn| {
            let axis = (depth as usize + turn) % 3;
            let (lo, hi) = (*cell.lo.get(axis)?, *cell.hi.get(axis)?);
            let at = *middle.get(axis)? as f32;
            let inside = lo < f64::from(at) && f64::from(at) < hi;
            inside.then_some(Plane { axis, at })
        })
    }
}

forward_local_index!(BspTree, PlaneTree, 5, "bsp-tree", 1.5);
