//! Options of parts: a range of the photons, shot for `arboleda merge`.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;

use super::values::range;

/// Part of a job, and its photons.
#[derive(Args, Clone, Debug)]
pub struct PartArguments {
    /// Write a part, which `arboleda merge` puts together with others to the result of one run
    #[arg(long, value_name = "FILE")]
    pub part: Option<PathBuf>,
    /// Photons of the part, out of those of all passes: from photon A to the one before B [default: all]
    #[arg(long, value_name = "A..B", requires = "part", value_parser = range)]
    pub photon_range: Option<Range<u64>>,
}

impl PartArguments {
    /// No part: the result itself.
    pub const NONE: Self = Self { part: None, photon_range: None };

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
