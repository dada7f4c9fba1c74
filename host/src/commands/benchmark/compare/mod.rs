//! `arboleda compare`: every index on every scene; as subcommands, comparisons of another kind.

mod calibrate;
mod indices;
mod levels;
mod peers;
mod scenes;

use clap::{Args, Subcommand};

use crate::benchmark::studies::counters;
use crate::commands::output::say;

/// Compare every index on every scene: time, spread, memory, counters; with a page and a file
#[derive(Args)]
#[command(
    disable_help_subcommand = true,
    override_usage = "arboleda compare [OPTIONS] [SCENE]...\n       arboleda compare <COMPARISON> [OPTIONS]",
    subcommand_help_heading = "Other comparisons",
    subcommand_precedence_over_arg = true
)]
pub struct Compare {
    #[command(subcommand)]
    other: Option<Other>,
    #[command(flatten)]
    indices: indices::Indices,
}

// Help comes from the doc comment of each command's type, where it has one.
#[derive(Subcommand)]
enum Other {
    Peers(peers::Peers),
    /// Print figures that are the same on every machine and in every run, for a diff: bytes, nodes, tests, digests
    Counters,
    Levels(levels::Levels),
    Calibrate(calibrate::Calibrate),
}

impl Compare {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or a file cannot be read or written.
    pub fn run(&self) -> anyhow::Result<()> {
        match &self.other {
            None => self.indices.run(),
            Some(Other::Peers(peers)) => peers.run(),
            Some(Other::Counters) => {
                say!("{}", counters::lines()?.trim_end());
                Ok(())
            }
            Some(Other::Levels(levels)) => levels.run(),
            Some(Other::Calibrate(calibrate)) => calibrate.run(),
        }
    }
}
