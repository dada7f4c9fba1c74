//! Team: the processes that shoot the photons of a job.
//!
//! ```text
//! round | range, range, range, ... to whoever is free |     counts are added over the team
//!       \---- what is left, in the order of photons --/  -> the job so far -> checkpoint
//! ```
//! A job is shot in rounds. After each round one process has all that was shot so far, and may write it as a part. Sums
//! are of whole numbers, so it does not matter who shoots which range.

mod pace;
#[cfg(feature = "mpi")]
mod processors;
#[cfg(feature = "mpi")]
mod ranks;

use std::ops::Range;

use anyhow::{Context, ensure};

use self::pace::Pace;
use super::work::PartWork;
use crate::benchmark::harness::progress::photon_bar;
use crate::commands::arguments::part::PartArguments;
#[cfg(feature = "mpi")]
use crate::parts::PartSums;
use crate::parts::{JobPart, PartFile};

#[cfg(feature = "mpi")]
pub use ranks::{abort, join_ranks};

/// Processes that shoot together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Team {
    /// This process.
    Alone,
    /// The processes that `mpirun` started; this is the first, which has the results.
    #[cfg(feature = "mpi")]
    First,
    /// One of the others.
    #[cfg(feature = "mpi")]
    Other,
}

impl PartWork<'_> {
    /// Shoots the photons of a part with a team, from where the checkpoint ended. Returns the part; `None` if another
    /// process has it.
    ///
    /// # Errors
    /// If the job does not have these photons, the checkpoint is of another job, photons cannot be shot, or the
    /// checkpoint cannot be written.
    pub fn gather(&self, arguments: &PartArguments, team: Team) -> anyhow::Result<Option<JobPart>> {
        let photons = arguments.photons(self.job.photons)?;
        ensure!(
            self.job.is_countable(),
            "the paths of {} photons with up to {} bounces may have more than 2^64 segments, which 64 bits cannot count",
            self.job.photons,
            self.job.max_bounces
        );
        #[cfg(feature = "mpi")]
        if team != Team::Alone {
            ranks::agree(self)?;
        }
        #[cfg(feature = "mpi")]
        if team == Team::Other {
            ranks::serve(self)?;
            return Ok(None);
        }
        let mut so_far = self.resumed(arguments, &photons)?;
        let bar = photon_bar(photons.end - photons.start, self.index);
        let progress = |photons| bar.inc(photons);
        let mut position = so_far.as_ref().map_or(photons.start, |part| part.photons.end);
        bar.set_position(position - photons.start);
        bar.reset_eta();
        let mut pace = Pace::new(arguments.checkpoint_every());
        #[cfg(feature = "mpi")]
        let mut exchange = ranks::Exchange::default();
        while position < photons.end {
            // 1. A round, which ends where the next part is due.
            pace.begin();
            let left = position..photons.end;
            let (end, sums) = match team {
                Team::Alone => {
                    let end = pace.next(0, &left, self.per_pass()).end;
                    let sums = (self.shoot)(position..end, &progress)?;
                    pace.done(0);
                    (end, sums)
                }
                #[cfg(feature = "mpi")]
                _ => ranks::round(self, &left, &mut pace, &mut exchange, &progress)?,
            };

            // 2. All that was shot so far.
            let round = JobPart { photons: position..end, sums };
            position = end;
            match &mut so_far {
                None => so_far = Some(round),
                Some(all) => ensure!(all.join(round), "a round has sums of something else"),
            }
            if let (Some(path), Some(JobPart { photons, sums })) = (&arguments.checkpoint, &so_far)
            {
                self.file(photons.clone()).write(path, sums)?;
            }
        }
        bar.finish_and_clear();
        #[cfg(feature = "mpi")]
        if team == Team::First {
            ranks::dismiss();
            exchange.log();
        }
        so_far.context("a part without photons").map(Some)
    }

    /// Reads the photons that the checkpoint has, if it is there.
    fn resumed(
        &self,
        arguments: &PartArguments,
        photons: &Range<u64>,
    ) -> anyhow::Result<Option<JobPart>> {
        // A device has no end.
        let Some(path) = arguments.checkpoint.as_ref().filter(|path| path.is_file()) else {
            return Ok(None);
        };
        let file = PartFile::read(path)?;
        let name = path.display();
        if let Some(difference) = self.job.difference(&file.job) {
            anyhow::bail!(
                "{name} is the checkpoint of another job: it has {difference}; name another file, or delete it"
            );
        }
        let Range { start, end } = file.photons;
        ensure!(
            start == photons.start && end <= photons.end,
            "{name} has the photons {start}..{end}, which are not the first of {}..{}",
            photons.start,
            photons.end
        );
        log::info!("goes on from {name}, which has the photons {start}..{end}");
        Ok(Some(file.read_part(path)?))
    }

    /// Number of photons of a pass.
    fn per_pass(&self) -> u64 {
        self.job.photons / u64::from(self.job.passes.max(1))
    }
}

/// Adds numbers to others; an empty list is one of zeros.
#[cfg(feature = "mpi")]
fn add_counts(sums: &mut Vec<u64>, other: Vec<u64>) {
    if sums.is_empty() {
        *sums = other;
        return;
    }
    for (sum, other) in sums.iter_mut().zip(other) {
        *sum = sum.saturating_add(other);
    }
}

/// Takes the numbers out that are only added, and adds them to those of a round.
#[cfg(feature = "mpi")]
fn keep_counts(
    counts: &mut std::collections::BTreeMap<crate::density::CountsOf, Vec<u64>>,
    mut sums: PartSums,
) -> PartSums {
    for (of, more) in sums.take_counts() {
        add_counts(counts.entry(of).or_default(), more);
    }
    sums
}
