//! Work that can be done in parts: a job, and the shooting of any range of its photons.

use std::ffi::OsString;
use std::ops::Range;

use anyhow::{Context, bail};

use crate::bench::progress::photon_bar;
use crate::bench::provenance::Provenance;
use crate::commands::arguments::part::PartArguments;
use crate::commands::output::{count, say};
use crate::density::LightSums;
use crate::parts::{Job, JobPart, PartFile, PartSums};

/// Shoots a range of photons, and calls the function with numbers of photons from any thread.
pub type ShootRange<'w> =
    dyn Fn(Range<u64>, &(dyn Fn(u64) + Sync)) -> anyhow::Result<PartSums> + 'w;

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
    /// Shoots the photons of a part, and writes it if a file is named.
    ///
    /// # Errors
    /// If the job does not have these photons, they cannot be shot, or the file cannot be written.
    pub fn write_part(&self, part: &PartArguments) -> anyhow::Result<()> {
        let photons = part.photons(self.job.photons)?;
        let bar = photon_bar(photons.end - photons.start, self.index);
        let sums = (self.shoot)(photons.clone(), &|photons| bar.inc(photons))?;
        bar.finish_and_clear();
        let (Range { start, end }, all) = (photons.clone(), count(self.job.photons));
        let balance = sums.balance();
        let (rays, hits) = (count(balance.rays), count(balance.hits));
        if let Some(path) = &part.part {
            self.file(photons).write(path, &sums)?;
            log::info!("part: {}", path.display());
        }
        say!("photons {start}..{end} of {all}: {rays} rays, {hits} hits");
        Ok(())
    }

    /// Makes the header of a file of some of the photons.
    pub fn file(&self, photons: Range<u64>) -> PartFile {
        let provenance = format!("{}; {}", self.index, Provenance::gather().line());
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
pub struct Merged {
    /// The job.
    pub job: Job,
    /// The sums of all its photons.
    pub all: JobPart,
}

impl Merged {
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
