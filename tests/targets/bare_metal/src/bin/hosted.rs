//! Digest lines on a machine with an operating system, the reference for all other targets.

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut lines = String::new();
    let outcome = arboleda_bare_metal::run(&mut lines);
    print!("{lines}");
    if outcome.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
