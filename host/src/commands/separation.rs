//! `arboleda separation`: what clusters gain as they move apart.

use std::path::PathBuf;

use clap::Args;

use super::output::{bytes, count, say, table};
use super::values::{MOST_REPETITIONS, MOST_REPLAYED_PHOTONS, whole};
use crate::bench::plan::{Effort, Share};
use crate::bench::progress::step_bar;
use crate::bench::record::Recorder;
use crate::file_output::check_writable;
use crate::studies::separation::{self, SeparationRow};

/// Compare each index with its hierarchy, on two clusters from touching to 10,000 times their size apart
#[derive(Args)]
pub struct Separation {
    /// Photons to each repetition
    #[arg(long, value_name = "N", default_value_t = 50_000, value_parser = whole::<u64>(1..=MOST_REPLAYED_PHOTONS))]
    photons: u64,
    /// How often the rays are replayed
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = whole::<usize>(1..=MOST_REPETITIONS))]
    repetitions: usize,
    /// Another seed gives other photons
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write all measurements to a file
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
}

impl Separation {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or the file cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        if let Some(path) = &self.csv {
            check_writable(path)?;
        }
        let effort = separation_effort(self.photons, self.repetitions);
        let bar = step_bar(separation::steps(), "separation");
        let rows = separation::run(&effort, self.seed, &mut || bar.inc(1))?;
        bar.finish_and_clear();
        print_rows(&rows);
        if let Some(path) = &self.csv {
            let mut recorder = Recorder::new(self.seed);
            record(&mut recorder, &rows);
            recorder.write_csv(path)?;
            log::info!("measurements: {}", path.display());
        }
        Ok(())
    }
}

/// Each index answers what it can in the time: some are a thousand times slower at large gaps.
pub fn separation_effort(photons: u64, repetitions: usize) -> Effort {
    Effort { photons, repetitions, seconds: 0.1, share: Share::Own }
}

/// Files all measurements.
pub fn record(recorder: &mut Recorder, rows: &[SeparationRow]) {
    for row in rows {
        let scene = format!("fig3 at {} sizes", row.gap);
        recorder.add("separation", &scene, &[row.single.clone(), row.clustered.clone()]);
    }
}

fn print_rows(rows: &[SeparationRow]) {
    say!("gap: as a multiple of the clusters' size; saved: by the hierarchy, over the slower");
    let mut lines = table(&[
        "index",
        "gap",
        "single/s",
        "hierarchy/s",
        "time saved",
        "counters saved",
        "memory saved",
        "single",
        "hierarchy",
    ]);
    let mut order: Vec<&SeparationRow> = rows.iter().collect();
    order.sort_by_key(|row| row.single.case.kind);
    for row in order {
        let gains = row.gains();
        lines.add_row([
            row.single.case.kind.name().to_owned(),
            count(u64::from(row.gap)),
            count(row.single.photons_per_second() as u64),
            count(row.clustered.photons_per_second() as u64),
            format!("{:.1}%", gains.time),
            format!("{:.1}%", gains.counters),
            format!("{:.1}%", gains.memory),
            bytes(row.single.bytes),
            bytes(row.clustered.bytes),
        ]);
    }
    say!("{lines}");
}
