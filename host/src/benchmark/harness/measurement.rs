//! Measurement of an index: its size, the nodes and tests of its queries, and their time, after its answers are
//! compared.
//!
//! ```text
//! build -> probe (how many photons) -> answers, counted == the guide's -> 1 2 3 1 2 3 1 2 3 ... timed
//! ```

use anyhow::{Context, ensure};
use arboleda::{AnyIndex, Counters, Hit, IndexKind, Ray};

use super::plan::{Case, Effort, PROBE_PHOTONS, Share, photons_within};
use super::progress::Tick;
use super::summary::Spread;
use super::timing::{Turn, time};
use super::workload::{Workload, same_bits};
use crate::TimedIndex;
use crate::benchmark::contenders::contender::Mode;
use crate::benchmark::contenders::ours::Ours;
use crate::scene::Model;

/// Triangle tests of the linear scan while it checks rays; they take about half a second.
const ORACLE_TESTS: usize = 30_000_000;
/// The most rays that the linear scan checks.
const ORACLE_RAYS: usize = 4_096;

/// Figures of one case.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The index, and how it was built.
    pub case: Case,
    /// Triangles of the scene.
    pub triangle_count: usize,
    /// Time of the build.
    pub build_seconds: f64,
    /// The whole index.
    pub bytes: usize,
    /// The index without the triangles: what the way of dividing costs. With them where the index keeps them in a form
    /// of its own.
    pub subdivision_bytes: usize,
    /// Clusters found; 1 for a simple index.
    pub cluster_count: u32,
    /// The level of the deepest leaf.
    pub deepest_level: u32,
    /// Photons to each repetition.
    pub photons: u64,
    /// Their rays.
    pub ray_count: usize,
    /// Nodes and tests that answering these rays took.
    pub counters: Counters,
    /// Time of answering them; NaN if that was not measured.
    pub seconds: Spread,
    /// Number of times that they were answered against the clock.
    pub repetitions: usize,
}

impl Measurement {
    /// Returns the photons per second, by the median.
    pub fn photons_per_second(&self) -> f64 {
        self.photons as f64 / self.seconds.median
    }

    /// Returns the rays per second, by the median.
    pub fn rays_per_second(&self) -> f64 {
        self.ray_count as f64 / self.seconds.median
    }

    /// Returns the microseconds for each photon, by the median.
    pub fn microseconds_per_photon(&self) -> f64 {
        self.seconds.median / self.photons as f64 * 1e6
    }

    /// Returns the nodes visited for each ray.
    pub fn nodes_per_ray(&self) -> f64 {
        self.counters.nodes_visited as f64 / self.ray_count as f64
    }

    /// Returns the triangle tests for each ray.
    pub fn tests_per_ray(&self) -> f64 {
        self.counters.triangle_tests as f64 / self.ray_count as f64
    }

    /// Returns the cost of a ray as the index's cost model weighs nodes and tests.
    pub fn cost_per_ray(&self) -> f64 {
        let cost = self.case.options.cost.unwrap_or(self.case.kind.cost_model());
        cost.traversal * self.nodes_per_ray() + cost.intersection * self.tests_per_ray()
    }
}

/// Index and what it takes by counters; also by the clock, once [`clock`] has looked at it.
pub struct Measured {
    /// The index.
    pub index: TimedIndex,
    /// Its figures.
    pub figures: Measurement,
}

/// Follows the photons of a model, and compares the guide's hits with the linear scan's, on a share of the rays.
///
/// # Errors
/// If nothing in the model emits, or at the first ray on which they differ.
pub fn verified_workload(model: &Model, effort: &Effort) -> anyhow::Result<Workload> {
    let workload = Workload::of_photons(model, effort.photons, effort.seed)?;
    let few = (ORACLE_TESTS / model.triangles.len().max(1)).clamp(16, ORACLE_RAYS);
    let oracle = build(model, &Case::usual(IndexKind::Linear), &[])?;
    let oracle = oracle.index();
    let rays = workload.rays(Mode::Single).iter().zip(&workload.hits);
    for (at, (ray, hit)) in rays.take(few).enumerate() {
        ensure!(
            same_bits(oracle.closest_hit(ray).unwrap_or(Hit::NONE), *hit),
            "the linear scan and the guide differ on ray {at} of {}",
            model.name
        );
    }
    Ok(workload)
}

/// Builds an index of a model as a case says, for rays such as these; where the case says all, they do not matter.
///
/// # Errors
/// If an option is out of range.
pub fn build(model: &Model, case: &Case, rays: &[Ray]) -> anyhow::Result<TimedIndex> {
    TimedIndex::build(case.kind, &model.scene().rays(rays), &case.options)
        .with_context(|| format!("cannot build {} of {}", case.kind.name(), model.name))
}

