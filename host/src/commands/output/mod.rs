//! Formatting and printing of results: numbers, tables, lines; a picture of clusters.

pub mod cluster_picture;

use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use comfy_table::Table;

use crate::report::grid::terminal_table;

/// True if another process prints the results.
static SILENT: AtomicBool = AtomicBool::new(false);

/// Leaves the printing of results to another process.
#[cfg(feature = "mpi")]
pub fn be_silent() {
    SILENT.store(true, Ordering::Relaxed);
}

/// Prints a line of the results.
macro_rules! say {
    ($($argument:tt)*) => {
        $crate::commands::output::print_line(format_args!($($argument)*))
    };
}
pub(crate) use say;

/// Prints a line for `say!`. Ends the program if stdout cannot be written: silently if the reader has closed the pipe,
/// as in `arboleda | head`, else with an error.
pub fn print_line(line: std::fmt::Arguments<'_>) {
    if SILENT.load(Ordering::Relaxed) {
        return;
    }
    match writeln!(std::io::stdout(), "{line}") {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::BrokenPipe => std::process::exit(0),
        Err(error) => {
            eprintln!("error: cannot write the results: {error}");
            std::process::exit(1);
        }
    }
}

/// Creates a table whose first column is text and whose other columns are numbers, aligned to the right.
pub fn table(headings: &[&str]) -> Table {
    terminal_table(headings, 1)
}

/// Writes a count with commas: 1,234,567.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Writes a number of bytes in B, KiB, MiB or GiB, below 1024 in each but the last.
pub fn bytes(number: usize) -> String {
    let mut value = number as f64;
    for unit in ["B", "KiB", "MiB"] {
        if value < 1024.0 {
            let places = usize::from(unit != "B");
            return format!("{value:.places$} {unit}");
        }
        value /= 1024.0;
    }
    format!("{value:.2} GiB")
}

/// Writes seconds in us, ms or s, below 1000 in each but the last.
pub fn duration(seconds: f64) -> String {
    if seconds < 1e-3 {
        format!("{:.0} us", seconds * 1e6)
    } else if seconds < 1.0 {
        format!("{:.1} ms", seconds * 1e3)
    } else {
        format!("{seconds:.2} s")
    }
}

/// Writes where a result went: ` -> FILE`, or nothing.
pub fn arrow_to(path: Option<&Path>) -> String {
    path.map(|path| format!(" -> {}", path.display())).unwrap_or_default()
}
