//! Division of a cell by up to three planes, and the octants in which a triangle is filed: shared by all trees of cells.
//!
//! Octant bit 0 is set for the upper half in x, bit 1 in y, bit 2 in z. On an axis without a plane, the bit is 0.

use glam::Vec4;

use super::tree_cell::Cell;
use crate::geometry::{OctantFilter, Triangle, may_overlap};

/// Plane across each axis, a number that `f32` holds; `None` for an undivided axis.
pub type Planes = [Option<f64>; 3];

/// Octants that a triangle lies in.
#[derive(Clone, Copy)]
pub struct Placement {
    /// One bit for each octant.
    pub mask: u8,
    /// Steps that finding the octants takes: a look at the triangle, and one for each box to compare it with.
    pub steps: u32,
}

/// Cell that planes divide.
pub struct Division<'c> {
    cell: &'c Cell,
    planes: &'c Planes,
    /// The planes; NaN on an undivided axis.
    at: Vec4,
    filter: OctantFilter,
}

impl<'c> Division<'c> {
    pub fn new(cell: &'c Cell, planes: &'c Planes) -> Self {
        let [lo, hi] = [cell.lo, cell.hi].map(narrowed);
        let at = narrowed(planes.map(|plane| plane.unwrap_or(f64::NAN)));
        Self { cell, planes, at, filter: OctantFilter::new(lo, hi, at) }
    }

    /// Finds the octants in which a triangle is filed.
    pub fn place(&self, triangle: &Triangle) -> Placement {
        // 1. By extent. A triangle that only touches a plane is filed on its own side; one that lies in the plane, in
        // the lower half. On an axis without a plane, everything is in the lower half.
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|corner| corner.extend(0.0));
        let upper = a.max(b).max(c).cmpgt(self.at).bitmask();
        let lower = !upper | a.min(b).min(c).cmplt(self.at).bitmask();
        let mut mask = SUBSETS[upper as usize % 8] & SUPERSETS[!lower as usize % 8];
        if mask.is_power_of_two() {
            return Placement { mask, steps: 1 };
        }
        let steps = 1 + mask.count_ones();
        // 2. By the triangle's plane and edges: the filter, and the exact test where it is in doubt.
        let found = self.filter.judge(triangle);
        let mut doubtful = mask & !found.inside & !found.apart;
        mask &= !found.apart;
        while doubtful != 0 {
            let octant = doubtful.trailing_zeros();
            doubtful &= doubtful - 1;
            let child = self.cell.child(self.planes, octant);
            if !may_overlap(triangle, child.lo, child.hi) {
                mask &= !(1 << octant);
            }
        }
        Placement { mask, steps }
    }
}

/// The coordinates as `f32`, which holds them.
fn narrowed([x, y, z]: [f64; 3]) -> Vec4 {
    Vec4::new(x as f32, y as f32, z as f32, 0.0)
}

/// For each set of axes, the octants whose axes of the upper half are all in the set.
const SUBSETS: [u8; 8] = octants_by_axes(false);
/// For each set of axes, the octants that are in the upper half on all of them.
const SUPERSETS: [u8; 8] = octants_by_axes(true);

const fn octants_by_axes(hold_all: bool) -> [u8; 8] {
    let mut sets = [0; 8];
    let mut axes = 0;
    while axes < 8 {
        let mut octant = 0;
        while octant < 8 {
            let held = if hold_all { octant & axes == axes } else { octant & !axes == 0 };
            if held {
                sets[axes] |= 1 << octant;
            }
            octant += 1;
        }
        axes += 1;
    }
    sets
}
