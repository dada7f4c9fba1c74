//! Figure 3 with its clusters further apart: the hierarchy against a single octree, each at the level it needs.
//!
//! A tree has the level it needs when no leaf has more than 12 triangles. The hierarchy needs level 3 at any distance. A
//! single octree needs more levels the further the clusters are apart. Two of them are measured:
//!
//! ```text
//! over a cube:  the root is a cube that holds the scene, as in the core       +--------------------+
//!                                                                             |                    |
//!                                                                             |[]                []|
//! over the box: the root is the box of the scene, and so are                  +--------------------+
//!               the shapes of all cells: long along x, flat in y and z        |[]   |    |    |  []|
//! ```
//! The core has no octree over a box. An octree over a cube visits, in a scene stretched along y and z until its box is a
//! cube, with rays stretched alike, the cells that an octree over the box visits in the scene itself. So that is what is
//! measured. The factor is a power of two, which rounds nothing: hits keep their triangle, `t`, `u` and `v` bit for bit,
//! and that is checked. The scene is 0.3 sizes of a cluster shorter than the power of two, so the root is so much longer
//! than its box. If it were as long, cells and clusters would begin at the same planes at each level, which is the best of
//! all cases for an octree, and no more likely than any.

use anyhow::Context;
use arboleda::{AnyIndex, IndexKind, Ray, RayError, Triangle, Vec3};

use super::figure3::PUBLISHED_GAIN;
use crate::TimedIndex;
use crate::bench::measurement::{
    Measured, Measurement, affordable, build, clock_each, count, verified_workload,
};
use crate::bench::plan::{Case, Effort};
use crate::bench::progress::Tick;
use crate::bench::summary::gain_percent;
use crate::bench::workload::Workload;
use crate::scene::Model;
use crate::studies::separation::{cluster_size, clusters_shifted};

/// Lengths of the scene, as a multiple of the clusters' size, but for [`SHORTER`]. The figure of the built-in scene is
/// 11.3 long.
const LENGTHS: [u16; 10] = [4, 8, 16, 32, 64, 128, 256, 512, 1_024, 8_192];
/// What the scene is shorter, 0.3 sizes of a cluster. All coordinates are multiples of 1/8, and exact.
const SHORTER: f32 = 21.0 / 8.0;
/// The highest level that the core allows.
const HIGHEST: u32 = 20;

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
    /// One octree, over a cube that holds the scene.
    pub cube: Finished,
    /// One octree, over the box of the scene; `None` at gaps beyond the first at which the paper's gain is met.
    pub over_box: Option<Finished>,
}

impl ApartRow {
    /// Returns the time that the hierarchy saves over the octree over a cube, in percent.
    pub fn cube_gain(&self) -> f64 {
        self.gain_over(&self.cube)
    }

    /// Returns the time that the hierarchy saves over the octree over the box, in percent.
    pub fn box_gain(&self) -> Option<f64> {
        self.over_box.as_ref().map(|over_box| self.gain_over(over_box))
    }

    fn gain_over(&self, single: &Finished) -> f64 {
        let time = |one: &Finished| one.figures.microseconds_per_photon();
        gain_percent(time(&self.hierarchy), time(single))
    }
}

/// Finds the first gap at which the octree over the box loses as much as the paper's.
pub fn met(rows: &[ApartRow]) -> Option<&ApartRow> {
    rows.iter().find(|row| row.box_gain().is_some_and(|gain| gain >= PUBLISHED_GAIN))
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
        let with_box = met(&rows).is_none();
        rows.push(measure(length, with_box, effort)?);
        progress();
    }
    Ok(rows)
}

