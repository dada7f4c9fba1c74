//! The comparison of a scene as a table for people and as CSV for plots.

use std::io::{self, Write};

use comfy_table::Table;

use super::grid::{Cell, Grid, Mark};
use crate::bench::ring::Mode;
use crate::studies::peers::{Comparison, Row};

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
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(to);
    // Written here rather than from the first row, so that a file without rows has it too.
    writer.write_record(CSV_COLUMNS)?;
    for row in rows {
        writer.serialize(Record::from(row)).map_err(io::Error::from)?;
    }
    writer.flush()
}

/// The first line of `compare.csv`; the fields of [`Record`].
const CSV_COLUMNS: [&str; 11] = [
    "scene",
    "contender",
    "mode",
    "triangles",
    "build_ms",
    "bytes",
    "mrays_median",
    "mrays_min",
    "mrays_max",
    "disagreements",
    "leaks",
];

/// The comparison of one scene, a line for each contender: see [`LEGEND`].
pub fn table(comparison: &Comparison) -> Table {
    grid(comparison).terminal()
}

/// What the columns of [`table`] are.
pub const LEGEND: &str = "single, batch (closest hits) and occluded in million rays a second, the median; x: \
     how many times the fastest Embree in the same mode, for batch in any; wrong: answers, of all modes, \
     that are not the exact ones; ties: another triangle at the same t; leaks: rays that left a closed \
     mesh, in the worst mode; bytes: with the contender's copy of the triangles, which a lean BVH has none of, \
     as it lies beside the application's indexed mesh";

/// As [`table`], for both forms.
pub(crate) fn grid(comparison: &Comparison) -> Grid {
    let headings = [
        "contender",
        "setting",
        "single",
        "x",
        "batch",
        "x",
        "occluded",
        "x",
        "build ms",
        "bytes/tri",
        "wrong",
        "ties",
        "leaks",
    ];
    let lines = comparison.rows.chunk_by(|a, b| a.contender == b.contender);
    Grid {
        headings: headings.map(str::to_owned).to_vec(),
        text_columns: 2,
        lines: lines.map(|rows| line(comparison, rows)).collect(),
    }
}

/// The modes of one contender.
fn line(comparison: &Comparison, rows: &[Row]) -> Vec<Cell> {
    let one = &rows[0];
    let mut cells = vec![Cell::new(one.contender), Cell::new(one.setting)];
    for mode in Mode::ALL {
        let speed = rows.iter().find(|row| row.mode == mode).map(|row| row.speed.median);
        let is_best = speed.is_some() && speed == fastest(&comparison.rows, |row| row.mode == mode);
        let ratio = speed.zip(embree(&comparison.rows, mode)).map(|(speed, best)| speed / best);
        let loses = one.is_ours && ratio.is_some_and(|ratio| ratio < 1.0);
        let mark = |holds, mark| if holds { mark } else { Mark::Plain };
        cells.push(Cell::number(speed, 2).marked(mark(is_best, Mark::Best)));
        cells.push(Cell::number(ratio, 2).marked(mark(loses, Mark::Loses)));
    }
    let wrong: usize = rows.iter().map(|row| row.disagreements.wrong()).sum();
    let ties: usize = rows.iter().map(|row| row.disagreements.tied).sum();
    let leaks = rows.iter().filter_map(|row| row.leaks).max();
    cells.extend([
        Cell::number(Some(one.build_seconds * 1e3), 1),
        Cell::number(bytes_per_triangle(one), 0),
        Cell::new(wrong.to_string()),
        Cell::new(ties.to_string()),
        leaks.map_or_else(Cell::unknown, |leaks| Cell::new(leaks.to_string())),
    ]);
    cells
}

/// What it holds, for each triangle of the scene.
pub(crate) fn bytes_per_triangle(row: &Row) -> Option<f64> {
    Some(row.bytes? as f64 / row.triangle_count.max(1) as f64)
}

/// The most million rays a second in the rows looked for.
pub(crate) fn fastest(rows: &[Row], wanted: impl Fn(&Row) -> bool) -> Option<f64> {
    let speeds = rows.iter().filter(|row| wanted(row)).map(|row| row.speed.median);
    speeds.max_by(f64::total_cmp)
}

/// The fastest Embree in a mode; for closest hits of many rays, in whichever of both ways.
pub(crate) fn embree(rows: &[Row], mode: Mode) -> Option<f64> {
    fastest(rows, |row| {
        let same = row.mode == mode || (mode == Mode::Batch && row.mode == Mode::Single);
        same && row.contender.starts_with("embree")
    })
}
