//! The kd-tree: each cell divided by the plane for which the estimated tests are fewest, as long as
//! that is better than not dividing.
//!
//! # Source
//! J. D. MacDonald, K. S. Booth, *Heuristics for Ray Tracing Using Space Subdivision*, 1990.

use super::cell::Cell;
use super::plane_tree::{Division, Plane, PlaneTree};
use super::split_cost::{Axis, SPLIT_LOOKS, best_split};
use super::{Group, forward_local_index};
use crate::auto::CostModel;

/// The kd-tree, alone or as the local index of a hierarchy.
pub enum KdTree {}

impl Division for KdTree {
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
            if let Some(split) = best_split(&Axis { number: axis, cell, group, ids }, model)
                && best.is_none_or(|(cost, _)| split.cost < cost)
            {
                best = Some((split.cost, Plane { axis, at: split.plane }));
            }
        }
        best.map(|(_, plane)| plane)
    }
}

forward_local_index!(KdTree, PlaneTree, 4, "kd-tree", 1.3);
