//! How an index is built.

use crate::error::BuildError;

/// How an index is built. The defaults just work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// A cell with at most this many triangles is not divided. The paper's rule is 12. Fewer means
    /// fewer triangle tests, more nodes and more bytes. 1 or more.
    pub leaf_capacity: u32,
    /// How often a cell may be divided.
    pub level: Level,
    /// Two primitives of a size class are in one cluster if the gap between their boxes is at most
    /// this multiple of the class's median box diagonal. Finite and not negative.
    pub proximity: f32,
    /// The most size classes, 1 to 4. With 1, small objects standing on a large floor are joined
    /// with it.
    pub size_classes: u32,
    /// The cells of uniform grids.
    pub resolution: Resolution,
    /// How bounding volume hierarchies are built.
    pub bvh_build: BvhBuild,
    /// What a step and a test cost, for the indices that estimate; `None` for what was measured of each,
    /// [`crate::IndexKind::cost_model`].
    pub cost: Option<CostModel>,
    /// The most steps that a build may take, each a look at one triangle; `None` for any number.
    /// [`crate::Capacity::steps`] counts them, the same on every machine.
    pub work_limit: Option<u64>,
    /// The processors for which [`select`](crate::select::select) weighs. The choice of an index depends on this,
    /// and nothing else does: each index has the same bytes and gives the same answers.
    pub float64: Float64,
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Options {
    /// The defaults, where a constant is needed.
    pub const DEFAULT: Self = Self {
        leaf_capacity: 12,
        level: Level::Automatic,
        proximity: 0.5,
        size_classes: 4,
        resolution: Resolution::Automatic,
        bvh_build: BvhBuild::Binned,
        cost: None,
        work_limit: None,
        float64: Float64::Hardware,
    };

    /// The model to estimate with; [`crate::Index::build`] has filled in the index's own.
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

/// What a step and a test cost, in any unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostModel {
    /// Entering a node.
    pub traversal: f64,
    /// Testing a triangle.
    pub intersection: f64,
}

impl CostModel {
    /// A node costs so many triangle tests.
    pub const fn tests_per_node(tests: f64) -> Self {
        Self { traversal: tests, intersection: 1.0 }
    }
}

impl Default for CostModel {
    /// A node costs as much as a test.
    fn default() -> Self {
        Self::tests_per_node(1.0)
    }
}

/// The highest level of a hierarchy of cells; the root is level 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Found: division goes on as long as the estimated cost falls, and a tree has at most 16 references a triangle.
    Automatic,
    /// Given; 0 to 20. Cells whose division would take the tree beyond 4,096 references a triangle are leaves.
    AtMost(u32),
}

/// How many cells a uniform grid has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Found by what it takes to answer some rays: the [scene's](crate::Scene::rays), or a sample.
    Automatic,
    /// So many nearly cubic cells for each triangle of the group; above 0, at most 1024.
    CellsPerTriangle(f32),
    /// The number of cells in x, y and z; 1 to 65536 on each axis. All three are halved as long as filing would take
    /// more than 4,096 steps a triangle and 8 a cell, where a step is a cell that the box of a triangle reaches into.
    Cells([u32; 3]),
}

/// Arithmetic unit for `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Float64 {
    /// Instructions of the processor.
    Hardware,
    /// Library functions, as on a Cortex-M4 and on processors without a floating-point unit.
    Software,
}

/// How a bounding volume hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BvhBuild {
    /// From above, by binned surface area.
    Binned,
    /// By inserting one triangle after the other where the surfaces grow least.
    Insertion,
}

/// Cells of a uniform grid along an axis: their planes stay apart in `f64` whatever the `f32` box.
pub(crate) const MOST_CELLS_ON_AXIS: u32 = 1 << 16;

/// Cells of 2^-20 of the root: finer than `f32` tells coordinates of the root apart usefully.
pub(crate) const MAX_LEVEL: u32 = 20;
