//! The clock. Everything takes turns: a slow moment of the machine hits all contenders, not one.
//!
//! Rays are timed in processor time of the thread, so that other programs' share of the processor is not counted; they
//! still take some of its caches.

use std::hint::black_box;

use arboleda::Ray;
use cpu_time::ThreadTime;

use super::progress::Tick;
use crate::benchmark::contenders::contender::{Answers, Contender, Mode};

/// Contender, and the rays that it is asked about in one mode.
#[derive(Clone, Copy)]
pub struct Turn<'t> {
    /// Gives the answers.
    pub contender: &'t dyn Contender,
    /// The way in which it is asked.
    pub mode: Mode,
    /// Rays of a round.
    pub rays: &'t [Ray],
}

/// Times every turn once a round, for at least one round; calls `progress` after each.
///
/// Returns the seconds of each turn, round by round; none for a mode that the contender does not have.
pub fn time(turns: &[Turn<'_>], rounds: usize, progress: Tick<'_>) -> Vec<Vec<f64>> {
    let longest = turns.iter().map(|turn| turn.rays.len()).max();
    let mut answers = Answers::room(longest.unwrap_or(0));
    let mut seconds = vec![Vec::new(); turns.len()];
    for _ in 0..rounds.max(1) {
        for (turn, seconds) in turns.iter().zip(&mut seconds) {
            let start = ThreadTime::now();
            let answers = black_box(&mut answers);
            let answered = turn.contender.answer(turn.mode, black_box(turn.rays), answers);
            let elapsed = start.elapsed().as_secs_f64();
            if answered {
                seconds.push(elapsed);
            }
        }
        progress();
    }
    seconds
}

/// Fewest and most builds of everything, the first time included.
const BUILDS: [usize; 2] = [3, 30];
/// Seconds of all builds of one index together, from which on only the fewest builds are made. Short builds are made
/// more often, because they are disturbed the most.
const SECONDS: f64 = 0.5;
/// Triangles from which on one build is enough: it is long, and the first touch of memory a small share of it.
const LARGE: usize = 500_000;

/// Time of a build that was made once, and the way to make it again.
pub struct Build<'a> {
    /// Seconds of the shortest build so far.
    pub seconds: f64,
    /// Builds once more and returns the seconds; infinitely many if that fails.
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
