//! `arboleda separation`: what clusters gain as they move apart.

use std::path::PathBuf;

use clap::Args;

use crate::benchmark::harness::plan::{Effort, Share};
use crate::benchmark::harness::progress::with_bar;
use crate::benchmark::harness::record::Recorder;
use crate::benchmark::studies::separation::{self, SeparationRow};
use crate::commands::arguments::MeasureArguments;
use crate::commands::output::{bytes, count, say, table};
use crate::files::output::check_writable;

/// Compare each index with its hierarchy, on two clusters from touching to 10,000 times their size apart
#[derive(Args)]
#[command(mut_arg("photons", |photons| photons.default_value("50000")))]
pub struct Separation {
    #[command(flatten)]
    measure: MeasureArguments,
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
        let effort = self.measure.effort(SECONDS, Share::Own);
        let rows = measure(&effort)?;
        print_rows(&rows);
        if let Some(path) = &self.csv {
            let mut recorder = Recorder::new(effort.seed);
            record(&mut recorder, &rows);
            recorder.write_csv(path)?;
            log::info!("measurements: {}", path.display());
        }
        Ok(())
    }
}

/// About how long a repetition may take.
const SECONDS: f64 = 0.1;

/// Measures the study with a bar. Each index answers what it can in the time: some are a thousand times slower at large
/// gaps.
///
/// # Errors
/// If two indices do not agree.
pub fn measure(effort: &Effort) -> anyhow::Result<Vec<SeparationRow>> {
    let effort = Effort { seconds: SECONDS, share: Share::Own, ..*effort };
    with_bar(separation::steps(), "separation", |progress| separation::run(&effort, progress))
}

/// Adds all measurements to the records.
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
