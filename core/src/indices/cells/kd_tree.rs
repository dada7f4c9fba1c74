//! The kd-tree: each cell is divided by the plane of least estimated cost (SAH), as long as that is better than not
//! dividing.
//!
//! # Source
//! J. D. MacDonald, K. S. Booth, *Heuristics for Ray Tracing Using Space Subdivision*, 1990.

use super::filing::Cell;
use super::plane_tree::{Plane, PlanePolicy, PlaneTree};
use super::split_cost::{CellAxis, SPLIT_LOOKS, best_split};
use crate::input::CostModel;
use crate::structure::{Described, Group, Weights};

/// Kd-tree, over the whole scene or, in a hierarchy, over a cluster.
pub type KdTree = PlaneTree<LeastCostPlane>;

/// Policy of the kd-tree: the plane with the fewest estimated tests.
pub enum LeastCostPlane {}

impl PlanePolicy for LeastCostPlane {
    const PAYS_BY_ITSELF: bool = true;
    const LOOKS: u64 = 3 * SPLIT_LOOKS;

    fn choose(
        group: &Group<'_>,
        ids: &[u32],
        cell: &Cell,
        _: u32,
        model: &CostModel,
    ) -> Option<Plane> {
        let mut best: Option<(f64, Plane)> = None;
        for axis in 0..3 {
            if let Some(split) = best_split(&CellAxis { number: axis, cell, group, ids }, model)
                && best.is_none_or(|(cost, _)| split.cost < cost)
            {
                best = Some((split.cost, Plane { axis, at: split.plane }));
            }
        }
        best.map(|(_, plane)| plane)
    }
}

impl Described for KdTree {
    const NAME: &'static str = "kd-tree";
    const HIERARCHY_NAME: &'static str = "kd-tree-hierarchy";
    const FORMAT: u32 = 4;
    const COST: CostModel = CostModel::tests_per_node(2.5);
    const WEIGHTS: Weights = Weights { ray: 7.8, node: 9.8, test: 2.4 }; // +-14%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 68_619.0, node: 2_677.0, test: 1_942.0 }; // +-4%
}
