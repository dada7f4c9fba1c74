//! Builds, compares the answers, and only then looks at the clock.
//!
//! ```text
//! build -> probe (how many photons) -> answers, counted == the guide's -> 1 2 3 1 2 3 1 2 3 ... timed
//! ```
//! Repetitions take turns, so that what disturbs the machine for a second disturbs every case. The clock is the
//! processor time of one thread.

use std::hint::black_box;

use anyhow::{Context, ensure};
use arboleda::{AnyIndex, Counters, IndexKind, Ray, RayIndex};
use cpu_time::ThreadTime;

use super::plan::{Case, Effort, PROBE_PHOTONS, Share, photons_within};
use super::rays::{RaySet, same_bits};
use super::spread::Spread;
use crate::OwnedIndex;
use crate::scene::Model;

/// Rays that the linear scan checks: so many tests, in which it takes about half a second.
const ORACLE_TESTS: usize = 30_000_000;
/// The most rays that the linear scan checks.
const ORACLE_RAYS: usize = 4_096;

/// What one case took.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Which index, built how.
    pub case: Case,
    /// How many triangles the scene has.
    pub triangle_count: usize,
    /// How long the build took.
    pub build_seconds: f64,
    /// The whole index.
    pub bytes: usize,
    /// The index without the triangles: what the way of dividing costs. With them where the index keeps them in a form
    /// of its own.
    pub subdivision_bytes: usize,
    /// How many clusters it found; 1 for a simple index.
    pub cluster_count: u32,
    /// The level of the deepest leaf.
    pub deepest_level: u32,
    /// Photons to each repetition.
    pub photons: u64,
    /// Their rays.
    pub ray_count: usize,
    /// What answering these rays took.
    pub counters: Counters,
    /// How long answering them took; NaN if that was not measured.
    pub seconds: Spread,
    /// How often they were answered against the clock.
    pub repetitions: usize,
}

impl Measurement {
    /// Photons per second, by the median.
    pub fn photons_per_second(&self) -> f64 {
        self.photons as f64 / self.seconds.median
    }

    /// Rays per second, by the median.
    pub fn rays_per_second(&self) -> f64 {
        self.ray_count as f64 / self.seconds.median
    }

    /// Microseconds for each photon, by the median.
    pub fn microseconds_per_photon(&self) -> f64 {
        self.seconds.median / self.photons as f64 * 1e6
    }

    /// Nodes visited for each ray.
    pub fn nodes_per_ray(&self) -> f64 {
        self.counters.nodes_visited as f64 / self.ray_count as f64
    }

    /// Triangle tests for each ray.
    pub fn tests_per_ray(&self) -> f64 {
        self.counters.triangle_tests as f64 / self.ray_count as f64
    }

    /// The cost of a ray as the index's cost model weighs nodes and tests.
    pub fn cost_per_ray(&self) -> f64 {
        let cost = self.case.options.cost.unwrap_or(self.case.kind.cost_model());
        cost.traversal * self.nodes_per_ray() + cost.intersection * self.tests_per_ray()
    }
}

/// The time saved over the slower, in percent: above 0 where `ours` is faster, below where `theirs` is.
///
/// # Source
/// Aguilera et al., tables 1 to 3.
pub fn gain_percent(ours: f64, theirs: f64) -> f64 {
    let slower = ours.max(theirs);
    if slower > 0.0 { (theirs - ours) / slower * 100.0 } else { 0.0 }
}

/// Compares the guide's hits with the linear scan's, on a share of the rays.
///
/// # Errors
/// At the first ray on which they differ.
pub fn check_against_oracle(model: &Model, rays: &RaySet) -> anyhow::Result<()> {
    let few = (ORACLE_TESTS / model.triangles.len().max(1)).clamp(16, ORACLE_RAYS);
    let owned = OwnedIndex::build(
        IndexKind::Linear,
        &model.scene(),
        &Case::usual(IndexKind::Linear).options,
    )?;
    let index = owned.index();
    let all = rays.photon_count();
    for (at, (ray, hit)) in
        rays.of_first(all).iter().zip(rays.hits_of_first(all)).take(few).enumerate()
    {
        ensure!(
            same_bits(index.closest_hit(ray), *hit),
            "the linear scan and the guide differ on ray {at} of {}",
            model.name
        );
    }
    Ok(())
}

/// Builds an index of a model as a case says, for rays such as these; where the case says all, they do not matter.
///
/// # Errors
/// If an option is out of range.
pub fn build(model: &Model, case: &Case, rays: &[Ray]) -> anyhow::Result<OwnedIndex> {
    OwnedIndex::build(case.kind, &model.scene().rays(rays), &case.options)
        .with_context(|| format!("cannot build {} of {}", case.kind.name(), model.name))
}

/// Measures the cases on the same rays, on this thread; `progress` is called after each with 1.
///
/// # Errors
/// If an index cannot be built, or an answer is not, bit for bit, the guide's.
pub fn measure(
    model: &Model,
    cases: &[Case],
    rays: &RaySet,
    effort: &Effort,
    progress: &mut dyn FnMut(),
) -> anyhow::Result<Vec<Measurement>> {
    // 1. Build.
    let built = cases.iter().map(|case| build(model, case, rays.sample()));
    let built = built.collect::<anyhow::Result<Vec<_>>>()?;
    measure_built(model, cases, &built, rays, effort, progress)
}

