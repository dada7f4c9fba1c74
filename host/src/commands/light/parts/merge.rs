//! `arboleda merge`: parts of a job, put together.

use std::ops::Range;
use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use clap::Args;

use super::MergedJob;
use crate::commands::arguments::SceneArguments;
use crate::commands::arguments::part::PartArguments;
use crate::commands::arguments::values::file_ending_in;
use crate::commands::light::lit_scene::{LightingArguments, print_balance};
use crate::commands::light::shoot::write_flux;
use crate::commands::output::{count, say};
use crate::commands::{Command, parse_recorded};
use crate::files::output::check_outputs;
use crate::parts::{JobKind, JobPart, PartFile, PartSums, missing};
use crate::photon::Digest;

/// Put parts of a job together, which `shoot`, `irradiance` or `render` wrote with --part
///
/// Parts may be shot on any machines, through any indices, in any order; the result is that of one run, to the byte.
/// They must be of one job: the same scene, --photons, --seed, lights, and points or camera. No photon may be in two
/// parts. All photons must be there, except with --missing or --part.
///
/// For `irradiance` and `render`, the files of the scene and of the points are read again; --scene-file or --index-file,
/// and --points say where they are now. How a picture looks is what the part with the first photons says.
#[derive(Args)]
pub struct Merge {
    /// Files of the parts
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Print the ranges of photons that no part has, one on each line, as --photon-range reads them, and no more
    #[arg(long, conflicts_with_all = ["out", "values", "save_map", "part"])]
    missing: bool,
    #[command(flatten)]
    outputs: MergeOutputs,
    /// Write one part that has the photons of all these. Their files stay: leave them out of later merges. There may be no
    /// gap between the parts; the first and the last photons of the job may be missing
    #[arg(long, value_name = "FILE")]
    part: Option<PathBuf>,
}

/// Files that a merge writes, and those that it reads again.
#[derive(Args, Clone, Debug)]
pub struct MergeOutputs {
    /// Write what the command's --out writes: photons and flux of triangles (.npy, .csv), estimates (.npy), or a picture
    /// (.png)
    #[arg(long, value_name = "OUT", value_parser = file_ending_in(&["npy", "csv", "png"]))]
    pub out: Option<PathBuf>,
    /// Write the values of a picture's pixels, as `render --values` does
    #[arg(long, value_name = "OUT.exr|pfm", value_parser = file_ending_in(&["exr", "pfm"]))]
    pub values: Option<PathBuf>,
    /// Write the photon map, as --save-map of `irradiance` and `render` does
    #[arg(long, value_name = "FILE")]
    pub save_map: Option<PathBuf>,
    /// Read the scene from this file or folder; given several times, from all, in this order [default: the files that the
    /// parts name]
    #[arg(long, value_name = "SCENE")]
    pub scene_file: Vec<PathBuf>,
    /// Take the packed scene X.arb, as the command's --index-file does [default: what the parts name]
    #[arg(long, value_name = "X.arb", value_parser = file_ending_in(&["arb"]), conflicts_with = "scene_file")]
    pub index_file: Option<PathBuf>,
    /// Read the points from this file [default: the file that the parts name]
    #[arg(long, value_name = "POINTS.npy")]
    pub points: Option<PathBuf>,
}

impl MergeOutputs {
    /// Makes a command that parts recorded one that writes what the merge writes, and reads the scene where it is now.
    pub fn redirect(
        &self,
        scene: &mut SceneArguments,
        lighting: &mut LightingArguments,
        part: &mut PartArguments,
    ) {
        if !self.scene_file.is_empty() {
            scene.move_to(&self.scene_file);
            lighting.packed.move_to(None);
        }
        if let Some(path) = &self.index_file {
            lighting.packed.move_to(Some(path));
        }
        lighting.estimator.load_map = None;
        lighting.estimator.save_map.clone_from(&self.save_map);
        *part = PartArguments::NONE;
    }

