//! Options of jobs in parts: a range of the photons, and a checkpoint from which a killed job goes on.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::ensure;
use clap::Args;

use super::values::{number, range};
use crate::commands::light::parts::Team;

/// Part of a job, its photons, and its checkpoint.
#[derive(Args, Clone, Debug)]
pub struct PartArguments {
    /// Write a part, which `arboleda merge` puts together with others to the result of one run
    #[arg(long, value_name = "FILE")]
    pub part: Option<PathBuf>,
    /// Shoot only photons A to B - 1. They are numbered from 0, those of all passes in a row: of a picture there are
    /// --photons times --passes [default: all]
    #[arg(long, value_name = "A..B", requires = "part", value_parser = range)]
    pub photon_range: Option<Range<u64>>,
    /// Keep what was shot so far in FILE, as a part. If FILE is there, go on from it: a job that was killed loses only
    /// what it shot since. FILE stays when the job is done
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between two writes of the checkpoint, about: a range that was begun is shot to its end
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = number(0.1..=1e6),
        requires = "checkpoint")]
    checkpoint_every: f32,
}

impl PartArguments {
    /// No part and no checkpoint: the result itself.
    pub const NONE: Self =
        Self { part: None, photon_range: None, checkpoint: None, checkpoint_every: 300.0 };

    /// Refuses a range without a part. `requires` of clap does not, if an option is given that excludes --part.
    ///
    /// # Errors
    /// If the result itself is wanted, but not of all photons.
    pub fn check(&self) -> anyhow::Result<()> {
        ensure!(
            self.photon_range.is_none() || self.part.is_some(),
            "--photon-range is for --part: a result is of all photons"
        );
        Ok(())
    }

    /// Tells whether the photons are to be shot for a part, a checkpoint, or by several processes.
    pub fn in_parts(&self, team: Team) -> bool {
        self.part.is_some() || self.checkpoint.is_some() || team != Team::Alone
    }

    /// Returns the time between two writes of the checkpoint, if there is one.
    pub fn checkpoint_every(&self) -> Option<Duration> {
        self.checkpoint.as_ref().map(|_| Duration::from_secs_f32(self.checkpoint_every))
    }

    /// Returns the photons of the part, of a job of `all` photons.
    ///
    /// # Errors
    /// If the job has no photons, or not those of the range.
    pub fn photons(&self, all: u64) -> anyhow::Result<Range<u64>> {
        ensure!(all > 0, "--photons 0 has no photons to be shot in parts");
        let photons = self.photon_range.clone().unwrap_or(0..all);
        ensure!(
            photons.end <= all,
            "--photon-range ends at photon {}, but there are {all} photons in all: --photons is their number in all \
             parts",
            photons.end,
        );
        Ok(photons)
    }
}
