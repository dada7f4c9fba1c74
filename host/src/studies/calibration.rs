//! Time of a ray, a node and a test in each index: the weights behind the automatic selection.
//!
//! ```text
//! seconds = rays * ray + nodes visited * node + triangle tests * test      one row for each scene and setting
//! ```
//! The weights are solved by least squares of the relative errors, none below 0, for a simple index and its hierarchy
//! together. The two share the local index; where they are close, their counters tell them apart, and not the errors of
//! two fits. Each index of the core states its weights in `Described`; this prints those lines anew:
//!
//! ```text
//! cargo run --release -p arboleda-host -- compare calibrate
//! ```

use std::fmt::Write;

use arboleda::{IndexKind, Level, Options, Resolution};
use rayon::prelude::*;

use crate::TimedIndex;
use crate::bench::measurement::{Measured, Measurement, affordable, build, clock, count};
use crate::bench::plan::{Case, Effort, Share, pairs};
use crate::bench::progress::Tick;
use crate::bench::workload::Workload;
use crate::scene::Model;

/// Weights of the parts of a query, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The index.
    pub kind: IndexKind,
    /// A ray, a node, a test.
    pub nanoseconds: [f64; 3],
    /// The root of the mean square of the relative errors.
    pub error: f64,
}

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
    few.triangles.truncate(count);
    few.reflectance.truncate(count);
    few.objects.truncate(count);
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
pub fn run(models: &[Model], seed: u64, progress: Tick<'_>) -> anyhow::Result<Vec<Fit>> {
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
        fit(kind, own.chain(others))
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
    clock(&mut all.iter_mut().collect::<Vec<_>>(), workload, effort.repetitions);
    Ok(all.into_iter().map(|one| one.figures).collect())
}

/// Fits the weights of one kind.
fn fit<'m>(kind: IndexKind, measured: impl Iterator<Item = &'m Measurement>) -> Fit {
    let rows: Vec<[f64; 3]> = measured
        .map(|one| {
            let share = 1e-9 / one.seconds.min;
            let counters = one.counters;
            [
                one.ray_count as f64 * share,
                counters.nodes_visited as f64 * share,
                counters.triangle_tests as f64 * share,
            ]
        })
        .collect();
    let (nanoseconds, error) = least_squares(&rows);
    Fit { kind, nanoseconds, error }
}

/// Returns the weights, none below 0, whose sums over the rows come closest to 1, and by how much they miss it.
///
/// With three unknowns, each set of those that are not 0 is tried.
fn least_squares(rows: &[[f64; 3]]) -> ([f64; 3], f64) {
    let error_of = |weights: &[f64; 3]| {
        let square = |row: &[f64; 3]| {
            (row.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>() - 1.0).powi(2)
        };
        (rows.iter().map(square).sum::<f64>() / rows.len().max(1) as f64).sqrt()
    };
    let mut best = ([0.0; 3], 1.0);
    for used in 1..8_u32 {
        let on = |column: usize| used >> column & 1 == 1;
        // The normal equations; an unknown that is not used stands alone in its row.
        let mut matrix = [[0.0; 4]; 3];
        for (i, line) in matrix.iter_mut().enumerate() {
            for j in 0..3 {
                line[j] = match (on(i) && on(j), i == j) {
                    (true, _) => rows.iter().map(|row| row[i] * row[j]).sum(),
                    (false, true) => 1.0,
                    (false, false) => 0.0,
                };
            }
            line[3] = if on(i) { rows.iter().map(|row| row[i]).sum() } else { 0.0 };
        }
        let Some(weights) = solve(matrix) else { continue };
        let error = error_of(&weights);
        if weights.iter().all(|weight| *weight >= 0.0) && error < best.1 {
            best = (weights, error);
        }
    }
    best
}

/// Solves three linear equations, if they have one solution.
fn solve(mut matrix: [[f64; 4]; 3]) -> Option<[f64; 3]> {
    for step in 0..3 {
        let pivot =
            (step..3).max_by(|&a, &b| matrix[a][step].abs().total_cmp(&matrix[b][step].abs()))?;
        matrix.swap(step, pivot);
        let line = matrix[step];
        if line[step].abs() < 1e-12 {
            return None;
        }
        for (at, other) in matrix.iter_mut().enumerate() {
            if at != step {
                let factor = other[step] / line[step];
                for (x, y) in other.iter_mut().zip(line) {
                    *x -= factor * y;
                }
            }
        }
    }
    Some([0, 1, 2].map(|at| matrix[at][3] / matrix[at][at]))
}

/// Writes the fits as the constants of the core's indices, `WEIGHTS` of `Described`: one line for each family.
pub fn lines(fits: &[Fit]) -> String {
    let mut text = String::new();
    for fit in fits.iter().filter(|fit| !fit.kind.is_clustered()) {
        let [ray, node, test] = fit.nanoseconds;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<14} const WEIGHTS: Weights = Weights {{ ray: {ray:.1}, node: {node:.1}, test: {test:.1} }}; // +-{:.0}%",
            fit.kind.family(),
            fit.error * 100.0
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_found_again() {
        let truth = [150.0, 20.0, 9.0];
        let counts = [[1.0, 5.0, 10.0], [1.0, 20.0, 3.0], [1.0, 8.0, 40.0], [1.0, 2.0, 2.0]];
        let rows = counts.map(|row: [f64; 3]| {
            let time: f64 = row.iter().zip(truth).map(|(n, w)| n * w).sum();
            row.map(|n| n / time)
        });
        let (weights, error) = least_squares(&rows);
        assert!(error < 1e-9);
        assert!(weights.iter().zip(truth).all(|(found, known)| (found - known).abs() < 1e-6));
    }

    #[test]
    fn no_weight_is_below_zero() {
        // The more nodes, the less time: nodes get no weight.
        let (weights, _) = least_squares(&[[1.0, 1.0, 0.1], [1.2, 0.5, 0.1], [0.8, 2.0, 0.1]]);
        assert!(weights.iter().all(|weight| *weight >= 0.0));
    }
}
