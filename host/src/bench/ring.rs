//! Timing in turn: a slow moment of the machine hits all contenders, not one. What counts is the
//! thread's processor time, so that other programs take less part in it.

use std::hint::black_box;

use arboleda::Hit;
use cpu_time::ThreadTime;

use super::workload::Workload;
use crate::bench::spread::Spread;
use crate::contenders::contender::Contender;

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
) -> Vec<[Option<Spread>; 3]> {
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
    speeds.into_iter().map(|modes| modes.map(|speeds| spread(&speeds))).collect()
}

/// How often everything is built at least and at most, the first time included.
const BUILDS: [usize; 2] = [3, 30];
/// More often than at least as long as its builds together take less: short ones are the most disturbed.
const SECONDS: f64 = 0.5;
/// From so many triangles on builds are long, and the first touch of memory a small share: one is enough.
const LARGE: usize = 500_000;

/// What was built once, and how to build it again.
pub struct Build<'a> {
    /// The shortest so far.
    pub seconds: f64,
    /// How long it takes this time; forever if it fails.
    pub again: Box<dyn Fn() -> f64 + 'a>,
}

/// Builds everything several times in turns. The shortest time counts: whatever disturbs a build makes it longer.
pub fn time_builds(builds: &mut [&mut Build<'_>], triangle_count: usize) {
    let [least, most] = if triangle_count < LARGE { BUILDS } else { [1; 2] };
    let mut totals: Vec<f64> = builds.iter().map(|build| build.seconds).collect();
    for round in 1..most {
        for (build, total) in builds.iter_mut().zip(&mut totals) {
            if round < least || *total < SECONDS {
                let seconds = (build.again)();
                build.seconds = build.seconds.min(seconds);
                *total += seconds;
            }
        }
    }
}

/// Of million rays a second over the rounds; `None` for a mode that a contender does not have.
fn spread(speeds: &[f64]) -> Option<Spread> {
    (!speeds.is_empty()).then(|| Spread::of(speeds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_between() {
        assert_eq!(spread(&[]), None);
        let odd = spread(&[3.0, 1.0, 2.0]);
        assert_eq!(odd, Some(Spread { median: 2.0, min: 1.0, max: 3.0 }));
        assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]).map(|speed| speed.median), Some(2.5));
    }
}
