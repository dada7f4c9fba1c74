//! The octree-R: cells are divided into up to eight at the planes with the fewest estimated tests.
//!
//! On each axis independently, the plane is chosen for which the sum of (surface of a half) * (number of triangles in
//! it) is least (SAH), out of 33. An axis on which no plane is better than none stays undivided, as flat scenes need.
//!
//! # Source
//! K.-Y. Whang et al., *Octree-R: An Adaptive Octree for Efficient Ray Tracing*, 1995. Deviations: an
//! axis may stay undivided; the planes are those between a fixed number of bins.

use super::octant_tree::{OctantPolicy, OctantTree, Planes};
use super::split_cost::{CellAxis, SPLIT_LOOKS, best_split};
use super::tree_cell::Cell;
use crate::cost::Weights;
use crate::input::CostModel;
use crate::structure::{Described, Group, Local};

/// Octree-R, over the whole scene or, in a hierarchy, over a cluster.
pub type OctreeR = OctantTree<LeastCostOctants>;

/// Policy of the octree-R: on each axis the plane with the fewest estimated tests.
pub enum LeastCostOctants {}

impl OctantPolicy for LeastCostOctants {
    const AXES: u32 = 0b111 << 8;
    const LOOKS: u64 = 3 * SPLIT_LOOKS;

    fn choose(group: &Group<'_>, ids: &[u32], cell: &Cell, model: &CostModel) -> Planes {
        let mut planes = [None; 3];
        for (axis, plane) in planes.iter_mut().enumerate() {
            let axis = CellAxis { number: axis, cell, group, ids };
            *plane = best_split(&axis, model).map(|split| f64::from(split.plane));
        }
        planes
    }

    #[inline]
    fn planes(local: &Local<'_>, offset: u32, head: u32, _: &Cell) -> Planes {
        let mut next = offset + 1;
        let mut planes = [None; 3];
        for (axis, plane) in planes.iter_mut().enumerate() {
            if head >> (axis + 8) & 1 == 1 {
                *plane = Some(f64::from(f32::from_bits(local.word(next))));
                next += 1;
            }
        }
        planes
    }
}

impl Described for OctreeR {
    const NAME: &'static str = "octree-r";
    const HIERARCHY_NAME: &'static str = "octree-r-hierarchy";
    const FORMAT: u32 = 3;
    const COST: CostModel = CostModel::tests_per_node(3.0);
    const WEIGHTS: Weights = Weights { ray: 24.4, node: 64.0, test: 22.6 }; // +-21%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 36_948.0, node: 42_411.0, test: 1_934.0 }; // +-8%
}
