//! Commands of the program: arguments, help, output.
//!
//! ```text
//! arguments -> inspect, pack, cast | light (shoot, irradiance, render, merge) | benchmark (compare, paper, separation)
//!           -> demo (without a command)                                       -> output
//! ```
//! Results go to stdout; notes, warnings, progress and errors go to stderr. `--quiet` leaves results and errors.

mod arguments;
mod benchmark;
mod cast;
mod demo;
mod inspect;
mod light;
mod output;
mod pack;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use anyhow::Context;
use benchmark::{compare, paper, separation};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use light::parts::{self, Team};
use light::{irradiance, render, shoot};
use log::{Level, LevelFilter};

/// Exact ray queries on scenes made of clusters: finds the clusters, builds an index in each, shoots photons.
///
/// Without a command: finds the clusters of a built-in scene, shoots photons through every index, and compares the
/// results.
#[derive(Parser)]
#[command(name = "arboleda", version)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    demo: demo::Demo,
    /// Print only results and errors: no notes, warnings or progress
    #[arg(long, short, global = true)]
    quiet: bool,
}

// The doc comment of each command's type is its help. A doc comment on a variant would replace it.
#[derive(Subcommand)]
enum Command {
    Shoot(Box<shoot::Shoot>),
    Merge(Box<parts::Merge>),
    Inspect(inspect::Inspect),
    Pack(pack::Pack),
    Cast(cast::Cast),
    Irradiance(Box<irradiance::Irradiance>),
    Render(Box<render::Render>),
    Compare(compare::Compare),
    Paper(paper::Paper),
    Separation(separation::Separation),
}

impl CommandLine {
    /// Tells whether several processes can run the command together.
    fn is_for_many(&self) -> bool {
        matches!(
            self.command,
            Some(Command::Shoot(_) | Command::Irradiance(_) | Command::Render(_))
        )
    }

    /// Runs the command that these arguments named, with a team.
    fn run(&self, arguments: &[OsString], team: Team) -> anyhow::Result<()> {
        match &self.command {
            None => self.demo.run(),
            Some(Command::Shoot(shoot)) => shoot.run(team),
            Some(Command::Merge(merge)) => merge.run(),
            Some(Command::Inspect(inspect)) => inspect.run(),
            Some(Command::Pack(pack)) => pack.run(),
            Some(Command::Cast(cast)) => cast.run(),
            Some(Command::Irradiance(irradiance)) => irradiance.run(arguments, team),
            Some(Command::Render(render)) => render.run(arguments, team),
            Some(Command::Compare(compare)) => compare.run(),
            Some(Command::Paper(paper)) => paper.run(),
            Some(Command::Separation(separation)) => separation.run(),
        }
    }
}

/// Runs the command that the arguments name, and prints its error. The first argument is the program's name.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let line = match parse(&arguments) {
        Ok(line) => line,
        // Help and version are such answers too. Printing fails if stdout is a full device.
        Err(answer) => {
            let code = u8::try_from(answer.exit_code()).unwrap_or(1);
            return if answer.print().is_ok() { code.into() } else { ExitCode::FAILURE };
        }
    };
    let level = if line.quiet { LevelFilter::Off } else { LevelFilter::Info };
    match run_with_team(&line, &arguments, level) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", message(&error));
            ExitCode::FAILURE
        }
    }
}

#[cfg(not(feature = "mpi"))]
fn run_with_team(
    line: &CommandLine,
    arguments: &[OsString],
    level: LevelFilter,
) -> anyhow::Result<()> {
    // As Open MPI, and MPICH and its kin, say how many processes there are.
    let size =
        ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"].into_iter().find_map(|name| std::env::var(name).ok());
    anyhow::ensure!(
        !line.is_for_many() || size.is_none_or(|size| size == "1"),
        "started by MPI, but built without the feature `mpi`: each process would do the whole job"
    );
    speak_from(level);
    line.run(arguments, Team::Alone)
}

