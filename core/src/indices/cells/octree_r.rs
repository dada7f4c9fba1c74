//! The octree-R: cells are divided into up to eight at the planes with the fewest estimated tests.
//!
//! On each axis independently, the plane is chosen for which the sum of (surface of a half) * (number of triangles in
//! it) is least (SAH), out of 33. An axis on which no plane is better than none stays undivided, as flat scenes need.
//!
//! # Source
//! K.-Y. Whang et al., *Octree-R: An Adaptive Octree for Efficient Ray Tracing*, 1995. Deviations: an
//! axis may stay undivided; the planes are those between a fixed number of bins.

use glam::Vec4;

use super::filing::Cell;
use super::filing::Planes;
use super::octant_tree::{AXES_SHIFT, OctantPolicy, OctantTree};
use super::split_cost::{CellAxis, SPLIT_LOOKS, best_split};
use crate::input::{CostModel, Options};
use crate::structure::{Described, Group, Local, Weights};

/// Octree-R, over the whole scene or, in a hierarchy, over a cluster.
pub type OctreeR = OctantTree<LeastCostOctants>;

/// Policy of the octree-R: on each axis the plane with the fewest estimated tests.
pub enum LeastCostOctants {}

impl OctantPolicy for LeastCostOctants {
    const STORES_PLANES: bool = true;
    const LOOKS: u64 = 3 * SPLIT_LOOKS;

    fn choose(group: &Group<'_>, ids: &[u32], cell: &Cell, options: &Options) -> Planes {
        let model = &options.cost_model();
        let mut planes = [None; 3];
        for (axis, plane) in planes.iter_mut().enumerate() {
            let axis = CellAxis { number: axis, cell, group, ids };
            *plane = best_split(&axis, model).map(|split| f64::from(split.plane));
        }
        planes
    }

    #[inline]
    fn planes(local: &Local<'_>, offset: u32, head: u32, _: (Vec4, Vec4)) -> Vec4 {
        let mut next = offset;
        let mut plane = |axis: u32| {
            if head >> (axis + AXES_SHIFT) & 1 == 0 {
                return f32::NAN;
            }
            next += 1;
            f32::from_bits(local.word(next))
        };
        Vec4::new(plane(0), plane(1), plane(2), f32::NAN)
    }
}

impl Described for OctreeR {
    const NAME: &'static str = "octree-r";
    const HIERARCHY_NAME: &'static str = "octree-r-hierarchy";
    const FORMAT: u32 = 3;
    const COST: CostModel = CostModel::tests_per_node(4.0);
    const WEIGHTS: Weights = Weights { ray: 7.9, node: 11.9, test: 4.0 }; // +-15%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 68_822.0, node: 4_440.0, test: 1_942.0 }; // +-6%
}
