//! The command line.

use std::process::ExitCode;

use arboleda_host::commands::CommandLine;
use clap::Parser;

fn main() -> ExitCode {
    match CommandLine::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
