//! Figure 3 with its clusters further apart: the hierarchy against a single octree, each at the level it needs.
//!
//! A tree has the level it needs when no leaf has more than 12 triangles. The hierarchy needs level 3 at any distance.
//! A single octree needs more levels the further the clusters are apart. Two of them are measured; both begin with the
//! box of the scene:
//!
//! ```text
//! cells in proportion: every side is halved on every level,     +----+----+----+----+
//!                      so cells are as flat as the box          |[]--+----+----+--[]|
//!                                                               +----+----+----+----+
//! nearly cubic cells:  only the longest sides are halved,       +----+----+----+----+
//!                      so long cells become cubes first         |[]  |    |    |  []|
//!                                                               +----+----+----+----+
//! ```
//! The first is the octree as the paper's tables suggest it, [`super::protocol`]; the second is what
//! [`arboleda::Options::least_side`] makes of it with 1.

use anyhow::Context;
use arboleda::{AnyIndex, IndexKind};

use super::figure3::{PUBLISHED_GAIN, clusters};
use super::protocol::EVERY_SIDE;
use crate::TimedIndex;
use crate::benchmark::harness::measurement::{
    Measured, Measurement, affordable, build, clock, count, verified_workload,
};
use crate::benchmark::harness::plan::{Case, Effort};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::summary::gain_percent;

/// Lengths of the scene, as a multiple of the clusters' size, as [`clusters`] takes them. The built-in scene is
/// 11.3 long.
const LENGTHS: [u16; 10] = [4, 8, 16, 32, 64, 128, 256, 512, 1_024, 8_192];
/// The highest level that the core allows.
const HIGHEST: u32 = 20;
/// Least side of a cell that is halved, as a share of its longest: the longest itself.
const LONGEST_SIDES: f32 = 1.0;

/// Octree at the level it needs.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Its figures.
    pub figures: Measurement,
    /// Triangles of its largest leaf. More than 12 where the core ends the division, at 4,096 references a triangle.
    pub largest_leaf: u32,
}

/// Measurements at one gap, on the same photons.
pub struct ApartRow {
    /// The gap, as a multiple of the clusters' size.
    pub gap: f64,
    /// An octree in each cluster.
    pub hierarchy: Finished,
    /// One octree with nearly cubic cells.
    pub cubic: Finished,
    /// One octree with cells in proportion to the scene; `None` at gaps beyond the first at which the paper's gain is
    /// met.
    pub in_proportion: Option<Finished>,
}

impl ApartRow {
    /// Returns the time that the hierarchy saves over the octree with nearly cubic cells, in percent.
    pub fn cubic_gain(&self) -> f64 {
        self.gain_over(&self.cubic)
    }

    /// Returns the time that the hierarchy saves over the octree with cells in proportion, in percent.
    pub fn proportion_gain(&self) -> Option<f64> {
        self.in_proportion.as_ref().map(|single| self.gain_over(single))
    }

    fn gain_over(&self, single: &Finished) -> f64 {
        let time = |one: &Finished| one.figures.microseconds_per_photon();
        gain_percent(time(&self.hierarchy), time(single))
    }
}

/// Finds the first gap at which the octree with cells in proportion loses as much as the paper's.
pub fn met(rows: &[ApartRow]) -> Option<&ApartRow> {
    rows.iter().find(|row| row.proportion_gain().is_some_and(|gain| gain >= PUBLISHED_GAIN))
}

/// Counts the steps of `progress`.
pub fn steps() -> u64 {
    LENGTHS.len() as u64
}

/// Measures all gaps.
///
/// # Errors
/// If two indices do not agree.
pub fn run(effort: &Effort, progress: Tick<'_>) -> anyhow::Result<Vec<ApartRow>> {
    let mut rows: Vec<ApartRow> = Vec::new();
    for length in LENGTHS {
        let in_proportion = met(&rows).is_none();
        rows.push(measure(length, in_proportion, effort)?);
        progress();
    }
    Ok(rows)
}

fn measure(length: u16, in_proportion: bool, effort: &Effort) -> anyhow::Result<ApartRow> {
    // 1. The scene and its photons.
    let (model, gap) = clusters(length);
    let workload = verified_workload(&model, effort)?;

    // 2. Build.
    let case = |kind, least_side| Case::at_level(kind, HIGHEST).with_least_side(least_side);
    let mut cases =
        vec![case(IndexKind::OctreeHierarchy, EVERY_SIDE), case(IndexKind::Octree, LONGEST_SIDES)];
    cases.extend(in_proportion.then(|| case(IndexKind::Octree, EVERY_SIDE)));
    let built = cases.iter().map(|case| build(&model, case, &[]));
    let built = built.collect::<anyhow::Result<Vec<TimedIndex>>>()?;

    // 3. Count, on as many photons as the slowest can answer in the time.
    let mut photons = workload.photon_count();
    for index in &built {
        photons = photons.min(affordable(&index.index(), &workload, effort)?);
    }
    let counted = cases.iter().zip(built).map(|(case, index)| {
        let largest_leaf = largest_leaf(&index.index())?;
        Ok((count(&model, case, index, &workload, photons)?, largest_leaf))
    });
    let mut counted = counted.collect::<anyhow::Result<Vec<(Measured, u32)>>>()?;

    // 4. The clock, in turns.
    let mut turns: Vec<&mut Measured> = counted.iter_mut().map(|(one, _)| one).collect();
    clock(&mut turns, &workload, effort.repetitions, &|| {});

    let finished =
        |(one, largest_leaf): (Measured, u32)| Finished { figures: one.figures, largest_leaf };
    let mut finished = counted.into_iter().map(finished);
    let mut next = || finished.next();
    let pair = next().zip(next());
    let (hierarchy, cubic) = pair.context("two cases were measured")?;
    Ok(ApartRow { gap, hierarchy, cubic, in_proportion: next() })
}

fn largest_leaf(index: &AnyIndex<'_>) -> anyhow::Result<u32> {
    Ok(index.check()?.largest_leaf)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::harness::plan::Share;

    const EFFORT: Effort =
        Effort { photons: 200, repetitions: 1, seconds: 0.01, share: Share::Common, seed: 1 };

    #[test]
    fn each_octree_has_the_level_it_needs() {
        for (length, cubic, in_proportion) in [(4, 9, 5), (16, 11, 7)] {
            let row = measure(length, true, &EFFORT).unwrap();
            let long = row.in_proportion.as_ref().unwrap();
            let three = [&row.hierarchy, &row.cubic, long];
            let levels = three.map(|one| one.figures.deepest_level);
            assert_eq!(levels, [3, cubic, in_proportion], "length {length}");
            assert!(three.iter().all(|one| one.largest_leaf <= 12));
            assert_eq!(row.cubic.figures.photons, long.figures.photons);
        }
    }
}
