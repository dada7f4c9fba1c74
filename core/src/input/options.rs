//! Options of a build.

use crate::error::BuildError;

/// Options of a build. The defaults suit most scenes.
///
/// Each index reads a part of them, and ignores the others:
///
/// | option | read by |
/// |---|---|
/// | [`leaf_capacity`](Self::leaf_capacity) | octree, octree-R, BSP tree, binned BVH; kd-tree if the level is given |
/// | [`level`](Self::level) | octree, octree-R, kd-tree, BSP tree, binned BVH |
/// | [`least_side`](Self::least_side) | octree |
/// | [`proximity`](Self::proximity), [`size_classes`](Self::size_classes) | every hierarchy, in [`crate::clusters::find`] |
/// | [`resolution`](Self::resolution) | uniform grid |
/// | [`bvh_build`](Self::bvh_build) | BVH |
/// | [`cost`](Self::cost) | octree-R, kd-tree, BVH; octree and BSP tree if the level, uniform grid if the resolution is automatic |
/// | [`work_limit`](Self::work_limit) | all |
/// | [`float64`](Self::float64) | [`select`](crate::select::select) only |
///
/// "BVH" is [`Bvh`](crate::kinds::Bvh), "binned" with [`BvhBuild::Binned`]. The wide, compact and lean BVH read
/// `proximity` and `size_classes` (as hierarchies) and `work_limit`, nothing else. Every build checks all options, and
/// refuses one that is out of range also where its index ignores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The number of triangles up to which a cell or a node is not divided; 1 or more. The default is the paper's, 12.
    ///
    /// A smaller capacity means fewer triangle tests, more nodes and more bytes. An automatic kd-tree divides as long
    /// as the estimated cost falls, whatever the capacity. A binned BVH also divides smaller nodes if that is estimated
    /// to pay.
    pub leaf_capacity: u32,
    /// The highest level of a tree.
    pub level: Level,
    /// The least side of an octree's cell that is halved, as a share of the cell's longest side; 0 to 1.
    ///
    /// The root cell is the box around the triangles. With 0, every side is halved on every level, so all cells have the
    /// proportions of that box, as in the paper. With 1, only the longest sides are. The default, a third, halves long
    /// cells until they are nearly cubes: of a flat city, an octree then takes half the steps.
    pub least_side: f32,
    /// The largest gap within a cluster: two primitives of one size class are in one cluster if the gap between their
    /// boxes is at most `proximity` times the median box diagonal of that class. Finite and not negative.
    pub proximity: f32,
    /// The largest number of size classes, 1 to 4. With 1, small objects that stand on a large floor form one cluster
    /// with the floor.
    pub size_classes: u32,
    /// The number of cells of a uniform grid.
    pub resolution: Resolution,
    /// The algorithm that builds a BVH.
    pub bvh_build: BvhBuild,
    /// The cost model of builds that estimate. `None` takes the model measured for each index,
    /// [`crate::IndexKind::cost_model`].
    pub cost: Option<CostModel>,
    /// The largest number of steps of a build; one step is one look at a triangle. `None` means no limit.
    ///
    /// A build that takes more returns [`BuildError::TooMuchWork`]. [`crate::Capacity::steps`] says how many steps a
    /// build takes; the number is the same on every machine.
    pub work_limit: Option<u64>,
    /// The processor that [`select`](crate::select::select) weighs for. Only the choice of an index depends on this
    /// option: every index has the same bytes and gives the same answers on all processors.
    pub float64: Float64,
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Options {
    /// The defaults, as a constant.
    pub const DEFAULT: Self = Self {
        leaf_capacity: 12,
        level: Level::Automatic,
        least_side: 1.0 / 3.0,
        proximity: 0.5,
        size_classes: 4,
        resolution: Resolution::Automatic,
        bvh_build: BvhBuild::Binned,
        cost: None,
        work_limit: None,
        float64: Float64::Hardware,
    };

    /// The cost model of this build. [`crate::Index::build`] has put the index's own model into `cost` if it was
    /// `None`.
    pub(crate) fn cost_model(&self) -> CostModel {
        self.cost.unwrap_or_default()
    }

    pub(crate) fn check(&self) -> Result<(), BuildError> {
        let invalid = |option, allowed| Err(BuildError::InvalidOption { option, allowed });
        if self.leaf_capacity == 0 {
            return invalid("leaf_capacity", "at least 1");
        }
        if matches!(self.level, Level::AtMost(level) if level > MAX_LEVEL) {
            return invalid("level", "at most 20");
        }
        if !(0.0..=1.0).contains(&self.least_side) {
            return invalid("least_side", "0 to 1");
        }
        if !(self.proximity.is_finite() && self.proximity >= 0.0) {
            return invalid("proximity", "finite and not negative");
        }
        let most = MOST_CELLS_ON_AXIS;
        match self.resolution {
            Resolution::Cells(cells) if !cells.iter().all(|n| (1..=most).contains(n)) => {
                return invalid("resolution", "1 to 65536 cells on each axis");
            }
            Resolution::CellsPerTriangle(density) if !(density > 0.0 && density <= 1024.0) => {
                return invalid("resolution", "above 0 and at most 1024 cells per triangle");
            }
            _ => {}
        }
        let positive = |cost: f64| cost.is_finite() && cost > 0.0;
        let model = self.cost_model();
        if !(positive(model.traversal) && positive(model.intersection)) {
            return invalid("cost", "finite and above 0");
        }
        if !(1..=4).contains(&self.size_classes) {
            return invalid("size_classes", "1 to 4");
        }
        Ok(())
    }
}

