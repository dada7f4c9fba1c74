//! Time of a ray, a node and a test in each index: the weights behind the automatic selection.
//!
//! ```text
//! seconds = rays * ray + nodes visited * node + triangle tests * test      one row for each scene and setting
//! ```
//! A simple index and its hierarchy are fitted together. The two share the local index; where they are close, their
//! counters tell them apart, and not the errors of two fits. Each index of the core states its weights in `Described`;
//! this prints those lines anew:
//!
//! ```text
//! cargo run --release -p arboleda-host -- compare calibrate
//! ```

use std::fmt::Write;

use arboleda::{IndexKind, Level, Options, Resolution};
use rayon::prelude::*;

use super::weights::Weights;
use crate::TimedIndex;
use crate::benchmark::harness::measurement::{
    Measured, Measurement, affordable, build, clock, count,
};
use crate::benchmark::harness::plan::{Case, Effort, Share, pairs};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::workload::Workload;
use crate::scene::Model;

/// Lists settings that give an index other shares of nodes and tests.
fn cases(kind: IndexKind) -> Vec<Case> {
    let usual = Case::usual(kind);
    let mut cases = vec![usual.clone()];
    for density in [0.5, 2.0] {
        let resolution = Resolution::CellsPerTriangle(density);
        cases.push(Case { options: Options { resolution, ..usual.options }, ..usual.clone() });
    }
    cases.push(Case {
        options: Options { leaf_capacity: 32, level: Level::AtMost(8), ..usual.options },
        ..usual
    });
    cases
}

/// Photons to a setting, and how often they are replayed; drawn with the seed that [`run`] is given.
const EFFORT: Effort =
    Effort { photons: 2_000, repetitions: 7, seconds: 0.01, share: Share::Own, seed: 0 };

/// Numbers of triangles of the first model that are also measured alone: on the others, the time of the linear scan
/// says nothing about what a ray takes before the first test.
const FEW: [usize; 3] = [1, 12, 100];

fn first_triangles(model: &Model, count: usize) -> Model {
    let mut few = model.clone();
    few.name = format!("{count} of {}", model.name);
    few.triangles.to_mut().truncate(count);
    few.reflectance.to_mut().truncate(count);
    few.objects.to_mut().truncate(count);
    few
}

/// Counts the steps of `progress`.
pub fn steps(models: &[Model]) -> u64 {
    ((models.len() + FEW.len()) * IndexKind::ALL.len()) as u64
}

/// Measures every index on the models in several settings, and fits the weights.
///
/// # Errors
/// If two indices do not agree, or a model has no light.
pub fn run(
    models: &[Model],
    seed: u64,
    progress: Tick<'_>,
) -> anyhow::Result<Vec<(IndexKind, Weights)>> {
    let effort = Effort { seed, ..EFFORT };
    let mut rows = vec![Vec::new(); IndexKind::ALL.len()];
    let models = models.iter().cloned().chain(
        models.first().into_iter().flat_map(|first| FEW.map(|count| first_triangles(first, count))),
    );
    for model in models {
        let workload = Workload::of_photons(&model, effort.photons, seed)?;
        for (&kind, rows) in IndexKind::ALL.iter().zip(&mut rows) {
            rows.extend(measure(&model, kind, &workload, &effort)?);
            progress();
        }
    }
    let of = |kind| IndexKind::ALL.iter().zip(&rows).filter(move |(other, _)| **other == kind);
    let fits = IndexKind::ALL.iter().map(|&kind| {
        let pair = pairs().find(|&(simple, clustered)| kind == simple || kind == clustered);
        let (simple, clustered) = pair.unwrap_or((kind, kind));
        let other = if kind == simple { clustered } else { simple };
        let own = of(kind).flat_map(|(_, rows)| rows);
        let others = of(other).filter(|_| other != kind).flat_map(|(_, rows)| rows);
        (kind, Weights::fit(own.chain(others)))
    });
    Ok(fits.collect())
}

/// Measures an index in its settings; those that build the same bytes once.
fn measure(
    model: &Model,
    kind: IndexKind,
    workload: &Workload,
    effort: &Effort,
) -> anyhow::Result<Vec<Measurement>> {
    let built = cases(kind)
        .into_par_iter()
        .map(|case| Ok((build(model, &case, workload.sample())?, case)))
        .collect::<anyhow::Result<Vec<(TimedIndex, Case)>>>()?;
    let mut digests = Vec::new();
    let mut all: Vec<Measured> = Vec::new();
    for (index, case) in built {
        let digest = blake3::hash(index.as_bytes());
        if digests.contains(&digest) {
            continue;
        }
        digests.push(digest);
        let photons = affordable(&index.index(), workload, effort)?;
        all.push(count(model, &case, index, workload, photons)?);
    }
    clock(&mut all.iter_mut().collect::<Vec<_>>(), workload, effort.repetitions, &|| {});
    Ok(all.into_iter().map(|one| one.figures).collect())
}

/// Writes the fits as the constants of the core's indices, `WEIGHTS` of `Described`: one line for each family.
pub fn lines(fits: &[(IndexKind, Weights)]) -> String {
    let mut text = String::new();
    for (kind, weights) in fits.iter().filter(|(kind, _)| !kind.is_clustered()) {
        let Weights { ray, node, test, error } = weights;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<14} const WEIGHTS: Weights = Weights {{ ray: {ray:.1}, node: {node:.1}, \
             test: {test:.1} }}; // +-{:.0}%",
            kind.family(),
            error * 100.0
        );
    }
    text
}
