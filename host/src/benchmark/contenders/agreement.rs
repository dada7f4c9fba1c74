//! Agreement of a contender's answers with the exact ones.
//!
//! The others round, so their `t` may differ a little. A ray through an edge hits two triangles at the
//! same `t`: `arboleda` names the lower, others any of them. That counts as a disagreement too, and apart.

use arboleda::Hit;

use super::contender::{Answers, Mode};
use crate::benchmark::harness::workload::Workload;

/// The relative difference of `t` from which on it counts.
const TOLERANCE: f32 = 1e-4;

/// Numbers of answers that differ, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Disagreements {
    /// There is a hit and none was found.
    pub missed: usize,
    /// There is no hit and one was found.
    pub phantom: usize,
    /// A hit at another `t`; on the same triangle or not.
    pub elsewhere: usize,
    /// Another triangle at the same `t`: a tie broken otherwise.
    pub tied: usize,
}

impl Disagreements {
    /// Compares the answers to a workload in one mode.
    pub fn of(workload: &Workload, mode: Mode, answers: &Answers) -> Self {
        match mode {
            Mode::Occluded => Self::of_occlusion(&workload.occluded, &answers.occluded),
            Mode::Single | Mode::Batch => Self::of_hits(&workload.hits, &answers.hits),
        }
    }

    fn of_hits(exact: &[Hit], answers: &[Hit]) -> Self {
        let mut count = Self::default();
        for (exact, answer) in exact.iter().zip(answers) {
            match (exact.is_none(), answer.is_none()) {
                (true, true) => {}
                (false, true) => count.missed += 1,
                (true, false) => count.phantom += 1,
                (false, false) => {
                    // Written so that NaN is a difference.
                    let near = (answer.t - exact.t).abs() <= TOLERANCE * exact.t.abs();
                    if !near {
                        count.elsewhere += 1;
                    } else if answer.triangle != exact.triangle {
                        count.tied += 1;
                    }
                }
            }
        }
        count
    }

    fn of_occlusion(exact: &[bool], answers: &[bool]) -> Self {
        let mut count = Self::default();
        for pair in exact.iter().zip(answers) {
            match pair {
                (true, false) => count.missed += 1,
                (false, true) => count.phantom += 1,
                _ => {}
            }
        }
        count
    }

    /// Counts those that are not ties.
    pub fn wrong(&self) -> usize {
        self.missed + self.phantom + self.elsewhere
    }

    /// Counts all.
    pub fn total(&self) -> usize {
        self.wrong() + self.tied
    }
}

#[cfg(test)]
mod tests {
    use super::super::peer::found as hit;
    use super::*;

    #[test]
    fn each_kind_is_counted_once() {
        let exact = [Hit::NONE, hit(1, 1.0), Hit::NONE, hit(2, 1.0), hit(3, 1.0), hit(4, 0.0)];
        let answers =
            [Hit::NONE, Hit::NONE, hit(0, 1.0), hit(2, 1.1), hit(4, 1.000_01), hit(4, 0.0)];
        let count = Disagreements::of_hits(&exact, &answers);
        assert_eq!(count, Disagreements { missed: 1, phantom: 1, elsewhere: 1, tied: 1 });
        assert_eq!(count.total(), 4);
        let not_a_number = Disagreements::of_hits(&[hit(0, 1.0)], &[hit(0, f32::NAN)]);
        assert_eq!(not_a_number.elsewhere, 1);
        let occlusion = Disagreements::of_occlusion(&[true, true, false], &[true, false, true]);
        assert_eq!((occlusion.missed, occlusion.phantom, occlusion.total()), (1, 1, 2));
    }
}