/// Runs the command with the processes that `mpirun` started, if it did. The first of them speaks for all.
#[cfg(feature = "mpi")]
fn run_with_team(
    line: &CommandLine,
    arguments: &[OsString],
    level: LevelFilter,
) -> anyhow::Result<()> {
    let ranks = if line.is_for_many() { parts::join_ranks()? } else { None };
    let Some((_universe, team)) = ranks else {
        speak_from(level);
        return line.run(arguments, Team::Alone);
    };
    if team == Team::Other {
        output::be_silent();
        speak_from(LevelFilter::Off);
    } else {
        speak_from(level);
    }
    if let Err(error) = line.run(arguments, team) {
        eprintln!("error: {}", message(&error));
        parts::abort();
    }
    Ok(())
}

/// Reads the command that arguments named when a part was shot.
///
/// # Errors
/// If they are not those of a command of this program.
fn parse_recorded(arguments: &[String]) -> anyhow::Result<Command> {
    let arguments: Vec<OsString> = arguments.iter().map(OsString::from).collect();
    let line =
        parse(&arguments).context("the part names arguments that this program does not have")?;
    line.command.context("the part names no command")
}

fn parse(arguments: &[OsString]) -> Result<CommandLine, clap::Error> {
    let mut command = with_negative_values(CommandLine::command());
    let matches = command.try_get_matches_from_mut(arguments)?;
    if let Some((argument, name)) = misplaced_argument(&command, &matches) {
        let text = format!("{argument} before `{name}` has no effect; write it after `{name}`");
        return Err(command.error(ErrorKind::ArgumentConflict, text));
    }
    CommandLine::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// Finds the first argument that stands before the name of a command although it is not global, and that name.
fn misplaced_argument(command: &clap::Command, matches: &ArgMatches) -> Option<(String, String)> {
    let (name, inner) = matches.subcommand()?;
    let given = |argument: &&clap::Arg| {
        let source = matches.value_source(argument.get_id().as_str());
        !argument.is_global_set() && source == Some(ValueSource::CommandLine)
    };
    match command.get_arguments().find(given) {
        Some(argument) => {
            let value = || argument.get_value_names()?.first().map(ToString::to_string);
            let option = argument.get_long().map(|long| format!("--{long}"));
            Some((option.or_else(value)?, name.to_owned()))
        }
        None => misplaced_argument(command.find_subcommand(name)?, inner),
    }
}

/// Lets options take negative numbers. Otherwise `-1` would be refused as an unknown option, without the valid range.
fn with_negative_values(command: clap::Command) -> clap::Command {
    command
        .mut_args(|argument| {
            let takes_value = argument.get_action().takes_values() && !argument.is_positional();
            if takes_value { argument.allow_negative_numbers(true) } else { argument }
        })
        .mut_subcommands(with_negative_values)
}

/// Sets the log up: prints notes as they are and warnings after `warning: `, on stderr.
fn speak_from(level: LevelFilter) {
    env_logger::Builder::new()
        .filter_module(env!("CARGO_CRATE_NAME"), level)
        .format(|stream, record| match record.level() {
            Level::Error | Level::Warn => writeln!(stream, "warning: {}", record.args()),
            _ => writeln!(stream, "{}", record.args()),
        })
        .init();
}

/// Joins an error and its causes in one line. A cause that the text already contains is left out.
fn message(error: &anyhow::Error) -> String {
    let mut message = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !message.contains(&cause) {
            message = format!("{message}: {cause}");
        }
    }
    message
}

#[cfg(test)]
mod tests {
    use anyhow::anyhow;

    use super::*;

    #[test]
    fn a_cause_is_told_once() {
        let error =
            crate::scene::load("no-such-file.obj".as_ref(), crate::scene::Origin::Unchanged)
                .unwrap_err();
        let text = message(&error.into());
        assert_eq!(text.matches("No such file").count(), 1, "{text}");
        assert_eq!(
            message(&anyhow!("full").context("cannot write a.npy")),
            "cannot write a.npy: full"
        );
    }

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
