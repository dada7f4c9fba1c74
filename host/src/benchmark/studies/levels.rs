//! Distance of the automatic level and resolution from the best.
//!
//! ```text
//! levels 0, 1, 2 ... -> probe -> those near the cheapest -> count -> the few cheapest -> time
//! ```
//! Every level and density is built and probed; the automatic choice, which is given some of the rays, is compared
//! with the one whose rays cost least by counters, and with the fastest of the few cheapest.

use arboleda::{IndexKind, Level, Scene};
use rayon::prelude::*;

use crate::TimedIndex;
use crate::benchmark::harness::measurement::{Measured, Measurement, build, checked, clock, count};
use crate::benchmark::harness::plan::{Case, Effort, PROBE_PHOTONS};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::summary::Spread;
use crate::benchmark::harness::workload::Workload;
use crate::scene::Model;

/// Levels tried: beyond 12 the automatic search does not go.
const LEVELS: std::ops::RangeInclusive<u32> = 0..=12;
/// Densities tried, in cells per triangle: a factor of the square root of two apart around the usual ones.
const DENSITIES: [f32; 18] = [
    0.004, 0.008, 0.016, 0.031, 0.062, 0.125, 0.18, 0.25, 0.35, 0.5, 0.71, 1.0, 1.41, 2.0, 2.83,
    4.0, 8.0, 16.0,
];
/// Multiple of the cheapest probe at which the sweep ends, and from which on a choice is not counted.
const HOPELESS: f64 = 1.5;
/// Number of the cheapest choices that are timed, beside the automatic one.
const TIMED: usize = 4;
/// Multiple of the usual repetitions in which they are timed, because a repetition takes milliseconds.
const MORE_OFTEN: usize = 3;

/// Automatic choice of one index on one scene, and the others that were tried.
pub struct LevelCheck {
    /// The scene.
    pub scene: String,
    /// The automatic choice.
    pub automatic: Measurement,
    /// Choices near the cheapest, the cheapest by counters first; only the first few were timed.
    pub tried: Vec<Measurement>,
    /// The fastest of those timed that are not the automatic choice itself, and how many times its time the
    /// automatic choice takes: the median over the rounds, each of which times both.
    pub fastest: Option<(usize, f64)>,
}

impl LevelCheck {
    /// Finds the cheapest by counters.
    pub fn best_by_counters(&self) -> &Measurement {
        self.tried.first().unwrap_or(&self.automatic)
    }

    /// Finds the fastest of all timed.
    pub fn best_by_time(&self) -> &Measurement {
        match self.fastest {
            Some((at, ratio)) if ratio > 1.0 => self.tried.get(at).unwrap_or(&self.automatic),
            _ => &self.automatic,
        }
    }

    /// Returns what the automatic choice costs more than the best by counters, in percent of the best.
    pub fn excess_cost(&self) -> f64 {
        (self.automatic.cost_per_ray() / self.best_by_counters().cost_per_ray() - 1.0) * 100.0
    }

    /// Returns how much longer the automatic choice takes than the fastest other, in percent of that; below 0 where it
    /// is the fastest of all, and 0 where no other was timed.
    pub fn excess_time(&self) -> f64 {
        self.fastest.map_or(0.0, |(_, ratio)| (ratio - 1.0) * 100.0)
    }
}

/// Counts the steps of `progress` for one scene.
pub fn steps() -> u64 {
    IndexKind::ALL.len() as u64
}

/// Sweeps every index that a level or a density changes; times nothing.
///
/// # Errors
/// If two indices do not agree.
pub fn by_counters(
    model: &Model,
    photons: u64,
    seed: u64,
    progress: Tick<'_>,
) -> anyhow::Result<Vec<LevelCheck>> {
    let workload = Workload::of_photons(model, photons, seed)?;
    let swept = sweep_all(model, &workload, progress)?;
    Ok(swept.into_iter().map(|choices| check(model, choices, None)).collect())
}

/// Sweeps as [`by_counters`], and times the cheapest.
///
/// # Errors
/// If two indices do not agree.
pub fn run(model: &Model, effort: &Effort, progress: Tick<'_>) -> anyhow::Result<Vec<LevelCheck>> {
    let workload = Workload::of_photons(model, effort.photons, effort.seed)?;
    let mut checks = Vec::new();
    for mut choices in sweep_all(model, &workload, progress)? {
        // The automatic choice, and the cheapest that are not the same index: each with its place.
        let contestants = choices.iter_mut().enumerate().filter(|(_, choice)| !choice.repeats);
        let (places, mut timed): (Vec<_>, Vec<_>) = contestants
            .take(1 + TIMED)
            .map(|(place, choice)| (place, &mut choice.measured))
            .unzip();
        let times = clock(&mut timed, &workload, effort.repetitions * MORE_OFTEN, &|| {});
        let others = places.iter().zip(&times).skip(1);
        let ratios = others.map(|(place, other)| (place - 1, median_ratio(&times[0], other)));
        let fastest = ratios.max_by(|a, b| a.1.total_cmp(&b.1));
        checks.push(check(model, choices, fastest));
    }
    Ok(checks)
}

/// Returns how many times as long `ours` takes as `theirs`, in the middle of all rounds.
fn median_ratio(ours: &[f64], theirs: &[f64]) -> f64 {
    let ratios: Vec<f64> = ours.iter().zip(theirs).map(|(ours, theirs)| ours / theirs).collect();
    Spread::of(&ratios).median
}

