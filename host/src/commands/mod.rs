//! The commands: what a person types, and what comes back.

mod arguments;
mod cast;
mod compare;
mod compare_peers;
mod demo;
mod inspect;
mod output;
mod paper;
mod separation;
mod shoot;

use clap::{Parser, Subcommand};

/// Exact ray queries on scenes made of clusters: finds the clusters, builds an index in each, shoots photons.
///
/// Without a command: does all of it on a built-in scene, with every index, and compares the answers.
#[derive(Parser)]
#[command(name = "arboleda", version, args_conflicts_with_subcommands = true)]
pub struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    demo: demo::Demo,
}

#[derive(Subcommand)]
enum Command {
    /// Shoot photons from the lights of a scene through an index, or all of them
    Shoot(shoot::Shoot),
    /// Show the clusters of a scene, the cluster tree, levels and memory, with a picture
    Inspect(inspect::Inspect),
    /// Answer the rays of a `NumPy` file
    Cast(cast::Cast),
    Compare(compare::Compare),
    Paper(paper::Paper),
    Separation(separation::Separation),
}

impl CommandLine {
    /// Does what was asked.
    ///
    /// # Errors
    /// With a message for a person.
    pub fn run(&self) -> anyhow::Result<()> {
        match &self.command {
            None => self.demo.run(),
            Some(Command::Shoot(shoot)) => shoot.run(),
            Some(Command::Inspect(inspect)) => inspect.run(),
            Some(Command::Cast(cast)) => cast.run(),
            Some(Command::Compare(compare)) => compare.run(),
            Some(Command::Paper(paper)) => paper.run(),
            Some(Command::Separation(separation)) => separation.run(),
        }
    }
}
