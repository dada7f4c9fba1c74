//! The paper's tables 1 to 3, measured again as printed: octrees of a level against the grids printed beside it.
//!
//! ```text
//! row: level L, n cells      octree hierarchy, level L, leaves of 1  }
//!                            octree hierarchy, level L, leaves of 12 } the same photons, in turns
//!                            grid hierarchy, n x n x n cells         }
//! ```
//! The paper names 12 triangles a leaf for figure 3 only. Its grids have the memory of its octrees, so `n^3` says how
//! the octrees grew: by 2 to 5 times a level, for ever. With 12 triangles a leaf an octree over a teapot stops growing
//! at level 8, because no more than about six triangles meet at a corner; two meet along every edge, so with leaves of
//! one triangle it goes on. So the tables were most likely made with leaves of one triangle. Both are measured.
//!
//! Every side of a cell is halved on every level, so an octree of level L has the cells of a grid of 2^L cells an axis.
//! The paper's have: where a grid has as many, at levels 1 and 3, its octrees take little longer than the grids.

use anyhow::Context;
use arboleda::IndexKind;
use rayon::prelude::*;

use super::printed::{PrintedRow, PrintedTable, crossover};
use crate::TimedIndex;
use crate::benchmark::harness::measurement::{
    Measured, Measurement, affordable, build, clock, count, verified_workload,
};
use crate::benchmark::harness::plan::{Case, Effort};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::summary::gain_percent;
use crate::benchmark::harness::workload::Workload;
use crate::scene::{Model, builtin};

/// Leaf capacities of the octrees.
pub const LEAF_CAPACITIES: [u32; 2] = [1, 12];
/// Least side of a cell that is halved, as a share of its longest: none is too short.
pub const EVERY_SIDE: f32 = 0.0;

/// Row of the paper, and what was measured for it.
pub struct ProtocolRow {
    /// The paper's figures.
    pub printed: PrintedRow,
    /// The octree hierarchies, by [`LEAF_CAPACITIES`].
    pub octrees: [Measurement; 2],
    /// The grid hierarchy.
    pub grid: Measurement,
}

impl ProtocolRow {
    /// Returns the time that the octrees of each capacity save, in percent, by the medians.
    pub fn gains(&self) -> [f64; 2] {
        self.octrees.each_ref().map(|octree| gain_percent(time(octree), time(&self.grid)))
    }
}

/// Table of one scene.
pub struct ProtocolTable {
    /// The paper's table.
    pub printed: &'static PrintedTable,
    /// Clusters of the scene.
    pub cluster_count: u32,
    /// A row for each of the paper.
    pub rows: Vec<ProtocolRow>,
}

/// Fastest octrees and fastest grids of a scene, whatever their levels.
pub struct Best<'t> {
    /// The level of the octrees.
    pub octree_level: u32,
    /// The octrees.
    pub octree: &'t Measurement,
    /// The cells on each axis of the grids.
    pub cells: u32,
    /// The grids.
    pub grid: &'t Measurement,
}

impl Best<'_> {
    /// Returns the time that the octrees save, in percent.
    pub fn gain(&self) -> f64 {
        gain_percent(time(self.octree), time(self.grid))
    }
}

impl ProtocolTable {
    /// Finds the fastest octrees of each capacity, and the fastest grids. `None` if there are no rows.
    pub fn best(&self) -> Option<[Best<'_>; 2]> {
        let fastest = |measured: fn(&ProtocolRow) -> &Measurement| {
            let by_time = |a: &&ProtocolRow, b: &&ProtocolRow| {
                time(measured(a)).total_cmp(&time(measured(b)))
            };
            self.rows.iter().min_by(by_time).map(|row| (row.printed, measured(row)))
        };
        let (printed, grid) = fastest(|row| &row.grid)?;
        let best = |(row, octree): (PrintedRow, _)| Best {
            octree_level: row.level,
            octree,
            cells: printed.grid,
            grid,
        };
        let [one, twelve] = [fastest(|row| &row.octrees[0])?, fastest(|row| &row.octrees[1])?];
        Some([best(one), best(twelve)])
    }

    /// Finds the lowest level from which on the octrees of each capacity are always ahead.
    pub fn crossovers(&self) -> [Option<u32>; 2] {
        [0, 1].map(|which| {
            crossover(self.rows.iter().map(|row| (row.printed.level, row.gains()[which])))
        })
    }
}

/// Returns microseconds a photon, by which cases on different numbers of photons can be compared.
fn time(measurement: &Measurement) -> f64 {
    measurement.microseconds_per_photon()
}

/// Counts the steps of `progress` for one scene: each row is built, counted, and timed in each repetition.
pub fn steps(printed: &PrintedTable, effort: &Effort) -> u64 {
    (printed.rows.len() * (2 + effort.repetitions.max(1))) as u64
}

