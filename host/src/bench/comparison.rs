//! Every index on one scene, with the linear scan on a share of the photons.

use arboleda::IndexKind;

use super::plan::{Case, Effort, Share};
use super::rays::RaySet;
use super::run::{Measurement, check_against_oracle, measure};
use crate::scene::Model;

/// All indices on one scene.
pub struct SceneComparison {
    /// The scene.
    pub scene: String,
    /// As [`IndexKind::ALL`]: the linear scan first.
    pub measured: Vec<Measurement>,
}

impl SceneComparison {
    /// How many times as long as the fastest an index takes.
    pub fn times_fastest(&self, one: &Measurement) -> f64 {
        let time = Measurement::microseconds_per_photon;
        let fastest = self.measured.iter().map(time).fold(f64::INFINITY, f64::min);
        time(one) / fastest
    }
}

/// How many steps `progress` takes for one scene.
pub fn steps() -> u64 {
    IndexKind::ALL.len() as u64
}

/// Measures every index.
///
/// # Errors
/// If two indices do not agree, or the model has no light.
pub fn run(
    model: &Model,
    effort: &Effort,
    seed: u64,
    progress: &mut dyn FnMut(),
) -> anyhow::Result<SceneComparison> {
    let rays = RaySet::shoot(model, effort.photons, seed)?;
    check_against_oracle(model, &rays)?;
    let cases: Vec<Case> = IndexKind::ALL.iter().map(|&kind| Case::usual(kind)).collect();
    let effort = Effort { share: Share::Own, ..*effort };
    let measured = measure(model, &cases, &rays, &effort, progress)?;
    Ok(SceneComparison { scene: model.name.clone(), measured })
}
