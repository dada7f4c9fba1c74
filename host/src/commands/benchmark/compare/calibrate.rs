//! `arboleda compare calibrate`: the weights of the automatic selection.

use clap::Args;

use super::scenes::SceneChoice;
use crate::benchmark::harness::progress::with_bar;
use crate::benchmark::studies::calibration;
use crate::commands::output::say;
use crate::scene::builtin;

/// Measure what a ray, a node and a test take in each index, and print the weights of the automatic selection
#[derive(Args)]
pub struct Calibrate {
    #[command(flatten)]
    scenes: SceneChoice,
    /// Another seed gives other photons
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

impl Calibrate {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or a scene cannot be read.
    pub fn run(&self) -> anyhow::Result<()> {
        let models = self.scenes.models(builtin::names())?;
        let fits = with_bar(calibration::steps(&models), "calibration", |progress| {
            calibration::run(&models, self.seed, progress)
        })?;
        say!("{}", calibration::lines(&fits).trim_end());
        Ok(())
    }
}