fn measure(length: u16, with_box: bool, effort: &Effort) -> anyhow::Result<ApartRow> {
    // 1. The scene and its photons, and the same stretched.
    let (model, gap) = scene(length);
    let workload = verified_workload(&model, effort)?;
    let stretched = if with_box { Some(stretch(&model, length, &workload)?) } else { None };

    // 2. Build.
    let [hierarchy, octree] =
        [IndexKind::OctreeHierarchy, IndexKind::Octree].map(|kind| Case::at_level(kind, HIGHEST));
    let mut jobs = vec![(&model, &workload, &hierarchy), (&model, &workload, &octree)];
    jobs.extend(stretched.as_ref().map(|(model, workload)| (model, workload, &octree)));
    let built = jobs.iter().map(|(model, _, case)| build(model, case, &[]));
    let built = built.collect::<anyhow::Result<Vec<TimedIndex>>>()?;

    // 3. Count, on as many photons as the slowest can answer in the time.
    let mut photons = workload.photon_count();
    for ((_, workload, _), index) in jobs.iter().zip(&built) {
        photons = photons.min(affordable(&index.index(), workload, effort)?);
    }
    let counted = jobs.iter().zip(built).map(|((model, workload, case), index)| {
        let largest_leaf = largest_leaf(&index.index())?;
        Ok((count(model, case, index, workload, photons)?, largest_leaf))
    });
    let mut counted = counted.collect::<anyhow::Result<Vec<(Measured, u32)>>>()?;

    // 4. The clock, in turns.
    let turns = counted.iter_mut().zip(&jobs);
    let mut turns: Vec<_> = turns.map(|((one, _), &(_, workload, _))| (one, workload)).collect();
    clock_each(&mut turns, effort.repetitions, &|| {});

    let finished =
        |(one, largest_leaf): (Measured, u32)| Finished { figures: one.figures, largest_leaf };
    let mut finished = counted.into_iter().map(finished);
    let mut next = || finished.next();
    let pair = next().zip(next());
    let (hierarchy, cube) = pair.context("two cases were measured")?;
    Ok(ApartRow { gap, hierarchy, cube, over_box: next() })
}

fn largest_leaf(index: &AnyIndex<'_>) -> anyhow::Result<u32> {
    Ok(index.check()?.largest_leaf)
}

/// Makes the scene of a length, and returns the gap between its clusters as a multiple of their size.
fn scene(length: u16) -> (Model, f64) {
    let size = cluster_size();
    let shift = size * (f32::from(length) - 1.0) - SHORTER;
    (clusters_shifted(shift), f64::from(shift / size) - 1.0)
}

/// Stretches a model by its length along y and z, until its box is a cube, and the rays of its photons alike; hits stay
/// the same.
///
/// # Errors
/// If a stretched ray is none.
fn stretch(model: &Model, length: u16, workload: &Workload) -> Result<(Model, Workload), RayError> {
    let by = Vec3::new(1.0, f32::from(length), f32::from(length));
    let mut stretched = model.clone();
    stretched.name = format!("{}, stretched", model.name);
    for t in &mut stretched.triangles {
        *t = Triangle::new(t.a * by, t.b * by, t.c * by);
    }
    let ray = |ray: &Ray| {
        let (origin, direction) = (ray.origin() * by, ray.direction() * by);
        Ray::with_interval(origin, direction, ray.t_min(), ray.t_max())
    };
    Ok((stretched, workload.mapped(ray)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::plan::Share;
    use crate::scene::test_support::cluster_counts;
    use arboleda::Options;

    const EFFORT: Effort =
        Effort { photons: 200, repetitions: 1, seconds: 0.01, share: Share::Common, seed: 1 };

    #[test]
    fn a_stretched_scene_fills_a_cube_but_for_a_third_of_a_cluster() {
        for length in LENGTHS {
            let (model, gap) = scene(length);
            let (stretched, _) = stretch(&model, length, &Workload::default()).unwrap();
            let [x, y, z] = stretched.bounds().extent();
            assert!(y == z && y - x == f64::from(SHORTER), "length {length}");
            assert!((f64::from(length) - 2.3 - gap).abs() < 0.01, "gap {gap}");
            assert_eq!(cluster_counts(&model.scene(), &Options::default()).0, 2);
        }
    }

    #[test]
    fn each_octree_has_the_level_it_needs() {
        for (length, cube, over_box) in [(4, 8, 5), (16, 10, 7)] {
            let row = measure(length, true, &EFFORT).unwrap();
            let long = row.over_box.as_ref().unwrap();
            let levels = [&row.hierarchy, &row.cube, long].map(|one| one.figures.deepest_level);
            assert_eq!(levels, [3, cube, over_box], "length {length}");
            assert!([&row.hierarchy, &row.cube, long].iter().all(|one| one.largest_leaf <= 12));
            assert_eq!(row.cube.figures.photons, long.figures.photons);
        }
    }
}
