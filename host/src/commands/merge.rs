//! `arboleda merge`: parts of a shot, put together.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use clap::Args;

use super::arguments::values::file_ending_in;
use super::lit_scene::print_balance;
use super::output::{count, say};
use super::shoot::write_flux;
use crate::files::output::check_writable;
use crate::photon::{Digest, JobPart, PartFile, missing};

/// Put parts of a shot together, which `shoot --part` wrote
///
/// Parts may be shot on any machines, through any indices, in any order; the result is that of one run, to the byte.
/// They must be of one job: the same scene, --photons, --seed and lights. No photon may be in two parts. All photons must
/// be there, except with --missing or --part.
#[derive(Args)]
pub struct Merge {
    /// Files of the parts
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Print the ranges of photons that no part has, one on each line, as `shoot --photon-range` reads them, and no more
    #[arg(long, conflicts_with_all = ["out", "part"])]
    missing: bool,
    /// Write the photons and the flux that each side of each triangle received, as `shoot --out` does
    #[arg(long, value_name = "OUT.npy|csv", value_parser = file_ending_in(&["npy", "csv"]))]
    out: Option<PathBuf>,
    /// Write one part that has the photons of all these. Their files stay: leave them out of later merges. There may be no
    /// gap between the parts; the first and the last photons of the job may be missing
    #[arg(long, value_name = "FILE")]
    part: Option<PathBuf>,
}

impl Merge {
    /// Runs the command.
    ///
    /// # Errors
    /// If a file is no part, parts are of different jobs or have a photon in common, photons are missing, or a file
    /// cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        [&self.out, &self.part].into_iter().flatten().try_for_each(|path| check_writable(path))?;
        // 1. Check each file. Its sums are dropped, and read again in step 2, so that memory holds those of two.
        let mut files: Vec<(&PathBuf, PartFile)> = Vec::new();
        for path in &self.parts {
            let file = PartFile::read(path)?;
            if let Some((first, other)) = files.first()
                && let Some(difference) = other.job.difference(&file.job)
            {
                bail!(
                    "{} is a part of another job than {}: it has {difference}",
                    path.display(),
                    first.display()
                );
            }
            files.push((path, file));
        }
        files.sort_by_key(|(_, file)| file.photons.start);
        let ranges: Vec<Range<u64>> = files.iter().map(|(_, file)| file.photons.clone()).collect();
        let (_, PartFile { job, .. }) = files.first().context("no part was named")?;
        let gaps = missing(job.photons, &ranges).map_err(|overlap| {
            let [a, b] = overlap.parts.map(|part| files[part].0.display());
            let Range { start, end } = overlap.photons;
            anyhow::anyhow!("photons {start}..{end} are in {a} and in {b}: leave one out")
        })?;
        if self.missing {
            for gap in gaps {
                say!("{}..{}", gap.start, gap.end);
            }
            return Ok(());
        }
        let (first, last) = (ranges[0].start, ranges[ranges.len() - 1].end);
        let is_within = |gap: &Range<u64>| first < gap.end && gap.start < last;
        let allowed = self.part.is_some() && self.out.is_none() && !gaps.iter().any(is_within);
        ensure!(allowed || gaps.is_empty(), "{}", said(&gaps));

        // 2. The sums, in the order of photons.
        let mut all: Option<JobPart> = None;
        for (path, file) in &files {
            let part = file.read_part(path)?;
            match &mut all {
                None => all = Some(part),
                Some(all) => ensure!(all.join(part), "{} does not follow", path.display()),
            }
        }
        let all = all.context("no part was named")?;

        // 3. The outputs.
        if let Some(path) = &self.part {
            let provenance = format!("merged from {} parts", files.len());
            let file = PartFile { job: job.clone(), photons: all.photons.clone(), provenance };
            file.write(path, &all.sums)?;
            log::info!("part: {}", path.display());
        }
        if let Some(path) = &self.out {
            write_flux(path, &all.sums.hits, all.sums.balance.photon_flux())?;
            log::info!("photons and flux of each triangle: {}", path.display());
        }
        print_balance(&all.sums.balance);
        match all.digest(job) {
            Some(digest) => print_digest(all.sums.balance.emitted, digest, files.len()),
            None => say!("photons {first}..{last} of {}", count(job.photons)),
        }
        Ok(())
    }
}

fn print_digest(photons: u64, digest: Digest, parts: usize) {
    say!(
        "digest of {} photons: {digest} by {parts} part{}",
        count(photons),
        if parts == 1 { "" } else { "s" }
    );
}

/// Says which photons are missing, the first of them by their ranges.
fn said(gaps: &[Range<u64>]) -> String {
    const SOME: usize = 5;
    let ranges: Vec<String> =
        gaps.iter().take(SOME).map(|gap| format!("{}..{}", gap.start, gap.end)).collect();
    let more = gaps.len().saturating_sub(SOME);
    let more = if more > 0 { format!(" and {more} more ranges") } else { String::new() };
    format!(
        "photons {}{more} are in no part: shoot them with --photon-range, or see merge --missing",
        ranges.join(", ")
    )
}
