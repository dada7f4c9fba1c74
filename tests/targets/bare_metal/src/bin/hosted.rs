//! The lines on a machine with an operating system: what the others are compared with.

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut lines = String::new();
    let outcome = arboleda_bare_metal::run(&mut lines);
    print!("{lines}");
    if outcome.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