/// Cost model of a build: the costs of a traversal step and of a triangle test, in any common unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostModel {
    /// Cost of entering a node.
    pub traversal: f64,
    /// Cost of testing a triangle.
    pub intersection: f64,
}

impl CostModel {
    /// The model in which entering a node costs as much as `tests` triangle tests.
    pub const fn tests_per_node(tests: f64) -> Self {
        Self { traversal: tests, intersection: 1.0 }
    }
}

impl Default for CostModel {
    /// The model in which entering a node costs as much as one triangle test.
    fn default() -> Self {
        Self::tests_per_node(1.0)
    }
}

/// Highest level of a tree; the root is level 0.
///
/// A level of an octree halves three axes, so a kd-tree or a BSP tree may divide three times a level. A binned BVH
/// counts one division a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Level {
    /// The level is found: division goes on as long as the estimated cost falls. An octree, an octree-R, a kd-tree or a
    /// BSP tree then has at most 16 references a triangle.
    Automatic,
    /// The level is given: 0 to 20. In an octree, an octree-R, a kd-tree or a BSP tree, a cell is a leaf if its
    /// division would take the tree beyond 4,096 references a triangle.
    AtMost(u32),
}

/// Number of cells of a uniform grid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Resolution {
    /// The number is found: the density at which probe rays cost least. The probe rays are the
    /// [scene's](crate::Scene::rays), or a sample.
    Automatic,
    /// The number of cells for each triangle of the group, above 0 and at most 1024. Cells are nearly cubic.
    CellsPerTriangle(f32),
    /// The number of cells along x, y and z, 1 to 65536 on each axis.
    ///
    /// All three are halved as long as filing the triangles would take more than 4,096 steps a triangle plus 8 a cell.
    /// A step is a cell that the box of a triangle reaches into.
    Cells([u32; 3]),
}

/// Arithmetic unit for `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Float64 {
    /// `f64` instructions of the processor.
    Hardware,
    /// Library functions, as on a Cortex-M4 and on processors without a floating-point unit.
    Software,
}

/// Algorithm that builds a BVH.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BvhBuild {
    /// Top-down, by the binned surface-area heuristic (SAH).
    Binned,
    /// By insertion: each triangle goes to where the surfaces of the boxes grow least.
    Insertion,
}

/// Largest number of cells of a uniform grid along an axis. With 2^16, planes stay apart in `f64` for every `f32` box.
pub(crate) const MOST_CELLS_ON_AXIS: u32 = 1 << 16;

/// Highest level of a tree. Cells of this level have 2^-20 of the root's side: finer cells would not tell `f32`
/// coordinates in the root apart usefully.
pub(crate) const MAX_LEVEL: u32 = 20;
