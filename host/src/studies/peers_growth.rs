//! Build and query time against triangle count: two kinds of scene, ten times larger each step.
//!
//! A good build grows as n log n and a good query as log n. What grows faster is memory: a scene of a
//! thousand triangles lies in the closest cache, one of ten million in none.

use arboleda::BuildError;
use comfy_table::Table;

use crate::bench::ring::Mode;
use crate::contenders::EMBREE_MEDIUM;
use crate::report::grid::{Cell, Grid};
use crate::scene::Model;
use crate::scene::builtin::SIZED;
use crate::studies::peers::{Comparison, ComparisonOptions, Row, compare};

/// The sizes, as far as they are asked for.
const SIZES: [u32; 5] = [1_000, 10_000, 100_000, 1_000_000, 10_000_000];

/// How many scenes there are up to `largest` triangles.
pub fn scene_count(largest: u32) -> usize {
    SIZED.len() * sizes(largest).count()
}

/// The scenes up to `largest` triangles, each made when its turn comes.
pub fn scenes(largest: u32) -> impl Iterator<Item = Model> {
    SIZED.into_iter().flat_map(move |(family, build)| {
        sizes(largest).map(move |size| {
            let mut model = build(size);
            model.name = format!("{family}-{size}");
            model
        })
    })
}

fn sizes(largest: u32) -> impl Iterator<Item = u32> {
    SIZES.into_iter().filter(move |&size| size <= largest)
}

/// Compares the first of ours with Embree's default. All of ours grow in `arboleda compare --out`.
///
/// # Errors
/// As [`compare`].
pub fn one(model: &Model, options: &ComparisonOptions<'_>) -> Result<Comparison, BuildError> {
    let options = ComparisonOptions {
        peers: &[EMBREE_MEDIUM],
        kinds: &options.kinds[..options.kinds.len().min(1)],
        leak_ray_count: 0,
        ..*options
    };
    compare(model, &options, &mut || ())
}

/// A line for each scene and contender: see [`LEGEND`].
pub fn table(comparisons: &[Comparison]) -> Table {
    grid(comparisons).terminal()
}

/// What the columns of [`table`] are.
pub const LEGEND: &str = "n triangles: nanoseconds of the build, and divided by n log2 n; nanoseconds a ray in \
     each mode, and divided by log2 n";

/// As [`table`], for both forms.
pub(crate) fn grid(comparisons: &[Comparison]) -> Grid {
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
        lines: by_contender.map(line).collect(),
    }
}

fn line(rows: &[Row]) -> Vec<Cell> {
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
