//! Numbers and tables as people read them.

use std::io::Write;

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, Table, TableComponent};
use indicatif::{ProgressBar, ProgressStyle};

/// Prints a line; ends the program quietly where nobody reads on, as in `arboleda | head`.
macro_rules! say {
    ($($argument:tt)*) => {
        $crate::commands::output::print_line(format_args!($($argument)*))
    };
}
pub(crate) use say;

/// What `say!` calls.
pub fn print_line(line: std::fmt::Arguments<'_>) {
    if writeln!(std::io::stdout(), "{line}").is_err() {
        std::process::exit(0);
    }
}

/// A table whose first column is text and the others numbers.
pub fn table(headings: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(UTF8_HORIZONTAL_ONLY).set_header(headings);
    table.remove_style(TableComponent::HorizontalLines);
    table.remove_style(TableComponent::MiddleIntersections);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// A count with commas: 1,234,567.
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

/// Bytes in the unit that leaves one to three digits before the point.
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

/// Seconds in the unit that leaves one to three digits before the point.
pub fn duration(seconds: f64) -> String {
    if seconds < 1e-3 {
        format!("{:.0} us", seconds * 1e6)
    } else if seconds < 1.0 {
        format!("{:.1} ms", seconds * 1e3)
    } else {
        format!("{seconds:.2} s")
    }
}

/// A bar on stderr that counts photons; nothing where stderr is no terminal.
pub fn photon_bar(photons: u64, label: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(
        "{prefix:>18} {bar:40} {human_pos}/{human_len} photons, {per_sec}, {eta} left",
    );
    let bar = ProgressBar::new(photons).with_prefix(label.to_owned());
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