/// Measures the cases on the same rays, on this thread; calls `progress` after each.
///
/// # Errors
/// If an index cannot be built, or an answer is not, bit for bit, the guide's.
pub fn measure(
    model: &Model,
    cases: &[Case],
    workload: &Workload,
    effort: &Effort,
    progress: Tick<'_>,
) -> anyhow::Result<Vec<Measurement>> {
    // 1. Build.
    let built = cases.iter().map(|case| build(model, case, workload.sample()));
    let built = built.collect::<anyhow::Result<Vec<_>>>()?;

    // 2. How many photons each can answer in the time.
    let shares = built.iter().map(|index| affordable(&index.index(), workload, effort));
    let mut shares = shares.collect::<anyhow::Result<Vec<u64>>>()?;
    if effort.share == Share::Common {
        let least = shares.iter().copied().min().unwrap_or(0);
        shares.fill(least);
    }

    // 3. The answers.
    let mut all = Vec::new();
    for ((case, index), photons) in cases.iter().zip(built).zip(shares) {
        all.push(count(model, case, index, workload, photons)?);
        progress();
    }

    // 4. The clock.
    clock(&mut all.iter_mut().collect::<Vec<_>>(), workload, effort.repetitions, &|| {});
    Ok(all.into_iter().map(|one| one.figures).collect())
}

/// Returns how many photons an index can answer in the time, judged by the first few.
///
/// # Errors
/// If an answer is not, bit for bit, the guide's.
pub fn affordable(
    index: &AnyIndex<'_>,
    workload: &Workload,
    effort: &Effort,
) -> anyhow::Result<u64> {
    let probed = PROBE_PHOTONS.min(workload.photon_count());
    let counters = checked(index, workload, probed)?;
    let photons = photons_within(effort, counters, workload.rays_of_first(probed).len(), probed);
    Ok(photons.min(workload.photon_count()))
}

/// Counts what an index takes and compares its answers; the clock is still to come.
///
/// # Errors
/// If an answer is not, bit for bit, the guide's.
pub fn count(
    model: &Model,
    case: &Case,
    index: TimedIndex,
    workload: &Workload,
    photons: u64,
) -> anyhow::Result<Measured> {
    let opened = index.index();
    let apart = !case.kind.holds_triangles();
    let triangle_bytes = if apart { size_of_val(&*model.triangles) } else { 0 };
    let figures = Measurement {
        case: case.clone(),
        triangle_count: model.triangles.len(),
        build_seconds: index.build_seconds(),
        bytes: index.bytes(),
        subdivision_bytes: index.bytes() - triangle_bytes,
        cluster_count: opened.sections().cluster_count(),
        deepest_level: opened.check()?.deepest_level,
        photons,
        ray_count: workload.rays_of_first(photons).len(),
        counters: checked(&opened, workload, photons)?,
        seconds: Spread::of(&[]),
        repetitions: 0,
    };
    Ok(Measured { index, figures })
}

/// Times the indices on the photons that each was counted on, in turns; calls `progress` after each round. Returns all
/// times of each, in seconds.
pub fn clock(
    all: &mut [&mut Measured],
    workload: &Workload,
    repetitions: usize,
    progress: Tick<'_>,
) -> Vec<Vec<f64>> {
    let contenders: Vec<_> = all.iter().map(|one| Ours(one.index.index())).collect();
    let turns = all.iter().zip(&contenders).map(|(one, contender)| Turn {
        contender,
        mode: Mode::Single,
        rays: workload.rays_of_first(one.figures.photons),
    });
    let times = time(&turns.collect::<Vec<_>>(), repetitions, progress);
    drop(contenders);
    for (one, times) in all.iter_mut().zip(&times) {
        one.figures.seconds = Spread::of(times);
        one.figures.repetitions = times.len();
    }
    times
}

/// Answers the rays of the first photons, compares with the guide's hits, and counts what it took.
///
/// # Errors
/// At the first ray on which they differ.
pub fn checked(
    index: &AnyIndex<'_>,
    workload: &Workload,
    photons: u64,
) -> anyhow::Result<Counters> {
    let mut counters = Counters::default();
    let asked = workload.rays_of_first(photons).iter().zip(workload.hits_of_first(photons));
    for (at, (ray, expected)) in asked.enumerate() {
        let found = index.closest_hit_counted(ray, &mut counters).unwrap_or(Hit::NONE);
        ensure!(
            same_bits(found, *expected),
            "{} answers ray {at} with {found:?} instead of {expected:?}: please report this scene",
            index.kind().name()
        );
    }
    Ok(counters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::paper::fig2;

    #[test]
    fn every_index_is_measured_and_agrees() {
        let model = fig2();
        let effort =
            Effort { photons: 100, repetitions: 2, seconds: 0.1, share: Share::Own, seed: 1 };
        let workload = verified_workload(&model, &effort).unwrap();
        let cases: Vec<Case> = IndexKind::ALL.iter().map(|&kind| Case::usual(kind)).collect();
        let measured = measure(&model, &cases, &workload, &effort, &|| {}).unwrap();
        assert_eq!(measured.len(), IndexKind::ALL.len());
        for one in &measured {
            assert!(one.seconds.min > 0.0 && one.seconds.min <= one.seconds.max);
            assert_eq!(one.subdivision_bytes == one.bytes, one.case.kind.holds_triangles());
            assert_eq!(one.repetitions, 2);
        }
    }
}