    /// Checks that --out has one of the endings that a command writes.
    ///
    /// # Errors
    /// If it has another.
    pub fn check_out(&self, command: JobKind, endings: &[&str]) -> anyhow::Result<()> {
        let Some(path) = &self.out else { return Ok(()) };
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        let known: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
        let known = known.join(" or ");
        ensure!(
            endings.iter().any(|&known| ending == known),
            "{}: parts of `{command}` make a file whose name ends in {known}",
            path.display()
        );
        Ok(())
    }

    /// Checks that no option is given which a command does not have.
    ///
    /// # Errors
    /// If one is given, by its name.
    pub fn refuse(&self, command: JobKind, options: &[&str]) -> anyhow::Result<()> {
        let given = [
            ("--values", self.values.is_some()),
            ("--save-map", self.save_map.is_some()),
            ("--scene-file", !self.scene_file.is_empty()),
            ("--index-file", self.index_file.is_some()),
            ("--points", self.points.is_some()),
        ];
        let wrong = given.iter().find(|(name, given)| *given && options.contains(name));
        wrong.map_or(Ok(()), |(name, _)| bail!("{name} is not for parts of `{command}`"))
    }
}

impl Merge {
    /// Runs the command.
    ///
    /// # Errors
    /// If a file is no part, parts are of different jobs or have a photon in common, photons are missing, or a file
    /// cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        let MergeOutputs { out, values, save_map, .. } = &self.outputs;
        let files = [out, values, save_map, &self.part];
        check_outputs(files.into_iter().flatten(), &[])?;
        // A part may take the place of one that it holds, because it is written whole.
        check_outputs([out, values, save_map].into_iter().flatten(), &self.parts)?;
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
        let (_, PartFile { job, arguments, .. }) = files.first().context("no part was named")?;
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
        let is_whole_wanted = out.is_some() || values.is_some() || save_map.is_some();
        let allowed = self.part.is_some() && !is_whole_wanted && !gaps.iter().any(is_within);
        ensure!(allowed || gaps.is_empty(), "{}", said(&gaps));
        // Before all is read, which may take long.
        if job.kind == JobKind::Shoot {
            self.outputs.check_out(job.kind, &["npy", "csv"])?;
            let none = ["--values", "--save-map", "--scene-file", "--index-file", "--points"];
            self.outputs.refuse(job.kind, &none)?;
        }

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
            let (job, arguments) = (job.clone(), arguments.clone());
            let file = PartFile { job, photons: all.photons.clone(), arguments, provenance };
            file.write(path, &all.sums)?;
            log::info!("part: {}", path.display());
        }
        if !gaps.is_empty() {
            print_balance(&all.sums.balance());
            say!("photons {first}..{last} of {}", count(job.photons));
            return Ok(());
        }
        if let PartSums::Shot(sums) = &all.sums {
            if let Some(path) = out {
                write_flux(path, sums.hits.iter().copied(), sums.balance.photon_flux())?;
            }
            print_balance(&sums.balance);
            let parts = files.len();
            let by = format!("{parts} part{}", if parts == 1 { "" } else { "s" });
            print_digest(sums.balance.emitted, sums.digest(), &by);
            return Ok(());
        }
        let is_used = self.part.is_none() || is_whole_wanted;
        let (command, merged) = (parse_recorded(arguments)?, MergedJob { job: job.clone(), all });
        match command {
            _ if !is_used => Ok(()),
            Command::Irradiance(mut irradiance) => irradiance.finish(&self.outputs, merged),
            Command::Render(mut render) => render.finish(&self.outputs, merged),
            _ => bail!("{} names another command than its job", files[0].0.display()),
        }
    }
}

/// Prints the digest of all hits, and by what they were shot.
pub fn print_digest(photons: u64, digest: Digest, by: &str) {
    say!("digest of {} photons: {digest} by {by}", count(photons));
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
