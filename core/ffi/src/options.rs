//! Options of a build, in a struct that can grow.

use arboleda::{BuildError, BvhBuild, CostModel, Level, Options, Resolution};
use bytemuck::{Pod, Zeroable};

use crate::error::{Failure, arb_status, status_of};
use crate::memory::{Caller, Input, Output};

// A difference, because the header writes it in parentheses.
/// Value of arb_options.level: the level is found.
pub const ARB_AUTOMATIC: i32 = 0 - 1;
/// Value of arb_options.resolution: the number of cells is found.
pub const ARB_RESOLUTION_AUTOMATIC: u32 = 0;
/// Value of arb_options.resolution: arb_options.cells_per_triangle says how many cells.
pub const ARB_CELLS_PER_TRIANGLE: u32 = 1;
/// Value of arb_options.resolution: arb_options.cells says how many cells.
pub const ARB_CELLS: u32 = 2;
/// Value of arb_options.bvh_build: top-down, by the binned surface area heuristic.
pub const ARB_BVH_BINNED: u32 = 0;
/// Value of arb_options.bvh_build: by insertion, each triangle where the surfaces of the boxes grow least.
pub const ARB_BVH_INSERTION: u32 = 1;

/// Options of a build. Fill it with arb_options_default, then change what you need. The defaults suit most scenes.
///
/// Each kind of index reads some of the options. All are checked by every build.
///
/// Later versions may add fields at the end. `size` tells which of them the caller knows: a library fills those that
/// are missing with defaults, and refuses those that it does not know unless they are 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct arb_options {
    /// sizeof(arb_options), as arb_options_default has set it.
    pub size: u32,
    /// The number of triangles up to which a cell or node is not divided: 1 or more; default 12. Read by octrees, BSP
    /// trees, binned BVHs, and by kd-trees if the level is given.
    pub leaf_capacity: u32,
    /// The highest level of a tree: ARB_AUTOMATIC (default), or 0 to 20. Read by octrees, kd-trees, BSP trees, binned
    /// BVHs.
    pub level: i32,
    /// The least side of an octree's cell that is halved, as a share of the cell's longest side: 0 to 1; default 1/3.
    pub least_side: f32,
    /// The largest gap within a cluster, in median box diagonals of triangles of like size: finite, 0 or more; default
    /// 0.5. Read by every hierarchy.
    pub proximity: f32,
    /// The largest number of size classes of clusters: 1 to 4; default 4. Read by every hierarchy.
    pub size_classes: u32,
    /// Choice of the number of cells of a uniform grid: ARB_RESOLUTION_AUTOMATIC (default),
    /// ARB_CELLS_PER_TRIANGLE or ARB_CELLS.
    pub resolution: u32,
    /// Cells for each triangle: above 0, at most 1024. Read if resolution is ARB_CELLS_PER_TRIANGLE.
    pub cells_per_triangle: f32,
    /// Cells along x, y and z: 1 to 65536 each. Read if resolution is ARB_CELLS.
    pub cells: [u32; 3],
    /// Method by which a BVH is built: ARB_BVH_BINNED (default) or ARB_BVH_INSERTION.
    pub bvh_build: u32,
    /// Cost of a traversal step: finite, above 0, in the unit of intersection_cost. 0 in both (default) takes costs that
    /// were measured for each kind. Read by builds that estimate.
    pub traversal_cost: f64,
    /// Cost of a triangle test, in the unit of traversal_cost.
    pub intersection_cost: f64,
    /// The largest number of steps of a build, in looks at a triangle; 0 (default) for no limit. arb_capacity.steps says
    /// how many a build takes; the number is the same on every machine.
    pub work_limit: u64,
    /// 1 to build the index beside the mesh: it has no copy of the triangles, but reads them where the caller keeps them,
    /// and is opened with the same mesh. Default 0. Not for the wide and the compact BVH.
    pub beside: u32,
    /// Must be 0.
    pub reserved: u32,
}

/// Bytes of the first version of the struct.
const FIRST: usize = 80;
/// Most bytes that a caller's struct can have; more are taken for a mistake.
const MOST: usize = 4096;

const _: () = assert!(size_of::<arb_options>() == FIRST);