fn check(model: &Model, choices: Vec<Choice>, fastest: Option<(usize, f64)>) -> LevelCheck {
    let mut measured = choices.into_iter().map(|choice| choice.measured.figures);
    let automatic = measured.next().expect("the automatic choice stands first");
    LevelCheck { scene: model.name.clone(), automatic, tried: measured.collect(), fastest }
}

/// Level or density that was built and counted.
struct Choice {
    measured: Measured,
    /// True if it is, byte for byte, the automatic choice once more.
    repeats: bool,
}

/// Lists the choices of each index that has any: the automatic one, then the others from the cheapest on.
fn sweep_all(
    model: &Model,
    workload: &Workload,
    progress: Tick<'_>,
) -> anyhow::Result<Vec<Vec<Choice>>> {
    let swept: Vec<Vec<Choice>> = IndexKind::ALL
        .par_iter()
        .map(|&kind| {
            let choices = sweep(kind, model, workload);
            progress();
            choices
        })
        .collect::<anyhow::Result<_>>()?;
    Ok(swept.into_iter().filter(|choices| choices.len() > 1).collect())
}

fn sweep(kind: IndexKind, model: &Model, workload: &Workload) -> anyhow::Result<Vec<Choice>> {
    // 1. Build and probe, until it gets hopeless or nothing changes any more.
    let mut probed: Vec<(f64, Case, TimedIndex, blake3::Hash)> = Vec::new();
    for cases in cases(kind, model)? {
        let mut least = f64::INFINITY;
        let mut last = None;
        for case in cases {
            let built = build(model, &case, &[])?;
            let digest = blake3::hash(built.as_bytes());
            if last.replace(digest) == Some(digest) {
                // Where one more level changes nothing, no deeper one does; another density may.
                if case.options.level == Level::Automatic {
                    continue;
                }
                break;
            }
            let counters = checked(&built.index(), workload, PROBE_PHOTONS)?;
            let weights = kind.cost_model();
            let cost = weights.traversal * counters.nodes_visited as f64
                + weights.intersection * counters.triangle_tests as f64;
            if cost > least * HOPELESS {
                break;
            }
            least = least.min(cost);
            probed.push((cost, case, built, digest));
        }
    }
    if probed.is_empty() {
        return Ok(Vec::new());
    }

    // 2. Count those near the cheapest.
    let least = probed.iter().map(|(cost, ..)| *cost).fold(f64::INFINITY, f64::min);
    let automatic = Case { setting: "automatic".to_owned(), ..Case::usual(kind) };
    let chosen = build(model, &automatic, workload.sample())?;
    let digest = blake3::hash(chosen.as_bytes());
    let counted = |case: &Case, built: TimedIndex, repeats: bool| {
        let measured = count(model, case, built, workload, workload.photon_count())?;
        anyhow::Ok(Choice { measured, repeats })
    };
    let mut choices = vec![counted(&automatic, chosen, false)?];
    for (cost, case, built, probed) in probed {
        if cost <= least * HOPELESS {
            choices.push(counted(&case, built, probed == digest)?);
        }
    }
    let cost = |choice: &Choice| choice.measured.figures.cost_per_ray();
    choices[1..].sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    Ok(choices)
}

/// Lists all levels if levels change the index, and all densities if densities do.
fn cases(kind: IndexKind, model: &Model) -> anyhow::Result<Vec<Vec<Case>>> {
    let mut runs: Vec<Vec<Case>> = Vec::new();
    if differ(model, &Case::at_level(kind, 0), &Case::at_level(kind, 3))? {
        runs.push(LEVELS.map(|level| Case::at_level(kind, level)).collect());
    }
    if differ(model, &Case::at_density(kind, 0.1), &Case::at_density(kind, 10.0))? {
        runs.push(DENSITIES.iter().map(|&density| Case::at_density(kind, density)).collect());
    }
    Ok(runs)
}

/// Tells whether two cases make different indices of a small part of the model.
fn differ(model: &Model, a: &Case, b: &Case) -> anyhow::Result<bool> {
    let part = &model.triangles[..model.triangles.len().min(2_000)];
    let digest = |case: &Case| -> anyhow::Result<blake3::Hash> {
        let owned = TimedIndex::build(case.kind, &Scene::new(part), &case.options)?;
        Ok(blake3::hash(owned.as_bytes()))
    };
    Ok(digest(a)? != digest(b)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::city::{CityOptions, procedural_city};
    use crate::scene::mixed::{MixedOptions, mixed_sizes};
    use crate::scene::paper;

    /// In percent; the same on every machine, because it is counted.
    const MOST_EXCESS: f64 = 5.0;

    /// On the larger scenes `compare levels` says the same, in some minutes.
    #[test]
    fn automatic_choices_cost_at_most_5_percent_more_than_the_best() {
        let city = CityOptions { blocks: [2, 2], buildings_per_side: 2, ..CityOptions::default() };
        let mixed = MixedOptions { object_count: 60, detail: 1, ..MixedOptions::default() };
        for model in [paper::fig2(), paper::fig3(), procedural_city(city), mixed_sizes(mixed)] {
            let checks = by_counters(&model, 1_000, 1, &|| {}).unwrap();
            for name in ["octree", "octree-r", "uniform-grid", "kd-tree", "bsp-tree"] {
                assert!(checks.iter().any(|check| check.automatic.case.kind.name() == name));
            }
            for check in &checks {
                let name = check.automatic.case.kind.name();
                assert!(
                    check.excess_cost() <= MOST_EXCESS,
                    "{} on {}: {:.1}% more than {}",
                    name,
                    check.scene,
                    check.excess_cost(),
                    check.best_by_counters().case.setting
                );
            }
        }
    }
}
