//! The BSP tree: cells are halved at the midpoint, the axes in turn.
//!
//! An axis on which the cell is flat is skipped.
//!
//! # Source
//! K. Sung, P. Shirley, *Ray Tracing with the BSP Tree*, 1992.

use super::filing::Cell;
use super::plane_tree::{Plane, PlanePolicy, PlaneTree};
use crate::input::CostModel;
use crate::structure::{Described, Group, Weights};

/// BSP tree, over the whole scene or, in a hierarchy, over a cluster.
pub type BspTree = PlaneTree<AxesInTurn>;

/// Policy of the BSP tree: the midpoint, the axes in turn.
pub enum AxesInTurn {}

impl PlanePolicy for AxesInTurn {
    const PAYS_BY_ITSELF: bool = false;
    const LOOKS: u64 = 0;

    fn choose(_: &Group<'_>, _: &[u32], cell: &Cell, depth: u32, _: &CostModel) -> Option<Plane> {
        let middle = cell.midpoint();
        (0..3).find_map(|turn| {
            let axis = (depth as usize + turn) % 3;
            let (lo, hi) = (*cell.lo.get(axis)?, *cell.hi.get(axis)?);
            let at = *middle.get(axis)? as f32;
            let inside = lo < f64::from(at) && f64::from(at) < hi;
            inside.then_some(Plane { axis, at })
        })
    }
}

impl Described for BspTree {
    const NAME: &'static str = "bsp-tree";
    const HIERARCHY_NAME: &'static str = "bsp-tree-hierarchy";
    const FORMAT: u32 = 5;
    const COST: CostModel = CostModel::tests_per_node(1.5);
    const WEIGHTS: Weights = Weights { ray: 7.8, node: 7.8, test: 2.9 }; // +-20%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 69_413.0, node: 2_149.0, test: 1_942.0 }; // +-2%
}
