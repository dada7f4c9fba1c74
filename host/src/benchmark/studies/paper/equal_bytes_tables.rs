//! Tables 1 to 3 with grids of our own choice: octree hierarchies against grid hierarchies of the same bytes, level by
//! level. [`super::protocol`] has the grids that the paper prints.
//!
//! The size of an octree depends on how it is stored, and the paper does not say how. There are two grids for each
//! octree: one as large as our octree, which stores what is not empty, and one as large as the same
//! octree with pointers, as usual at the time; see [`pointer_octree_bytes`].

use anyhow::Context;
use arboleda::{IndexKind, Statistics};
use rayon::prelude::*;

use super::equal_bytes::{TOLERANCE, grid_of_bytes};
use super::printed::{PrintedTable, crossover};
use crate::benchmark::harness::measurement::{Measurement, build, measure, verified_workload};
use crate::benchmark::harness::plan::{Case, Effort};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::summary::gain_percent;
use crate::scene::{Model, builtin};

/// The octree levels of the paper's tables. Leaves have up to 12 triangles, so the trees stop growing before
/// the highest; the levels at which they do not grow are left out.
pub const LEVELS: std::ops::RangeInclusive<u32> = 1..=11;
/// The paper's tables have the grids ahead up to this level, and the octrees beyond.
pub const LAST_LEVEL_OF_GRIDS: u32 = 3;
/// The most that octrees save at deep levels in the paper's tables, in percent.
pub const DEEP_GAIN: f64 = 65.0;

/// Level of a table.
pub struct LevelRow {
    /// The highest level allowed.
    pub level: u32,
    /// The octree hierarchy.
    pub octree: Measurement,
    /// The grid hierarchy of the same size.
    pub grid: Measurement,
    /// The bytes of the octree hierarchy if it were stored with pointers.
    pub pointer_bytes: usize,
    /// The grid hierarchy of that size.
    pub pointer_grid: Measurement,
}

/// Returns the bytes that an octree with these parts takes if a divided cell has all eight children, empty ones
/// included; each node has eight links, a count and the head of a list; each list entry has an id and a link;
/// and all of these are four bytes.
pub fn pointer_octree_bytes(parts: &Statistics, cluster_count: u32) -> usize {
    let nodes = parts.inner_nodes * 8 + u64::from(cluster_count);
    (nodes * (8 + 2) * 4 + parts.references * 8) as usize
}

impl LevelRow {
    /// Returns the time that the octrees save, in percent, by the medians.
    pub fn gain(&self) -> f64 {
        gain_percent(self.octree.seconds.median, self.grid.seconds.median)
    }

    /// Returns the gain as [`Self::gain`], against the grid as large as an octree with pointers.
    pub fn pointer_gain(&self) -> f64 {
        gain_percent(self.octree.seconds.median, self.pointer_grid.seconds.median)
    }

    /// Returns the gain as [`Self::gain`], by the fastest repetitions.
    pub fn least_gain(&self) -> f64 {
        gain_percent(self.octree.seconds.min, self.grid.seconds.min)
    }

    /// Returns how much larger the grids are than wanted, in percent, triangles not counted: as our octrees, and as
    /// octrees with pointers.
    pub fn excess_bytes_percent(&self) -> [f64; 2] {
        let excess = |grid: &Measurement, wanted: usize| {
            (grid.subdivision_bytes as f64 / wanted as f64 - 1.0) * 100.0
        };
        [
            excess(&self.grid, self.octree.subdivision_bytes),
            excess(&self.pointer_grid, self.pointer_bytes),
        ]
    }
}

/// Table of one scene.
pub struct SceneTable {
    /// The paper's table.
    pub printed: &'static PrintedTable,
    /// Clusters of the scene.
    pub cluster_count: u32,
    /// Each level, from the lowest, until the tree stops changing.
    pub rows: Vec<LevelRow>,
}

impl SceneTable {
    /// Finds the row with the fastest octrees.
    pub fn best_octree(&self) -> Option<&LevelRow> {
        self.rows.iter().min_by(|a, b| time(&a.octree).total_cmp(&time(&b.octree)))
    }

    /// Finds the row with the fastest grids.
    pub fn best_grid(&self) -> Option<&LevelRow> {
        self.rows.iter().min_by(|a, b| time(&a.grid).total_cmp(&time(&b.grid)))
    }

    /// Finds the row with the fastest grids as large as octrees with pointers.
    pub fn best_pointer_grid(&self) -> Option<&LevelRow> {
        self.rows.iter().min_by(|a, b| time(&a.pointer_grid).total_cmp(&time(&b.pointer_grid)))
    }

    /// Compares the best octrees with the best grids, whatever their levels: the time saved, in percent.
    pub fn best_gain(&self) -> f64 {
        match (self.best_octree(), self.best_grid()) {
            (Some(octree), Some(grid)) => gain_percent(time(&octree.octree), time(&grid.grid)),
            _ => f64::NAN,
        }
    }