const DEFAULT: arb_options = arb_options {
    size: size_of::<arb_options>() as u32,
    leaf_capacity: Options::DEFAULT.leaf_capacity,
    level: ARB_AUTOMATIC,
    least_side: Options::DEFAULT.least_side,
    proximity: Options::DEFAULT.proximity,
    size_classes: Options::DEFAULT.size_classes,
    resolution: ARB_RESOLUTION_AUTOMATIC,
    cells_per_triangle: 1.0,
    cells: [1; 3],
    bvh_build: ARB_BVH_BINNED,
    traversal_cost: 0.0,
    intersection_cost: 0.0,
    work_limit: 0,
    beside: 0,
    reserved: 0,
};

/// Fills options with the defaults. Call it as `arb_options_default(&options, sizeof options)`.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER; ARB_INVALID_OPTION if `size` is that of no version of the struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_options_default(options: *mut arb_options, size: usize) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        Output::one(options, "options")?;
        check_size(size)?;
        let room = caller.borrow_mut(Output::check(options.cast::<u8>(), size, "options")?);
        room.fill(0);
        let defaults = arb_options { size: size as u32, ..DEFAULT };
        for (to, from) in room.iter_mut().zip(bytemuck::bytes_of(&defaults)) {
            *to = *from;
        }
        Ok(())
    })
}

/// Options in the core's form, and whether the index is built beside the mesh.
pub struct Chosen {
    /// The options of the core.
    pub options: Options,
    /// True if the index is built beside the mesh.
    pub beside: bool,
}

/// Reads the caller's options; null for the defaults.
pub fn chosen(caller: Caller, options: *const arb_options) -> Result<Chosen, Failure> {
    if options.is_null() {
        return convert(&DEFAULT);
    }
    // The struct's alignment, then its size, and only then as many bytes.
    Output::one(options.cast_mut(), "options")?;
    let size = caller.read(options.cast::<u32>(), "options")? as usize;
    check_size(size)?;
    let bytes = caller.borrow(Input::check(options.cast::<u8>(), size, "options")?);
    let mut known = DEFAULT;
    for (to, from) in bytemuck::bytes_of_mut(&mut known).iter_mut().zip(bytes) {
        *to = *from;
    }
    let unknown = bytes.get(size_of::<arb_options>()..).unwrap_or_default();
    if unknown.iter().any(|&byte| byte != 0) {
        return Err(invalid("options of a later version", "0 for this library"));
    }
    convert(&known)
}

fn check_size(size: usize) -> Result<(), Failure> {
    if (FIRST..=MOST).contains(&size) {
        Ok(())
    } else {
        Err(invalid("options.size", "sizeof(arb_options)"))
    }
}

fn convert(given: &arb_options) -> Result<Chosen, Failure> {
    let level = match given.level {
        ARB_AUTOMATIC => Level::Automatic,
        // The core refuses what is above its highest level.
        level => Level::AtMost(
            u32::try_from(level).map_err(|_| invalid("level", "ARB_AUTOMATIC or 0 to 20"))?,
        ),
    };
    let resolution = match given.resolution {
        ARB_RESOLUTION_AUTOMATIC => Resolution::Automatic,
        ARB_CELLS_PER_TRIANGLE => Resolution::CellsPerTriangle(given.cells_per_triangle),
        ARB_CELLS => Resolution::Cells(given.cells),
        _ => return Err(invalid("resolution", "a constant of arboleda.h")),
    };
    let bvh_build = match given.bvh_build {
        ARB_BVH_BINNED => BvhBuild::Binned,
        ARB_BVH_INSERTION => BvhBuild::Insertion,
        _ => return Err(invalid("bvh_build", "ARB_BVH_BINNED or ARB_BVH_INSERTION")),
    };
    if given.beside > 1 {
        return Err(invalid("beside", "0 or 1"));
    }
    if given.reserved != 0 {
        return Err(invalid("reserved", "0"));
    }
    let (traversal, intersection) = (given.traversal_cost, given.intersection_cost);
    let has_cost = traversal != 0.0 || intersection != 0.0;
    let options = Options {
        leaf_capacity: given.leaf_capacity,
        level,
        least_side: given.least_side,
        proximity: given.proximity,
        size_classes: given.size_classes,
        resolution,
        bvh_build,
        cost: has_cost.then_some(CostModel { traversal, intersection }),
        work_limit: (given.work_limit != 0).then_some(given.work_limit),
        ..Options::DEFAULT
    };
    Ok(Chosen { options, beside: given.beside == 1 })
}

fn invalid(option: &'static str, allowed: &'static str) -> Failure {
    Failure::Build(BuildError::InvalidOption { option, allowed })
}
