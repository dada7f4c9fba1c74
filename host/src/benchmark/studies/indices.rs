//! Every index on one scene, with the linear scan on a share of the photons.

use arboleda::select::Selection;
use arboleda::{IndexKind, Options};

use crate::benchmark::harness::measurement::{Measurement, measure, verified_workload};
use crate::benchmark::harness::plan::{Case, Effort, Share};
use crate::benchmark::harness::progress::Tick;
use crate::scene::Model;
use crate::select_index;

/// Measurements of all indices on one scene, and the automatic selections.
pub struct SceneComparison {
    /// The scene.
    pub scene: String,
    /// Measurements in the order of [`IndexKind::ALL`]: the linear scan first.
    pub measured: Vec<Measurement>,
    /// The automatic selection by the scene's own sample of rays.
    pub by_sample: Selection,
    /// The automatic selection by the first of the photons' rays.
    pub by_rays: Selection,
}

impl SceneComparison {
    /// Returns how many times as long as the fastest an index takes.
    pub fn times_fastest(&self, one: &Measurement) -> f64 {
        let time = Measurement::microseconds_per_photon;
        let fastest = self.measured.iter().map(time).fold(f64::INFINITY, f64::min);
        time(one) / fastest
    }

    /// Finds what was measured of an index.
    pub fn of(&self, kind: IndexKind) -> Option<&Measurement> {
        self.measured.iter().find(|one| one.case.kind == kind)
    }

    /// Finds the index of the most rays per second.
    pub fn fastest(&self) -> Option<&Measurement> {
        let rate = Measurement::rays_per_second;
        self.measured.iter().max_by(|a, b| rate(a).total_cmp(&rate(b)))
    }

    /// Returns how many fewer rays per second the index selected answers than the fastest of all, in percent of the
    /// fastest.
    pub fn loss_percent(&self, selection: &Selection) -> f64 {
        let rate = |one: Option<&Measurement>| one.map_or(f64::NAN, Measurement::rays_per_second);
        (1.0 - rate(self.of(selection.kind())) / rate(self.fastest())) * 100.0
    }
}

/// Counts the steps of `progress` for one scene.
pub fn steps() -> u64 {
    IndexKind::ALL.len() as u64
}

/// Measures every index.
///
/// # Errors
/// If two indices do not agree, or the model has no light.
pub fn run(model: &Model, effort: &Effort, progress: Tick<'_>) -> anyhow::Result<SceneComparison> {
    let workload = verified_workload(model, effort)?;
    let cases: Vec<Case> = IndexKind::ALL.iter().map(|&kind| Case::usual(kind)).collect();
    let effort = Effort { share: Share::Own, ..*effort };
    let measured = measure(model, &cases, &workload, &effort, progress)?;
    let options = Options::default();
    // Every candidate is tried: the question is which is best for so many rays that builds do not matter.
    let scene = model.scene().expecting(u64::MAX);
    let by_sample = select_index(&scene, &options)?;
    let by_rays = select_index(&scene.rays(workload.sample()), &options)?;
    Ok(SceneComparison { scene: model.name.clone(), measured, by_sample, by_rays })
}
