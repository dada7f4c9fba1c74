//! The paper's figure 3: one octree over two distant clusters against one in each.

use arboleda::IndexKind;

use crate::bench::measurement::{Measurement, measure, verified_workload};
use crate::bench::plan::{Case, Effort};
use crate::bench::progress::Tick;
use crate::bench::summary::gain_percent;
use crate::scene::builtin;

/// The level at which no leaf of the hierarchy has more than 12 triangles.
pub const HIERARCHY_LEVEL: u32 = 3;
/// The level at which no leaf of the single octree has.
pub const SINGLE_LEVEL: u32 = 10;
/// The most that the hierarchy saves in the paper, in percent.
pub const PUBLISHED_GAIN: f64 = 87.0;

/// Measurements of both, level by level.
pub struct Figure3 {
    /// The hierarchy from level 1 up to [`HIERARCHY_LEVEL`], from where on it does not change.
    pub hierarchy: Vec<Measurement>,
    /// The single octree from level 1 up to [`SINGLE_LEVEL`], from where on it does not change.
    pub single: Vec<Measurement>,
}

impl Figure3 {
    /// Returns the finished trees: the hierarchy, and the single octree.
    pub fn finished(&self) -> Option<(&Measurement, &Measurement)> {
        self.hierarchy.last().zip(self.single.last())
    }

    /// Returns the time that the hierarchy saves against a single octree, in percent: of the same level, or
    /// where the hierarchy has none so deep, its deepest.
    pub fn gains(&self) -> impl Iterator<Item = (u32, f64)> {
        self.single.iter().zip(1..).filter_map(|(single, level)| {
            let hierarchy = self.hierarchy.get(level as usize - 1).or(self.hierarchy.last())?;
            let (ours, theirs) =
                (hierarchy.microseconds_per_photon(), single.microseconds_per_photon());
            Some((level, gain_percent(ours, theirs)))
        })
    }
}

/// Counts the steps of `progress`.
pub fn steps() -> u64 {
    u64::from(HIERARCHY_LEVEL + SINGLE_LEVEL)
}

/// Measures both on the scene of figure 3.
///
/// # Errors
/// If two indices do not agree.
pub fn run(effort: &Effort, progress: Tick<'_>) -> anyhow::Result<Figure3> {
    let model = builtin::require("fig3")?;
    let workload = verified_workload(&model, effort)?;
    let hierarchy =
        (1..=HIERARCHY_LEVEL).map(|level| Case::at_level(IndexKind::OctreeHierarchy, level));
    let single = (1..=SINGLE_LEVEL).map(|level| Case::at_level(IndexKind::Octree, level));
    let cases: Vec<Case> = hierarchy.chain(single).collect();
    let mut hierarchy = measure(&model, &cases, &workload, effort, progress)?;
    let single = hierarchy.split_off(HIERARCHY_LEVEL as usize);
    Ok(Figure3 { hierarchy, single })
}