    /// Returns the gain as [`Self::best_gain`], against the best grids as large as octrees with pointers.
    pub fn best_pointer_gain(&self) -> f64 {
        match (self.best_octree(), self.best_pointer_grid()) {
            (Some(octree), Some(grid)) => {
                gain_percent(time(&octree.octree), time(&grid.pointer_grid))
            }
            _ => f64::NAN,
        }
    }

    /// Finds the lowest level from which on a gain is always above 0.
    pub fn crossover(&self, gain: fn(&LevelRow) -> f64) -> Option<u32> {
        crossover(self.rows.iter().map(|row| (row.level, gain(row))))
    }
}

/// Returns microseconds a photon, by which cases on different shares of the photons can be compared.
fn time(measurement: &Measurement) -> f64 {
    measurement.microseconds_per_photon()
}

/// Steps of a level: the search for the grids, and the measurements of the three.
const STEPS_A_LEVEL: u64 = 4;

/// Counts the steps of `progress` for one scene.
pub fn steps() -> u64 {
    STEPS_A_LEVEL * LEVELS.count() as u64
}

/// Fills the table of one scene.
///
/// # Errors
/// If two indices do not agree.
pub fn run(
    printed: &'static PrintedTable,
    effort: &Effort,
    progress: Tick<'_>,
) -> anyhow::Result<SceneTable> {
    let model = builtin::require(printed.scene)?;
    let workload = verified_workload(&model, effort)?;

    // 1. The octrees, until they stop growing, and the grids of their sizes. Nothing is timed yet, so all processors
    // may build and search.
    let levels: Vec<u32> = LEVELS.collect();
    let octrees = levels.par_iter().map(|&level| LevelOctree::at(&model, level));
    let octrees = octrees.collect::<anyhow::Result<Vec<_>>>()?;
    let growing = LevelOctree::growing(&octrees);
    let skipped = (octrees.len() - growing.len()) as u64 * STEPS_A_LEVEL;
    (0..skipped).for_each(|_| progress());
    let plans = growing.par_iter().map(|octree| {
        let plan = octree.plan(&model)?;
        progress();
        Ok((octree.level, plan))
    });
    let plans = plans.collect::<anyhow::Result<Vec<_>>>()?;

    // 2. The clock, level by level, so that what is compared is measured side by side.
    let mut table = SceneTable { printed, cluster_count: 0, rows: Vec::new() };
    for (level, plan) in plans {
        let measured = measure(&model, &plan.cases, &workload, effort, progress)?;
        let [octree, grid, pointer_grid] =
            <[Measurement; 3]>::try_from(measured).ok().context("three cases were measured")?;
        table.cluster_count = octree.cluster_count;
        let pointer_bytes = plan.pointer_bytes;
        table.rows.push(LevelRow { level, octree, grid, pointer_bytes, pointer_grid });
    }
    Ok(table)
}

/// Cases to be measured at one level.
struct LevelPlan {
    /// The octrees, the grids as large as these, the grids as large as `pointer_bytes`.
    cases: [Case; 3],
    pointer_bytes: usize,
}

/// Octree hierarchy of one level, by its sizes.
struct LevelOctree {
    level: u32,
    case: Case,
    /// Bytes beside the triangles.
    bytes: usize,
    pointer_bytes: usize,
}

impl LevelOctree {
    fn at(model: &Model, level: u32) -> anyhow::Result<Self> {
        let case = Case::at_level(IndexKind::OctreeHierarchy, level);
        let built = build(model, &case, &[])?;
        let index = built.index();
        let bytes = built.bytes() - size_of_val(model.triangles.as_slice());
        let pointer_bytes = pointer_octree_bytes(&index.check()?, index.sections().cluster_count());
        Ok(Self { level, case, bytes, pointer_bytes })
    }

    /// Returns the levels up to the last that takes noticeably more bytes than the one before it.
    fn growing(octrees: &[Self]) -> &[Self] {
        let grows = |pair: &[Self]| pair[1].bytes as f64 > pair[0].bytes as f64 * (1.0 + TOLERANCE);
        let last = octrees.windows(2).rposition(grows).map_or(0, |place| place + 1);
        &octrees[..octrees.len().min(last + 1)]
    }

    /// Finds the grids.
    fn plan(&self, model: &Model) -> anyhow::Result<LevelPlan> {
        let (grid, _) = grid_of_bytes(IndexKind::GridHierarchy, model, self.bytes)?;
        let (pointer_grid, _) = grid_of_bytes(IndexKind::GridHierarchy, model, self.pointer_bytes)?;
        let cases = [self.case.clone(), grid, pointer_grid];
        Ok(LevelPlan { cases, pointer_bytes: self.pointer_bytes })
    }
}