/// As [`measure`], with indices built before.
///
/// # Errors
/// If an answer is not, bit for bit, the guide's.
pub fn measure_built(
    model: &Model,
    cases: &[Case],
    built: &[OwnedIndex],
    rays: &RaySet,
    effort: &Effort,
    progress: &mut dyn FnMut(),
) -> anyhow::Result<Vec<Measurement>> {
    let indices: Vec<AnyIndex<'_>> = built.iter().map(OwnedIndex::index).collect();

    // 2. How many photons each can answer in the time.
    let shares = indices.iter().map(|index| affordable(index, rays, effort));
    let mut shares = shares.collect::<anyhow::Result<Vec<u64>>>()?;
    if effort.share == Share::Common {
        let least = shares.iter().copied().min().unwrap_or(0);
        shares.fill(least);
    }

    // 3. The answers.
    let mut measurements = Vec::new();
    for (at, case) in cases.iter().enumerate() {
        measurements.push(count(model, case, &built[at], rays, shares[at])?);
        progress();
    }

    // 4. The clock.
    let mut contest: Vec<_> = indices.iter().zip(&mut measurements).collect();
    clock(&mut contest, rays, effort.repetitions);
    Ok(measurements)
}

/// How many photons an index can answer in the time, judged by the first few.
///
/// # Errors
/// If an answer is not, bit for bit, the guide's.
pub fn affordable(index: &AnyIndex<'_>, rays: &RaySet, effort: &Effort) -> anyhow::Result<u64> {
    let probed = PROBE_PHOTONS.min(rays.photon_count());
    let counters = checked(index, rays, probed)?;
    let photons = photons_within(effort, counters, rays.of_first(probed).len(), probed);
    Ok(photons.min(rays.photon_count()))
}

/// What an index takes by counters, its answers compared; the clock is still to come.
///
/// # Errors
/// If an answer is not, bit for bit, the guide's.
pub fn count(
    model: &Model,
    case: &Case,
    built: &OwnedIndex,
    rays: &RaySet,
    photons: u64,
) -> anyhow::Result<Measurement> {
    let index = built.index();
    let sections = index.sections();
    let apart = !case.kind.holds_triangles();
    let triangle_bytes = if apart { size_of_val(&*model.triangles) } else { 0 };
    Ok(Measurement {
        case: case.clone(),
        triangle_count: model.triangles.len(),
        build_seconds: built.build_seconds(),
        bytes: built.bytes(),
        subdivision_bytes: built.bytes() - triangle_bytes,
        cluster_count: sections.cluster_count(),
        deepest_level: index.check()?.deepest_level,
        photons,
        ray_count: rays.of_first(photons).len(),
        counters: checked(&index, rays, photons)?,
        seconds: Spread::of(&[]),
        repetitions: 0,
    })
}

/// Times the indices on the photons that each was counted on, in turns; returns all times of each, in seconds.
pub fn clock(
    contest: &mut [(&AnyIndex<'_>, &mut Measurement)],
    rays: &RaySet,
    repetitions: usize,
) -> Vec<Vec<f64>> {
    let mut times = vec![Vec::new(); contest.len()];
    for _ in 0..repetitions.max(1) {
        for ((index, measured), times) in contest.iter().zip(&mut times) {
            times.push(replay(index.as_ray_index(), rays.of_first(measured.photons)));
        }
    }
    for ((_, measured), times) in contest.iter_mut().zip(&times) {
        measured.seconds = Spread::of(times);
        measured.repetitions = times.len();
    }
    times
}

/// Answers the rays of the first photons, compares with the guide's hits, and says what it took.
///
/// # Errors
/// At the first ray on which they differ.
pub fn checked(index: &AnyIndex<'_>, rays: &RaySet, photons: u64) -> anyhow::Result<Counters> {
    let mut counters = Counters::default();
    let asked = rays.of_first(photons).iter().zip(rays.hits_of_first(photons));
    for (at, (ray, expected)) in asked.enumerate() {
        let found = index.closest_hit_counted(ray, &mut counters);
        ensure!(
            same_bits(found, *expected),
            "{} answers ray {at} with {found:?} instead of {expected:?}: please report this scene",
            index.kind().name()
        );
    }
    Ok(counters)
}

/// The processor time of this thread, so that other programs' share of the processor is not counted; they
/// still take some of its caches.
fn replay(index: &(dyn RayIndex + Sync), rays: &[Ray]) -> f64 {
    let start = ThreadTime::now();
    for ray in rays {
        black_box(index.closest_hit(black_box(ray)));
    }
    start.elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::paper::fig2;

    #[test]
    fn gains_are_the_papers() {
        assert!((gain_percent(51.55, 70.25) - 26.6).abs() < 0.05);
        assert!((gain_percent(97.05, 95.92) - -1.2).abs() < 0.05);
        assert_eq!(gain_percent(0.0, 0.0), 0.0);
    }

    #[test]
    fn every_index_is_measured_and_agrees() {
        let model = fig2();
        let rays = RaySet::shoot(&model, 100, 1).unwrap();
        check_against_oracle(&model, &rays).unwrap();
        let cases: Vec<Case> = IndexKind::ALL.iter().map(|&kind| Case::usual(kind)).collect();
        let effort = Effort { photons: 100, repetitions: 2, seconds: 0.1, share: Share::Own };
        let mut steps = 0;
        let measured = measure(&model, &cases, &rays, &effort, &mut || steps += 1).unwrap();
        assert_eq!((measured.len(), steps), (IndexKind::ALL.len(), IndexKind::ALL.len()));
        for one in &measured {
            assert!(one.seconds.min > 0.0 && one.seconds.min <= one.seconds.max);
            assert_eq!(one.subdivision_bytes == one.bytes, one.case.kind.holds_triangles());
            assert_eq!(one.repetitions, 2);
        }
    }
}
