//! Section about tables 1 to 3 with grids of equal bytes.

use super::paper::{level_ticks, seconds_per_million};
use super::paper_words::{differences, reasons, verdict};
use crate::benchmark::harness::measurement::Measurement;
use crate::benchmark::studies::paper::equal_bytes_tables::{LEVELS, LevelRow, SceneTable};
use crate::report::html::{Page, signed_percent};
use crate::report::plot::{Plot, Scale, Series, Stroke};

/// Adds the section.
pub fn equal_bytes_section(page: &mut Page, tables: &[SceneTable]) {
    page.heading("The same question by bytes: grids of the size of the octrees");
    page.paragraph(
        "The paper's grids have the memory of its octrees. Here each grid has the bytes of our octree, with leaves of \
         up to 12 triangles: first as our octrees are stored, then as an octree with pointers would be.",
    );
    summary(page, tables);
    page.plots(&[
        gain_plot("Gain over grids of the same size", tables, LevelRow::gain),
        gain_plot(
            "Gain over grids as large as octrees with pointers",
            tables,
            LevelRow::pointer_gain,
        ),
        bytes_plot(tables),
    ]);
    for table in tables {
        scene_table(page, table);
    }
}

fn summary(page: &mut Page, tables: &[SceneTable]) {
    let rows: Vec<Vec<String>> = tables
        .iter()
        .filter_map(|table| {
            let (octree, grid) = (table.best_octree()?, table.best_grid()?);
            Some(vec![
                table.printed.label.to_owned(),
                table.cluster_count.to_string(),
                signed_percent(table.printed.best_gain()),
                seconds_per_million(&octree.octree),
                octree.level.to_string(),
                seconds_per_million(&grid.grid),
                grid.level.to_string(),
                signed_percent(table.best_gain()),
                verdict(table.best_gain(), table.printed.best_gain()).to_owned(),
                signed_percent(table.best_pointer_gain()),
                verdict(table.best_pointer_gain(), table.printed.best_gain()).to_owned(),
            ])
        })
        .collect();
    page.table(
        "Best against best, by bytes: seconds for a million photons",
        &[
            "scene",
            "clusters",
            "paper: gain",
            "octrees",
            "at level",
            "grids",
            "as large as level",
            "gain",
            "verdict",
            "gain over large grids",
            "verdict",
        ],
        &rows,
    );
    page.paragraph("Where ours differ from the paper's:");
    page.list(differences(tables));
    page.paragraph("Why:");
    page.list(reasons(tables));
}

fn gain_plot(title: &str, tables: &[SceneTable], gain: fn(&LevelRow) -> f64) -> Plot {
    level_plot(title, "time saved, %", Scale::Linear, tables, gain)
}

fn bytes_plot(tables: &[SceneTable]) -> Plot {
    level_plot("Memory of both", "bytes beside the triangles", Scale::Logarithmic, tables, |row| {
        row.octree.subdivision_bytes as f64
    })
}

fn level_plot(
    title: &str,
    y_label: &str,
    y_scale: Scale,
    tables: &[SceneTable],
    value: fn(&LevelRow) -> f64,
) -> Plot {
    let series = tables.iter().enumerate().map(|(colour, table)| Series {
        label: table.printed.label.to_owned(),
        colour,
        stroke: Stroke::Solid,
        points: table.rows.iter().map(|row| (f64::from(row.level), value(row))).collect(),
    });
    Plot {
        title: title.to_owned(),
        x_label: "octree level".to_owned(),
        y_label: y_label.to_owned(),
        x_scale: Scale::Linear,
        y_scale,
        x_ticks: level_ticks(*LEVELS.end()),
        series: series.collect(),
    }
}

fn scene_table(page: &mut Page, table: &SceneTable) {
    let row = |row: &LevelRow| {
        let (octree, grid, large) = (&row.octree, &row.grid, &row.pointer_grid);
        let [excess, large_excess] = row.excess_bytes_percent();
        let spread = |one: &Measurement| {
            let scale = one.photons as f64 / 1e6;
            format!("{:.2} to {:.2}", one.seconds.min / scale, one.seconds.max / scale)
        };
        vec![
            row.level.to_string(),
            seconds_per_million(octree),
            seconds_per_million(grid),
            signed_percent(row.gain()),
            seconds_per_million(large),
            signed_percent(row.pointer_gain()),
            spread(octree),
            spread(grid),
            spread(large),
            format!("{:.2}", octree.nodes_per_ray()),
            format!("{:.2}", grid.nodes_per_ray()),
            format!("{:.2}", large.nodes_per_ray()),
            format!("{:.1}", octree.tests_per_ray()),
            format!("{:.1}", grid.tests_per_ray()),
            format!("{:.1}", large.tests_per_ray()),
            octree.subdivision_bytes.to_string(),
            format!("{excess:.2}"),
            large.subdivision_bytes.to_string(),
            format!("{large_excess:.2}"),
            octree.photons.to_string(),
        ]
    };
    let rows: Vec<_> = table.rows.iter().map(row).collect();
    page.table(
        &format!(
            "Figure {}: seconds for a million photons, {} clusters",
            table.printed.label, table.cluster_count
        ),
        &[
            "level",
            "octrees",
            "grids",
            "gain",
            "large grids",
            "gain",
            "octrees, spread",
            "grids, spread",
            "large, spread",
            "nodes/ray",
            "grids",
            "large",
            "tests/ray",
            "grids",
            "large",
            "bytes beside triangles",
            "grids' excess, %",
            "large grids' bytes",
            "excess, %",
            "photons",
        ],
        &rows,
    );
    let line = |label: &str, colour, value: fn(&LevelRow) -> f64| Series {
        label: label.to_owned(),
        colour,
        stroke: Stroke::Solid,
        points: table.rows.iter().map(|row| (f64::from(row.level), value(row))).collect(),
    };
    let plot = |title: String, y_label: &str, series| Plot {
        title,
        x_label: "octree level; the grids have the same bytes".to_owned(),
        y_label: y_label.to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Logarithmic,
        x_ticks: level_ticks(*LEVELS.end()),
        series,
    };
    let label = table.printed.label;
    page.plots(&[
        plot(
            format!("Figure {label}: time against level"),
            "us per photon",
            vec![
                line("octrees", 0, |row| row.octree.microseconds_per_photon()),
                line("grids", 1, |row| row.grid.microseconds_per_photon()),
                line("large grids", 2, |row| row.pointer_grid.microseconds_per_photon()),
            ],
        ),
        plot(
            format!("Figure {label}: counters against level"),
            "per ray",
            vec![
                line("octrees, tests", 0, |row| row.octree.tests_per_ray()),
                line("grids, tests", 1, |row| row.grid.tests_per_ray()),
                line("large grids, tests", 2, |row| row.pointer_grid.tests_per_ray()),
                dashed(line("octrees, nodes", 0, |row| row.octree.nodes_per_ray())),
                dashed(line("grids, cells", 1, |row| row.grid.nodes_per_ray())),
                dashed(line("large grids, cells", 2, |row| row.pointer_grid.nodes_per_ray())),
            ],
        ),
    ]);
}

fn dashed(series: Series) -> Series {
    Series { stroke: Stroke::Dashed, ..series }
}
