//! The program `arboleda`: hands its arguments to `commands::run`.

use std::process::ExitCode;

fn main() -> ExitCode {
    arboleda_host::commands::run(std::env::args_os())
}
