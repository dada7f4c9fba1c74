//! Work that can be done in parts: a job, and the shooting of any range of its photons.

use std::ffi::OsString;
use std::ops::Range;
use std::sync::LazyLock;

use anyhow::{Context, bail};

use super::team::Team;
use crate::benchmark::harness::provenance::Provenance;
use crate::commands::arguments::part::PartArguments;
use crate::commands::output::{count, say};
use crate::density::LightSums;
use crate::parts::{Job, JobPart, PartFile, PartSums};

/// Shoots a range of photons, and calls the function with numbers of photons from any thread.
pub type ShootRange<'w> =
    dyn Fn(Range<u64>, &(dyn Fn(u64) + Sync)) -> anyhow::Result<PartSums> + Sync + 'w;

/// A job, and how its photons are shot.
pub struct PartWork<'w> {
    /// The job.
    pub job: Job,
    /// Arguments of the program, from which `merge` knows how to estimate; empty for a shot.
    pub arguments: Vec<String>,
    /// Name of the index, for people.
    pub index: &'static str,
    /// Shoots a range of its photons.
    pub shoot: &'w ShootRange<'w>,
}

impl PartWork<'_> {
    /// Shoots the photons with a team. Writes the part, if a file is named for it; else returns what the results are
    /// made of, if this process has it.
    ///
    /// # Errors
    /// If the job does not have these photons, they cannot be shot, or a file cannot be written.
    pub fn run(&self, part: &PartArguments, team: Team) -> anyhow::Result<Option<MergedJob>> {
        let Some(all) = self.gather(part, team)? else { return Ok(None) };
        let Some(path) = &part.part else {
            return Ok(Some(MergedJob { job: self.job.clone(), all }));
        };
        let JobPart { photons, sums } = all;
        let Range { start, end } = photons;
        self.file(start..end).write(path, &sums)?;
        log::info!("part: {}", path.display());
        let balance = sums.balance();
        let (rays, hits) = (count(balance.rays), count(balance.hits));
        say!("photons {start}..{end} of {}: {rays} rays, {hits} hits", count(self.job.photons));
        Ok(None)
    }

    /// Makes the header of a file of some of the photons.
    pub fn file(&self, photons: Range<u64>) -> PartFile {
        /// Of this process.
        static PROVENANCE: LazyLock<String> = LazyLock::new(|| Provenance::gather().line());
        let provenance = format!("{}; {}", self.index, *PROVENANCE);
        let (job, arguments) = (self.job.clone(), self.arguments.clone());
        PartFile { job, photons, arguments, provenance }
    }
}

/// Records the arguments of the program.
///
/// # Errors
/// If an argument is not Unicode, so that a part could not name it.
pub fn recorded(arguments: &[OsString]) -> anyhow::Result<Vec<String>> {
    let text = |argument: &OsString| {
        argument.to_str().map(str::to_owned).with_context(|| {
            format!("the argument {} is not Unicode; a part records it", argument.display())
        })
    };
    arguments.iter().map(text).collect()
}

/// A whole job in parts that were put together.
pub struct MergedJob {
    /// The job.
    pub job: Job,
    /// The sums of all its photons.
    pub all: JobPart,
}

impl MergedJob {
    /// Returns the sums for estimates of a job, which is to be that of the parts.
    ///
    /// # Errors
    /// If the parts are of another job.
    pub fn light(self, job: &Job) -> anyhow::Result<LightSums> {
        if let Some(difference) = job.difference(&self.job) {
            bail!(
                "the files that the parts were shot for have changed, or others were named: a part has {difference}"
            );
        }
        match self.all.sums {
            PartSums::Light(sums) => Ok(sums),
            PartSums::Shot(_) => bail!("the parts are those of a shot"),
        }
    }
}
