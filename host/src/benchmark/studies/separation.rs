//! Gain by clusters as they move apart.
//!
//! Figure 3's two clusters of cubes, from touching to 10,000 times their size. A single tree of cells
//! spends its levels on the space between; a single grid has all triangles in a few cells; a tree that
//! divides what is there, such as a bounding volume hierarchy, has little to gain.

use arboleda::{Aabb, IndexKind, Triangle, Vec3};

use crate::benchmark::harness::measurement::{Measurement, measure, verified_workload};
use crate::benchmark::harness::plan::{Case, Effort, pairs};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::summary::gain_percent;
use crate::scene::{AreaLight, Model, paper};

/// The gap between the clusters, as a multiple of their size. With whole numbers all coordinates are
/// exact: multiples of 1/8 below 2^21.
pub const GAPS: [u32; 9] = [0, 1, 3, 10, 30, 100, 300, 1_000, 10_000];

/// Measurements of one kind of index at one gap, alone and in each cluster.
pub struct SeparationRow {
    /// The gap, as a multiple of the clusters' size.
    pub gap: u32,
    /// Alone.
    pub single: Measurement,
    /// One in each cluster.
    pub clustered: Measurement,
}

impl SeparationRow {
    /// Returns what the hierarchy saves over a single index, in percent: of the time, of the cost by counters, and
    /// of the bytes without the triangles.
    pub fn gains(&self) -> Gains {
        let (ours, theirs) = (&self.clustered, &self.single);
        Gains {
            time: gain_percent(ours.microseconds_per_photon(), theirs.microseconds_per_photon()),
            counters: gain_percent(ours.cost_per_ray(), theirs.cost_per_ray()),
            memory: gain_percent(ours.subdivision_bytes as f64, theirs.subdivision_bytes as f64),
        }
    }
}

/// Savings in percent; below 0 where the hierarchy loses.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// Time saved.
    pub time: f64,
    /// Nodes and tests saved, weighted by the cost model.
    pub counters: f64,
    /// Bytes saved, triangles not counted.
    pub memory: f64,
}

/// Makes figure 3 with the clusters at another distance; there is a light above each.
pub fn clusters_apart(gap: u32) -> Model {
    let mut model = clusters_shifted(cluster_size() * (gap as f32 + 1.0));
    model.name = format!("fig3 apart {gap}");
    model
}

/// Returns the size of a cluster of figure 3 along x, y and z.
pub fn cluster_size() -> f32 {
    let extent = left_cluster(&paper::fig3()).1.extent();
    extent[0] as f32
}

/// Returns the triangles of the left cluster of figure 3, and their box.
fn left_cluster(figure3: &Model) -> (&[Triangle], Aabb) {
    let left = &figure3.triangles[..figure3.triangles.len() / 2];
    (left, left.iter().fold(Aabb::EMPTY, |all, triangle| all.union(triangle.bounds())))
}

/// Makes figure 3 with the second cluster a copy of the first, so much further along x; there is a light above each.
pub fn clusters_shifted(shift: f32) -> Model {
    let original = paper::fig3();
    let (left, bounds) = left_cluster(&original);
    let side = bounds.hi.x - bounds.lo.x;
    let mut model = Model::named(format!("fig3 shifted {shift}"));
    for (name, offset) in [("left", Vec3::ZERO), ("right", Vec3::X * shift)] {
        let moved = |t: &Triangle| Triangle::new(t.a + offset, t.b + offset, t.c + offset);
        model.add_object(name, left.iter().map(moved), original.reflectance[0]);
        let centre = bounds.centre().with_z(bounds.hi.z + 1.0) + offset;
        model.lights.push(AreaLight::facing_down(centre, side, side, original.lights[0].flux));
    }
    model
}

/// Counts the steps of `progress`.
pub fn steps() -> u64 {
    (GAPS.len() * pairs().count() * 2) as u64
}

/// Measures every pair of indices at every gap.
///
/// # Errors
/// If two indices do not agree.
pub fn run(effort: &Effort, progress: Tick<'_>) -> anyhow::Result<Vec<SeparationRow>> {
    let kinds: Vec<IndexKind> =
        pairs().flat_map(|(single, clustered)| [single, clustered]).collect();
    let cases: Vec<Case> = kinds.into_iter().map(Case::usual).collect();
    let mut rows = Vec::new();
    for gap in GAPS {
        let model = clusters_apart(gap);
        let workload = verified_workload(&model, effort)?;
        let mut measured = measure(&model, &cases, &workload, effort, progress)?.into_iter();
        while let (Some(single), Some(clustered)) = (measured.next(), measured.next()) {
            rows.push(SeparationRow { gap, single, clustered });
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::test_support::cluster_counts;
    use arboleda::Options;

    #[test]
    fn clusters_are_exact_copies_at_any_distance() {
        for gap in GAPS {
            let model = clusters_apart(gap);
            let half = model.triangles.len() / 2;
            let shift = model.triangles[half].a - model.triangles[0].a;
            for (left, right) in model.triangles[..half].iter().zip(&model.triangles[half..]) {
                let back = Triangle::new(right.a - shift, right.b - shift, right.c - shift);
                assert_eq!(*left, back);
            }
            let clusters = cluster_counts(&model.scene(), &Options::default()).0;
            assert_eq!(clusters, if gap == 0 { 1 } else { 2 });
        }
    }
}
