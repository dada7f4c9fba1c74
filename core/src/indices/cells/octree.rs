//! The octree: cells are halved along all three axes until few triangles are left in each.
//!
//! The planes follow from the cell, so they are not stored. `octant_tree` has the rest.
//!
//! # Source
//! A. Glassner, *Space Subdivision for Fast Ray Tracing*, 1984; Revelles, Ureña and Lastra 2000.

use super::octant_tree::{OctantPolicy, OctantTree, Planes};
use super::tree_cell::Cell;
use crate::cost::Weights;
use crate::input::CostModel;
use crate::structure::{Described, Group, Local};

/// Octree, over the whole scene or, in the paper's octree hierarchy, over a cluster.
pub type Octree = OctantTree<Halving>;

/// Policy of the octree: the midpoints of all three axes.
pub enum Halving {}

impl OctantPolicy for Halving {
    const AXES: u32 = 0;
    const LOOKS: u64 = 0;

    fn choose(_: &Group<'_>, _: &[u32], cell: &Cell, _: &CostModel) -> Planes {
        let middle = cell.midpoint();
        let divisible =
            (0..3).all(|axis| cell.lo[axis] < middle[axis] && middle[axis] < cell.hi[axis]);
        if divisible { middle.map(Some) } else { [None; 3] }
    }

    #[inline]
    fn planes(_: &Local<'_>, _: u32, _: u32, cell: &Cell) -> Planes {
        cell.midpoint().map(Some)
    }
}

impl Described for Octree {
    const NAME: &'static str = "octree";
    const HIERARCHY_NAME: &'static str = "octree-hierarchy";
    const FORMAT: u32 = 2;
    const COST: CostModel = CostModel::tests_per_node(3.0);
    const WEIGHTS: Weights = Weights { ray: 23.4, node: 69.6, test: 23.6 }; // +-19%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 37_692.0, node: 44_729.0, test: 1_934.0 }; // +-7%
}
