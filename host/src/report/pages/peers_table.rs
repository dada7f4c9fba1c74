//! Comparisons with other libraries as tables for people and as CSV for plots.

use std::path::Path;

use crate::benchmark::contenders::contender::Mode;
use crate::benchmark::harness::record;
use crate::benchmark::studies::peers::{PeerComparison, PeerRow};
use crate::report::grid::{Cell, Grid, Mark};

/// Row of `compare.csv`; bytes and leaks that are not known are left empty.
#[derive(serde::Serialize)]
struct PeerRecord<'r> {
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

impl<'r> From<&'r PeerRow> for PeerRecord<'r> {
    fn from(row: &'r PeerRow) -> Self {
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

/// Writes all rows as comma-separated values.
///
/// # Errors
/// If the file cannot be written.
pub fn write_csv<'r>(
    path: &Path,
    rows: impl IntoIterator<Item = &'r PeerRow>,
) -> anyhow::Result<()> {
    record::write_csv(path, rows.into_iter().map(PeerRecord::from))
}

/// Columns of [`scene_grid`].
pub const SCENE_LEGEND: &str = "single, batch (closest hits) and occluded in million rays a second, the median; x: \
     how many times the fastest Embree in the same mode, for batch in any; wrong: answers, of all modes, \
     that are not the exact ones; ties: another triangle at the same t; leaks: rays that left a closed \
     mesh, in the worst mode; bytes: with the contender's copy of the triangles, which a lean BVH has none of, \
     as it lies beside the application's indexed mesh";

/// Makes the table of one scene, a line for each contender.
pub fn scene_grid(comparison: &PeerComparison) -> Grid {
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
        lines: lines.map(|rows| scene_line(comparison, rows)).collect(),
    }
}

/// Fills the line of one contender.
fn scene_line(comparison: &PeerComparison, rows: &[PeerRow]) -> Vec<Cell> {
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

/// Returns the bytes that it holds, for each triangle of the scene.
pub(super) fn bytes_per_triangle(row: &PeerRow) -> Option<f64> {
    Some(row.bytes? as f64 / row.triangle_count.max(1) as f64)
}

/// Returns the most million rays a second in the rows looked for.
pub(super) fn fastest(rows: &[PeerRow], wanted: impl Fn(&PeerRow) -> bool) -> Option<f64> {
    let speeds = rows.iter().filter(|row| wanted(row)).map(|row| row.speed.median);
    speeds.max_by(f64::total_cmp)
}

/// Returns the speed of the fastest Embree in a mode; for closest hits of many rays, in whichever of both ways.
pub(super) fn embree(rows: &[PeerRow], mode: Mode) -> Option<f64> {
    fastest(rows, |row| {
        let same = row.mode == mode || (mode == Mode::Batch && row.mode == Mode::Single);
        same && row.contender.starts_with("embree")
    })
}

/// Columns of [`growth_grid`].
pub const GROWTH_LEGEND: &str = "n triangles: nanoseconds of the build, and divided by n log2 n; nanoseconds a ray in \
     each mode, and divided by log2 n";

/// Makes the table of scenes by size, a line for each scene and contender.
pub fn growth_grid(comparisons: &[PeerComparison]) -> Grid {
    let headings = [
        "scene",
        "contender",
        "n",
        "build ms",
        "ns/(n log n)",
        "single ns",
        "/log n",
        "batch ns",
        "/log n",
        "occluded ns",
        "/log n",
    ];
    let by_contender = comparisons
        .iter()
        .flat_map(|comparison| comparison.rows.chunk_by(|a, b| a.contender == b.contender));
    Grid {
        headings: headings.map(str::to_owned).to_vec(),
        text_columns: 2,
        lines: by_contender.map(growth_line).collect(),
    }
}

/// Fills the line of one contender on one scene.
fn growth_line(rows: &[PeerRow]) -> Vec<Cell> {
    let one = &rows[0];
    let count = one.triangle_count as f64;
    let logarithm = count.max(2.0).log2();
    let per_unit = one.build_seconds * 1e9 / (count * logarithm);
    let mut cells = vec![
        Cell::new(&*one.scene),
        Cell::new(one.contender),
        Cell::new(one.triangle_count.to_string()),
        Cell::number(Some(one.build_seconds * 1e3), 1),
        Cell::number(Some(per_unit), 1),
    ];
    for mode in Mode::ALL {
        let row = rows.iter().find(|row| row.mode == mode);
        let nanoseconds = row.map(|row| 1e3 / row.speed.median);
        cells.push(Cell::number(nanoseconds, 0));
        cells.push(Cell::number(nanoseconds.map(|time| time / logarithm), 1));
    }
    cells
}
