//! The comparison as a table for people and as CSV for plots.

use std::io::{self, Write};

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, Table, TableComponent};

use super::comparison::{Comparison, Row};
use super::ring::Mode;

/// A row of `compare.csv`.
#[derive(serde::Serialize)]
struct Record<'r> {
    scene: &'r str,
    contender: &'r str,
    mode: Mode,
    triangles: usize,
    build_ms: f64,
    bytes: Option<usize>,
    mrays_median: f64,
    mrays_min: f64,
    mrays_max: f64,
    disagreements: usize,
    leaks: Option<usize>,
}

impl<'r> From<&'r Row> for Record<'r> {
    fn from(row: &'r Row) -> Self {
        let rounded = |speed: f64| (speed * 1e4).round() / 1e4;
        Self {
            scene: &row.scene,
            contender: row.contender,
            mode: row.mode,
            triangles: row.triangle_count,
            build_ms: (row.build_seconds * 1e6).round() / 1e3,
            bytes: row.bytes,
            mrays_median: rounded(row.speed.median),
            mrays_min: rounded(row.speed.min),
            mrays_max: rounded(row.speed.max),
            disagreements: row.disagreements.total(),
            leaks: row.leaks,
        }
    }
}

/// Writes all rows as CSV; bytes and leaks that are not known are left empty.
///
/// # Errors
/// Those of the writer.
pub fn write_csv<'r>(to: impl Write, rows: impl IntoIterator<Item = &'r Row>) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(to);
    for row in rows {
        writer.serialize(Record::from(row)).map_err(io::Error::from)?;
    }
    writer.flush()
}

/// The comparison of one scene, one line for each contender and mode.
///
/// The ratio is to the fastest one-ray-at-a-time Embree in the same kind of question.
pub fn table(comparison: &Comparison) -> Table {
    let mut table = Table::new();
    table.load_preset(UTF8_HORIZONTAL_ONLY);
    table.remove_style(TableComponent::HorizontalLines);
    table.remove_style(TableComponent::MiddleIntersections);
    table.set_header([
        "contender",
        "setting",
        "mode",
        "Mrays/s",
        "min",
        "max",
        "to Embree",
        "build ms",
        "bytes/tri",
        "missed",
        "phantom",
        "elsewhere",
        "tied",
        "leaks",
    ]);
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    for row in &comparison.rows {
        let unknown = || "-".to_string();
        let per_triangle = |bytes| bytes as f64 / row.triangle_count.max(1) as f64;
        let wrong = row.disagreements;
        table.add_row([
            row.contender.to_string(),
            row.setting.to_string(),
            row.mode.name().to_string(),
            format!("{:.2}", row.speed.median),
            format!("{:.2}", row.speed.min),
            format!("{:.2}", row.speed.max),
            embree(&comparison.rows, row.mode)
                .map_or_else(unknown, |embree| format!("{:.2}", row.speed.median / embree)),
            format!("{:.1}", row.build_seconds * 1e3),
            row.bytes.map_or_else(unknown, |bytes| format!("{:.0}", per_triangle(bytes))),
            wrong.missed.to_string(),
            wrong.phantom.to_string(),
            wrong.elsewhere.to_string(),
            wrong.tied.to_string(),
            row.leaks.map_or_else(unknown, |leaks| leaks.to_string()),
        ]);
    }
    table
}

/// The speed of the fastest Embree one ray at a time.
fn embree(rows: &[Row], mode: Mode) -> Option<f64> {
    let asked = match mode {
        Mode::Single | Mode::Batch => Mode::Single,
        Mode::Occluded => Mode::Occluded,
    };
    rows.iter()
        .filter(|row| row.contender.starts_with("embree") && row.mode == asked)
        .map(|row| row.speed.median)
        .max_by(f64::total_cmp)
}
