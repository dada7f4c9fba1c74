//! How far the automatic level and resolution are from the best.
//!
//! Every level and density is tried; the automatic choice is compared with the one whose rays cost least
//! by counters, and with the one that took the least time.

use arboleda::{IndexKind, Options, RayIndex, Scene};
use rayon::prelude::*;

use super::plan::{Case, Effort, Share};
use super::rays::RaySet;
use super::run::{Measurement, build, measure_built};
use crate::OwnedIndex;
use crate::scene::Model;

/// Levels tried: beyond 12 the automatic search does not go, and a level that makes no larger tree than the
/// one before ends the sweep.
const LEVELS: std::ops::RangeInclusive<u32> = 0..=12;
/// Densities tried, in cells per triangle: those of the automatic search, and between them.
const DENSITIES: [f32; 14] =
    [0.06, 0.125, 0.18, 0.25, 0.35, 0.5, 0.71, 1.0, 1.41, 2.0, 2.83, 4.0, 8.0, 16.0];

/// One index on one scene: what it chose, and what else there was.
pub struct LevelCheck {
    /// The scene.
    pub scene: String,
    /// The automatic choice.
    pub automatic: Measurement,
    /// All that was tried.
    pub tried: Vec<Measurement>,
}

impl LevelCheck {
    /// The cheapest by counters.
    pub fn best_by_counters(&self) -> &Measurement {
        self.tried
            .iter()
            .min_by(|a, b| a.cost_per_ray().total_cmp(&b.cost_per_ray()))
            .unwrap_or(&self.automatic)
    }

    /// The fastest.
    pub fn best_by_time(&self) -> &Measurement {
        let time = Measurement::least_microseconds_per_photon;
        self.tried.iter().min_by(|a, b| time(a).total_cmp(&time(b))).unwrap_or(&self.automatic)
    }

    /// What the automatic choice costs more than the best by counters, in percent of the best.
    pub fn excess_cost(&self) -> f64 {
        (self.automatic.cost_per_ray() / self.best_by_counters().cost_per_ray() - 1.0) * 100.0
    }

    /// How much longer the automatic choice takes than the fastest, in percent of the fastest.
    pub fn excess_time(&self) -> f64 {
        let time = Measurement::least_microseconds_per_photon;
        (time(&self.automatic) / time(self.best_by_time()) - 1.0) * 100.0
    }
}

/// Sweeps every index that a level or a density changes.
///
/// # Errors
/// If two indices do not agree.
pub fn run(
    model: &Model,
    effort: &Effort,
    seed: u64,
    progress: &(impl Fn() + Sync),
) -> anyhow::Result<Vec<LevelCheck>> {
    let rays = RaySet::shoot(model, effort.photons, seed)?;
    let effort = Effort { share: Share::Own, ..*effort };
    let mut checks = Vec::new();
    for &kind in IndexKind::ALL {
        let cases = cases(kind, model)?;
        // Nothing is timed while all processors build. What neither changes needs no sweep.
        let built = cases
            .par_iter()
            .map(|case| build(model, case))
            .collect::<anyhow::Result<Vec<OwnedIndex>>>()?;
        let (cases, built) = distinct(cases, built);
        if cases.len() > 1 {
            let mut measured = measure_built(model, &cases, &built, &rays, &effort, &mut || {})?;
            let automatic = measured.remove(0);
            checks.push(LevelCheck { scene: model.name.clone(), automatic, tried: measured });
        }
        progress();
    }
    Ok(checks)
}

/// The automatic choice first, then every level if levels change the index, and every density if densities do.
fn cases(kind: IndexKind, model: &Model) -> anyhow::Result<Vec<Case>> {
    let automatic = Case { setting: "automatic".to_owned(), options: Options::default(), kind };
    let mut cases = vec![automatic];
    if differ(model, &Case::at_level(kind, 0), &Case::at_level(kind, 3))? {
        cases.extend(LEVELS.map(|level| Case::at_level(kind, level)));
    }
    if differ(model, &Case::at_density(kind, 0.1), &Case::at_density(kind, 10.0))? {
        cases.extend(DENSITIES.iter().map(|&density| Case::at_density(kind, density)));
    }
    Ok(cases)
}

/// Whether two cases make different indices of a small part of the model.
fn differ(model: &Model, a: &Case, b: &Case) -> anyhow::Result<bool> {
    let part = &model.triangles[..model.triangles.len().min(2_000)];
    let digest = |case: &Case| -> anyhow::Result<blake3::Hash> {
        let owned = OwnedIndex::build(case.kind, &Scene::new(part), &case.options)?;
        Ok(blake3::hash(owned.index().as_bytes()))
    };
    Ok(digest(a)? != digest(b)?)
}

/// Leaves out what is the same index as one before, but never the automatic choice.
fn distinct(cases: Vec<Case>, built: Vec<OwnedIndex>) -> (Vec<Case>, Vec<OwnedIndex>) {
    let mut digests = Vec::new();
    cases
        .into_iter()
        .zip(built)
        .enumerate()
        .filter(|(at, (_, owned))| {
            let digest = blake3::hash(owned.index().as_bytes());
            let known = digests.contains(&digest);
            // The same tree as the automatic one is tried again: it may be the best.
            if *at > 0 && !known {
                digests.push(digest);
            }
            *at == 0 || !known
        })
        .map(|(_, pair)| pair)
        .unzip()
}
