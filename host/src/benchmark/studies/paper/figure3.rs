//! The paper's figure 3: one octree over two distant clusters against one in each.
//!
//! The paper's hierarchy needs level 3 and its single octree level 10, so that no leaf has more than 12 triangles. It
//! does not say how far the clusters are apart. With every side of a cell halved on every level, as [`super::protocol`]
//! has it, the single octree needs level 10 where they are 126 sizes apart, and that is where both are measured.

use arboleda::IndexKind;

use super::protocol::EVERY_SIDE;
use crate::benchmark::harness::measurement::{Measurement, measure, verified_workload};
use crate::benchmark::harness::plan::{Case, Effort};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::summary::gain_percent;
use crate::benchmark::studies::separation::{cluster_size, clusters_shifted};
use crate::scene::Model;

/// The level at which no leaf of the hierarchy has more than 12 triangles.
pub const HIERARCHY_LEVEL: u32 = 3;
/// The level at which no leaf of the single octree has.
pub const SINGLE_LEVEL: u32 = 10;
/// The most that the hierarchy saves in the paper, in percent.
pub const PUBLISHED_GAIN: f64 = 87.0;

/// Length of the scene, as [`clusters`] takes it, at which a single octree needs [`SINGLE_LEVEL`].
const LENGTH: u16 = 128;
/// What a scene is shorter than its length in sizes: 0.3 sizes of a cluster. All coordinates are multiples of 1/8, and
/// exact.
const SHORTER: f32 = 21.0 / 8.0;

/// Measurements of both, level by level.
pub struct Figure3 {
    /// The gap between the clusters, as a multiple of their size.
    pub gap: f64,
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

/// Measures both.
///
/// # Errors
/// If two indices do not agree.
pub fn run(effort: &Effort, progress: Tick<'_>) -> anyhow::Result<Figure3> {
    let (model, gap) = clusters(LENGTH);
    let workload = verified_workload(&model, effort)?;
    let case = |kind, level| Case::at_level(kind, level).with_least_side(EVERY_SIDE);
    let hierarchy = (1..=HIERARCHY_LEVEL).map(|level| case(IndexKind::OctreeHierarchy, level));
    let single = (1..=SINGLE_LEVEL).map(|level| case(IndexKind::Octree, level));
    let cases: Vec<Case> = hierarchy.chain(single).collect();
    let mut hierarchy = measure(&model, &cases, &workload, effort, progress)?;
    let single = hierarchy.split_off(HIERARCHY_LEVEL as usize);
    Ok(Figure3 { gap, hierarchy, single })
}

/// Makes figure 3 with its clusters so far apart that the scene is about `length` times as long as a cluster, and
/// returns their gap as a multiple of their size.
///
/// The scene is 0.3 sizes shorter. With a length that is a power of two, cells and clusters would otherwise begin at
/// the same planes at each level, which is the best of all cases for an octree, and no more likely than any.
pub fn clusters(length: u16) -> (Model, f64) {
    let size = cluster_size();
    let shift = size * (f32::from(length) - 1.0) - SHORTER;
    (clusters_shifted(shift), f64::from(shift / size) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::harness::measurement::build;
    use crate::benchmark::harness::plan::Share;
    use crate::scene::test_support::cluster_counts;
    use arboleda::Options;

    #[test]
    fn a_scene_is_a_third_of_a_cluster_shorter_than_a_power_of_two() {
        let size = f64::from(cluster_size());
        for length in [4, 128, 8_192] {
            let (model, gap) = clusters(length);
            let [x, y, z] = model.bounds().extent();
            assert_eq!([x, y, z], [f64::from(length) * size - f64::from(SHORTER), size, size]);
            assert!((f64::from(length) - 2.3 - gap).abs() < 0.01, "gap {gap}");
            assert_eq!(cluster_counts(&model.scene(), &Options::default()).0, 2);
        }
    }

    #[test]
    fn the_trees_have_the_papers_levels() {
        let effort =
            Effort { photons: 50, repetitions: 1, seconds: 0.01, share: Share::Own, seed: 1 };
        let figure3 = run(&effort, &|| {}).unwrap();
        let levels = |trees: &[Measurement]| trees.iter().map(|one| one.deepest_level).collect();
        let found: [Vec<u32>; 2] = [levels(&figure3.hierarchy), levels(&figure3.single)];
        assert_eq!(found, [(1..=3).collect::<Vec<_>>(), (1..=10).collect()]);
        let (model, _) = clusters(LENGTH);
        let leaf = |level| {
            let case = Case::at_level(IndexKind::Octree, level).with_least_side(EVERY_SIDE);
            build(&model, &case, &[]).unwrap().index().check().unwrap().largest_leaf
        };
        assert!(leaf(SINGLE_LEVEL - 1) > 12 && leaf(SINGLE_LEVEL) <= 12);
    }
}
