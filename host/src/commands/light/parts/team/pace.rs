//! Pace of a job: how many photons a process shoots at once, and when a round ends.
//!
//! Ranges become shorter towards the end of a job, so that all processes end at about the same time, and towards the end
//! of a round. They are long otherwise, because each range of DETP indexes its discs anew. Where they end with a pass,
//! they get shorter by that, not longer, so that a round does not last twice its time.
//!
//! # Source
//! C. Polychronopoulos, D. Kuck, *Guided Self-Scheduling*, IEEE Transactions on Computers 1987, for shares of what is
//! left.

use std::ops::Range;
use std::time::{Duration, Instant};

use crate::photon::CHUNK;

/// Photons of a process's first range, before its speed is known.
const FIRST: u64 = 1 << 16;
/// Most times that a range is longer than the one before.
const GROWTH: u64 = 8;
/// Longest time of a range in seconds, where no round ends.
const LONGEST: f64 = 60.0;

/// Pace of a job.
#[derive(Debug)]
pub struct Pace {
    /// Time of a round.
    every: Option<Duration>,
    begun: Instant,
    processes: Vec<Process>,
}

/// Speed of a process.
#[derive(Clone, Copy, Debug)]
struct Process {
    photons: u64,
    begun: Instant,
    /// Photons in a second, in the last range.
    speed: Option<f64>,
}

impl Pace {
    /// The pace of rounds of a duration; without one, there is one round.
    pub fn new(every: Option<Duration>) -> Self {
        Self { every, begun: Instant::now(), processes: Vec::new() }
    }

    /// Makes room for several processes.
    #[cfg(feature = "mpi")]
    pub fn of(&mut self, processes: usize) {
        let process = Process { photons: 0, begun: self.begun, speed: None };
        self.processes.resize(processes, process);
    }

    /// Begins a round.
    pub fn begin(&mut self) {
        self.begun = Instant::now();
    }

    /// Tells whether the round has lasted its time.
    #[cfg(feature = "mpi")]
    pub fn is_over(&self) -> bool {
        self.every.is_some_and(|every| self.begun.elapsed() >= every)
    }

    /// Chooses the next photons for a process out of those that are left. `per_pass` is the number of a pass.
    pub fn next(&mut self, process: usize, left: &Range<u64>, per_pass: u64) -> Range<u64> {
        let now = Instant::now();
        while self.processes.len() <= process {
            self.processes.push(Process { photons: 0, begun: now, speed: None });
        }
        let alone = self.processes.len() == 1;
        let length = match (self.every, alone) {
            (None, true) => left.end - left.start,
            _ => self.length(process, left.end - left.start),
        };
        let Process { photons, begun, .. } = &mut self.processes[process];
        // Whole passes are not joined over processes, and whole chunks are hashed at once.
        let end = left.start.saturating_add(length);
        let per_pass = per_pass.max(1);
        let end = match self.every {
            Some(_) if length >= per_pass => Some(end - end % per_pass),
            None if length >= per_pass / 2 => end.checked_next_multiple_of(per_pass),
            _ => end.checked_next_multiple_of(CHUNK),
        };
        let end = end.filter(|&end| end > left.start);
        let range = left.start..end.unwrap_or(left.end).min(left.end);
        (*photons, *begun) = (range.end - range.start, now);
        range
    }

    fn length(&self, process: usize, left: u64) -> u64 {
        let Process { photons, speed, .. } = self.processes[process];
        let count = self.processes.len() as u64;
        let fair = if count == 1 { left } else { left / (2 * count) };
        let seconds = match self.every {
            None => LONGEST,
            Some(every) if count == 1 => every.as_secs_f64(),
            Some(every) => {
                let rest = every.saturating_sub(self.begun.elapsed()).as_secs_f64();
                let every = every.as_secs_f64();
                (0.5 * rest).clamp(every / 64.0, every / 8.0)
            }
        };
        let known = speed.map_or(FIRST, |speed| (speed * seconds) as u64);
        let most = if speed.is_some() { photons.saturating_mul(GROWTH) } else { FIRST };
        fair.min(known).min(most).max(CHUNK)
    }

    /// Notes that a process has shot its photons.
    pub fn done(&mut self, process: usize) {
        if let Some(Process { photons, begun, speed }) = self.processes.get_mut(process) {
            let seconds = begun.elapsed().as_secs_f64().max(1e-6);
            *speed = Some(*photons as f64 / seconds);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands out all photons, and lists the ends of the ranges.
    fn ends(mut pace: Pace, photons: u64, per_pass: u64, processes: usize) -> Vec<u64> {
        let (mut ends, mut position) = (Vec::new(), 0);
        while position < photons {
            let process = ends.len() % processes;
            let range = pace.next(process, &(position..photons), per_pass);
            assert_eq!(range.start, position);
            assert!(range.end > position && range.end <= photons);
            pace.done(process);
            position = range.end;
            ends.push(position);
        }
        ends
    }

    #[test]
    fn all_photons_are_handed_out_in_order() {
        assert_eq!(ends(Pace::new(None), 5_000_000, 5_000_000, 1), [5_000_000], "at once");
        for every in [None, Some(Duration::from_secs(1)), Some(Duration::ZERO)] {
            for (photons, per_pass) in [(1, 1), (1_000_001, 1_000_001), (3_000_000, 1_000)] {
                for processes in [2, 7] {
                    let ends = ends(Pace::new(every), photons, per_pass, processes);
                    let whole =
                        |end: &u64| end.is_multiple_of(CHUNK) || end.is_multiple_of(per_pass);
                    assert!(ends.iter().all(whole), "{ends:?}");
                }
            }
        }
        // A pass that would take longer than a round is cut.
        for (per_pass, end) in [(1_500, 1_024), (1_000, 1_000), (300, 900)] {
            let mut pace = Pace::new(Some(Duration::from_secs(1)));
            pace.processes.push(Process {
                photons: 1_000_000,
                begun: Instant::now(),
                speed: Some(1_000.0),
            });
            assert_eq!(pace.next(0, &(0..9_000_000), per_pass), 0..end, "{per_pass}");
        }
        // Within a time for a part, a range is not longer than it may be at once.
        let first = Pace::new(Some(Duration::from_secs(9))).next(0, &(0..u64::MAX / 2), u64::MAX);
        assert_eq!(first, 0..FIRST);
    }
}
