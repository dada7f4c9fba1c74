//! Kinds of index by their numbers.

use core::ffi::{CStr, c_char};

use arboleda::IndexKind;

use crate::error::Failure;

/// Kind of an index. The numbers are stable: none is ever used again for another kind.
///
/// If in doubt: ARB_WIDE_BVH for speed, ARB_BVH on a small device, ARB_LEAN_BVH beside a mesh that is kept anyway.
///
/// All kinds give the same hits, bit for bit; they differ in time and memory. A "hierarchy" divides the scene into
/// clusters first, and has one index for each. A library may be built without some kinds; see ARB_KIND_LEFT_OUT.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum arb_kind {
    /// Every triangle, one after the other: for some dozen triangles. 40 bytes a triangle.
    ARB_LINEAR = 0,
    /// Octree.
    ARB_OCTREE = 1,
    /// One octree for each cluster: few nodes a ray if groups are far apart. About 41 bytes a triangle.
    ARB_OCTREE_HIERARCHY = 2,
    /// Octree whose cells are divided where it costs least.
    ARB_OCTREE_R = 3,
    /// One octree-R for each cluster.
    ARB_OCTREE_R_HIERARCHY = 4,
    /// Grid of equal cells.
    ARB_UNIFORM_GRID = 5,
    /// One grid for each cluster.
    ARB_GRID_HIERARCHY = 6,
    /// Kd-tree.
    ARB_KD_TREE = 7,
    /// One kd-tree for each cluster.
    ARB_KD_TREE_HIERARCHY = 8,
    /// Tree of halved cells.
    ARB_BSP_TREE = 9,
    /// One such tree for each cluster.
    ARB_BSP_TREE_HIERARCHY = 10,
    /// Binary tree of boxes: the least code, for a small device. About 45 bytes a triangle.
    ARB_BVH = 11,
    /// One binary tree of boxes for each cluster.
    ARB_BVH_HIERARCHY = 12,
    /// Tree of eight boxes a node: the fastest. 50 to 55 bytes a triangle. It holds the triangles in a form of its own,
    /// and is not built beside a mesh.
    ARB_WIDE_BVH = 13,
    /// The same, over clusters.
    ARB_WIDE_BVH_HIERARCHY = 14,
    /// The same tree in 16-bit numbers: fast in little memory. 25 to 30 bytes a triangle. Not built beside a mesh.
    ARB_COMPACT_BVH = 15,
    /// The same, over clusters.
    ARB_COMPACT_BVH_HIERARCHY = 16,
    /// The same tree without triangles: the least memory beside a mesh, 7 to 10 bytes a triangle. Without a mesh beside
    /// it, the index has a copy of the triangles, 36 bytes each.
    ARB_LEAN_BVH = 17,
    /// The same, over clusters.
    ARB_LEAN_BVH_HIERARCHY = 18,
}

/// Names of the kinds, by number.
const NAMES: [&CStr; 19] = [
    c"linear",
    c"octree",
    c"octree-hierarchy",
    c"octree-r",
    c"octree-r-hierarchy",
    c"uniform-grid",
    c"grid-hierarchy",
    c"kd-tree",
    c"kd-tree-hierarchy",
    c"bsp-tree",
    c"bsp-tree-hierarchy",
    c"bvh",
    c"bvh-hierarchy",
    c"wide-bvh",
    c"wide-bvh-hierarchy",
    c"compact-bvh",
    c"compact-bvh-hierarchy",
    c"lean-bvh",
    c"lean-bvh-hierarchy",
];

/// The name of a kind, for example "wide-bvh"; "unknown" for a number that no kind has. A static string, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn arb_kind_name(kind: u32) -> *const c_char {
    NAMES.get(kind as usize).copied().unwrap_or(c"unknown").as_ptr()
}

/// Finds the kind of a number.
pub fn of_number(number: u32) -> Result<IndexKind, Failure> {
    match IndexKind::ALL.iter().find(|kind| **kind as u32 == number) {
        Some(kind) => Ok(*kind),
        None if (number as usize) < NAMES.len() => Err(Failure::KindLeftOut { number }),
        None => Err(Failure::UnknownKind { number }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::arb_status;

    #[test]
    fn numbers_and_names_are_those_of_the_core() {
        for &kind in IndexKind::ALL {
            let name = NAMES[kind as usize].to_str();
            assert_eq!(name, Ok(kind.name()));
            assert!(of_number(kind as u32).is_ok_and(|found| found == kind));
        }
        for number in 0..NAMES.len() as u32 {
            let is_here = IndexKind::ALL.iter().any(|kind| *kind as u32 == number);
            let failure = of_number(number).err().map(|failure| failure.status());
            assert_eq!(failure, (!is_here).then_some(arb_status::ARB_KIND_LEFT_OUT));
        }
        let unknown = of_number(NAMES.len() as u32).err().map(|failure| failure.status());
        assert_eq!(unknown, Some(arb_status::ARB_UNKNOWN_KIND));
        assert_eq!(arb_kind::ARB_LEAN_BVH_HIERARCHY as usize, NAMES.len() - 1);
    }
}