/// Index that is built, with its case.
type Built = (Case, TimedIndex);

/// Measures all rows of one table, in turns: a slow moment of the machine hits all levels.
///
/// # Errors
/// If two indices do not agree.
pub fn run(
    printed: &'static PrintedTable,
    effort: &Effort,
    progress: Tick<'_>,
) -> anyhow::Result<ProtocolTable> {
    let model = builtin::require(printed.scene)?;
    let workload = verified_workload(&model, effort)?;

    // 1. Build. Nothing is timed yet, so all processors may build.
    let built = printed.rows.par_iter().map(|row| {
        let built = build_row(&model, row)?;
        progress();
        Ok(built)
    });
    let built = built.collect::<anyhow::Result<Vec<[Built; 3]>>>()?;

    // 2. Compare the answers, and count.
    let mut measured: Vec<Measured> = Vec::new();
    for row in built {
        measured.extend(count_row(&model, row, &workload, effort)?);
        progress();
    }

    // 3. The clock, all rows in each round.
    let after_round = || printed.rows.iter().for_each(|_| progress());
    let mut turns: Vec<&mut Measured> = measured.iter_mut().collect();
    clock(&mut turns, &workload, effort.repetitions, &after_round);

    let cluster_count = measured.first().map_or(0, |one| one.figures.cluster_count);
    let mut figures = measured.into_iter().map(|one| one.figures);
    let rows = printed.rows.iter().map(|&printed| {
        let mut next = || figures.next().context("three cases a row were measured");
        Ok(ProtocolRow { printed, octrees: [next()?, next()?], grid: next()? })
    });
    Ok(ProtocolTable { printed, cluster_count, rows: rows.collect::<anyhow::Result<_>>()? })
}

/// Builds the octrees of both capacities, and the grids.
fn build_row(model: &Model, row: &PrintedRow) -> anyhow::Result<[Built; 3]> {
    let level = Case::at_level(IndexKind::OctreeHierarchy, row.level).with_least_side(EVERY_SIDE);
    let octree = |capacity| level.clone().with_leaves_of(capacity);
    let [one, twelve] = LEAF_CAPACITIES.map(octree);
    let grid = Case::at_cells(IndexKind::GridHierarchy, [row.grid; 3]);
    let built = |case: Case| anyhow::Ok((case.clone(), build(model, &case, &[])?));
    Ok([built(one)?, built(twelve)?, built(grid)?])
}

/// Counts the three on as many photons as the slowest can answer in the time.
fn count_row(
    model: &Model,
    built: [Built; 3],
    workload: &Workload,
    effort: &Effort,
) -> anyhow::Result<Vec<Measured>> {
    let mut photons = workload.photon_count();
    for (_, index) in &built {
        photons = photons.min(affordable(&index.index(), workload, effort)?);
    }
    let counted =
        built.into_iter().map(|(case, index)| count(model, &case, index, workload, photons));
    counted.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::harness::plan::Share;
    use crate::benchmark::studies::paper::printed::PRINTED;

    #[test]
    fn a_table_has_the_rows_of_the_paper() {
        const FEW: PrintedTable =
            PrintedTable { rows: PRINTED[3].rows.split_at(4).0, ..PRINTED[3] };
        let effort =
            Effort { photons: 50, repetitions: 1, seconds: 0.01, share: Share::Common, seed: 1 };
        let ticks = std::sync::atomic::AtomicU64::new(0);
        let tick = || {
            ticks.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        };
        let table = run(&FEW, &effort, &tick).unwrap();
        assert_eq!(ticks.into_inner(), steps(&FEW, &effort));
        assert_eq!((table.cluster_count, table.rows.len()), (5, 4));
        for row in &table.rows {
            let [one, twelve] = &row.octrees;
            assert_eq!(
                (one.case.options.leaf_capacity, twelve.case.options.leaf_capacity),
                (1, 12)
            );
            assert_eq!([one, twelve].map(|octree| octree.case.options.least_side), [0.0; 2]);
            assert_eq!(one.deepest_level, row.printed.level);
            assert_eq!([one.photons, twelve.photons], [row.grid.photons; 2]);
            assert!(one.tests_per_ray() <= twelve.tests_per_ray());
            // Equal cells test equal triangles, but for those that an octree tests once and a grid in several cells.
            if row.printed.grid == 1 << row.printed.level {
                let ratio = one.tests_per_ray() / row.grid.tests_per_ray();
                assert!((0.9..1.05).contains(&ratio), "level {}: {ratio}", row.printed.level);
            }
            assert!(row.gains().iter().all(|gain| gain.abs() < 100.0));
        }
        let [one, _] = table.best().unwrap();
        assert!(time(one.octree) <= time(&table.rows[0].octrees[0]));
    }
}
