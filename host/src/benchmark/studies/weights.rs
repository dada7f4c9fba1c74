//! Time of a ray, a node and a test, fitted to measurements.
//!
//! ```text
//! seconds = rays * ray + nodes visited * node + triangle tests * test      one row for each measurement
//! ```

use crate::benchmark::harness::measurement::Measurement;

/// Weights of the parts of a query, in nanoseconds, none below 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// A ray, before its first node.
    pub ray: f64,
    /// A node, or a cell of a grid.
    pub node: f64,
    /// A triangle test.
    pub test: f64,
    /// The root of the mean square of the relative errors.
    pub error: f64,
}

impl Weights {
    /// Fits the weights by least squares of the relative errors.
    pub fn fit<'m>(measured: impl IntoIterator<Item = &'m Measurement>) -> Self {
        let rows = measured.into_iter().map(|one| {
            let share = 1e-9 / one.seconds.min;
            let counters = one.counters;
            [one.ray_count as u64, counters.nodes_visited, counters.triangle_tests]
                .map(|count| count as f64 * share)
        });
        let ([ray, node, test], error) = least_squares(&rows.collect::<Vec<_>>());
        Self { ray, node, test, error }
    }

    /// Returns the nanoseconds of a ray with these nodes and tests.
    pub fn nanoseconds(&self, nodes: f64, tests: f64) -> f64 {
        self.ray + nodes * self.node + tests * self.test
    }
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
