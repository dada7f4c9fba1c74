//! The octree: cells are halved along all three axes until few triangles are left in each.
//!
//! An axis on which a cell is short, as [`Options::least_side`] says, is left undivided. The planes follow from the
//! cell, so they are not stored. `octant_tree` has the rest.
//!
//! # Measured
//! Nodes and tests a photon ray, and relative times of single octrees, with a root that is a cube (as before) and with
//! the group's box and least sides of 0, a quarter, a third and a half:
//! - figure 4(b): 11.3 and 19.3 in the cube; 14.4 and 18.2, 10.0 and 14.5, 10.0 and 14.5, 10.6 and 16.8; times 1, 1.1,
//!   0.9, 0.9, 1;
//! - city: 13.7 and 17.7 in the cube; 28.6 and 57.1, 15.2 and 24.5, 13.7 and 19.8, 13.7 and 19.8;
//! - hierarchies of teapots and meshes: equal within 3%.
//!
//! # Source
//! A. Glassner, *Space Subdivision for Fast Ray Tracing*, 1984; Revelles, Ureña and Lastra 2000.

use glam::Vec4;

use super::filing::Planes;
use super::filing::{Cell, midpoints};
use super::octant_tree::{AXES_SHIFT, OctantPolicy, OctantTree};
use crate::input::{CostModel, Options};
use crate::structure::{Described, Group, Local, Weights};

/// Octree, over the whole scene or, in the paper's octree hierarchy, over a cluster.
pub type Octree = OctantTree<Halving>;

/// Policy of the octree: the midpoints of all three axes.
pub enum Halving {}

impl OctantPolicy for Halving {
    const STORES_PLANES: bool = false;
    const LOOKS: u64 = 0;

    fn choose(_: &Group<'_>, _: &[u32], cell: &Cell, options: &Options) -> Planes {
        let middle = cell.midpoint();
        let sides = [0, 1, 2].map(|axis| cell.hi[axis] - cell.lo[axis]);
        let longest = sides.into_iter().fold(0.0, |a, b| if b > a { b } else { a });
        let mut planes = [None; 3];
        for (axis, plane) in planes.iter_mut().enumerate() {
            let inside = cell.lo[axis] < middle[axis] && middle[axis] < cell.hi[axis];
            let is_long = sides[axis] >= longest * f64::from(options.least_side);
            *plane = (inside && is_long).then_some(middle[axis]);
        }
        planes
    }

    #[inline]
    fn planes(_: &Local<'_>, _: u32, head: u32, (lo, hi): (Vec4, Vec4)) -> Vec4 {
        midpoints(lo, hi) + NOWHERE[(head >> AXES_SHIFT) as usize % NOWHERE.len()]
    }
}

/// For each set of divided axes: 0 on these, NaN on the others.
const NOWHERE: [Vec4; 8] = {
    let mut sets = [Vec4::NAN; 8];
    let mut set = 0;
    while set < 8 {
        sets[set] = Vec4::new(
            if set & 1 != 0 { 0.0 } else { f32::NAN },
            if set & 2 != 0 { 0.0 } else { f32::NAN },
            if set & 4 != 0 { 0.0 } else { f32::NAN },
            0.0,
        );
        set += 1;
    }
    sets
};

impl Described for Octree {
    const NAME: &'static str = "octree";
    const HIERARCHY_NAME: &'static str = "octree-hierarchy";
    const FORMAT: u32 = 12;
    const COST: CostModel = CostModel::tests_per_node(5.0);
    const WEIGHTS: Weights = Weights { ray: 7.9, node: 12.6, test: 4.0 }; // +-17%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 68_843.0, node: 4_305.0, test: 1_942.0 }; // +-4%
}
