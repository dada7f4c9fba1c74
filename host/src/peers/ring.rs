//! Timing in turn: a slow moment of the machine hits all contenders, not one. What counts is the
//! thread's processor time, so that other programs take less part in it.

use std::hint::black_box;

use arboleda::Hit;
use cpu_time::ThreadTime;

use super::contender::Contender;
use super::workload::Workload;

/// What is asked, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Closest hits, one ray at a time.
    Single,
    /// Closest hits, several rays together.
    Batch,
    /// Whether anything is hit, by the fastest way.
    Occluded,
}

impl Mode {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Single, Self::Batch, Self::Occluded];

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Batch => "batch",
            Self::Occluded => "occluded",
        }
    }
}

/// Million rays a second over the rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    /// Half of the rounds were slower.
    pub median: f64,
    /// The slowest round.
    pub min: f64,
    /// The fastest round.
    pub max: f64,
}

impl Speed {
    fn of(mut rounds: Vec<f64>) -> Option<Self> {
        rounds.sort_by(f64::total_cmp);
        let (min, max) = (*rounds.first()?, *rounds.last()?);
        let middle = rounds.len() / 2;
        let median = if rounds.len().is_multiple_of(2) {
            f64::midpoint(rounds[middle - 1], rounds[middle])
        } else {
            rounds[middle]
        };
        Some(Self { median, min, max })
    }
}

/// Room for answers.
pub struct Answers {
    /// Of closest-hit rays.
    pub hits: Vec<Hit>,
    /// Of occlusion rays.
    pub occluded: Vec<bool>,
}

impl Answers {
    /// For so many rays.
    pub fn room(count: usize) -> Self {
        Self { hits: vec![Hit::NONE; count], occluded: vec![false; count] }
    }
}

/// Lets a contender answer everything in one mode; `false` if it has no such mode.
pub fn answer(
    contender: &dyn Contender,
    mode: Mode,
    workload: &Workload,
    answers: &mut Answers,
) -> bool {
    match mode {
        Mode::Single => contender.closest_hits(&workload.rays, &mut answers.hits),
        Mode::Batch => match contender.batch() {
            Some(batch) => batch.closest_hits_together(&workload.rays, &mut answers.hits),
            None => return false,
        },
        Mode::Occluded => contender.occluded(&workload.shadow_rays, &mut answers.occluded),
    }
    true
}

/// Times every contender in every mode that it has, `rounds` times around.
///
/// The result has one row for each contender, in the order of [`Mode::ALL`].
pub fn time(
    contenders: &[&dyn Contender],
    workload: &Workload,
    rounds: usize,
    progress: &mut dyn FnMut(),
) -> Vec<[Option<Speed>; 3]> {
    let mut answers = Answers::room(workload.rays.len());
    let million_rays = workload.rays.len() as f64 / 1e6;
    let mut speeds = vec![[const { Vec::new() }; 3]; contenders.len()];
    for _ in 0..rounds {
        for (contender, speeds) in contenders.iter().zip(&mut speeds) {
            for (mode, speeds) in Mode::ALL.into_iter().zip(speeds) {
                let start = ThreadTime::now();
                let answered = answer(*contender, mode, workload, black_box(&mut answers));
                let seconds = start.elapsed().as_secs_f64();
                if answered {
                    speeds.push(million_rays / seconds);
                }
            }
        }
        progress();
    }
    speeds.into_iter().map(|modes| modes.map(Speed::of)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_between() {
        assert_eq!(Speed::of(Vec::new()), None);
        let odd = Speed::of(vec![3.0, 1.0, 2.0]);
        assert_eq!(odd, Some(Speed { median: 2.0, min: 1.0, max: 3.0 }));
        assert_eq!(Speed::of(vec![4.0, 1.0, 2.0, 3.0]).map(|speed| speed.median), Some(2.5));
    }
}
