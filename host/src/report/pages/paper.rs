//! Page about the paper's figures and tables.

use super::paper_words::{differences, reasons, saves_or_loses, verdict};
use super::separation::separation_section;
use crate::bench::measurement::Measurement;
use crate::bench::provenance::Provenance;
use crate::bench::summary::gain_percent;
use crate::report::html::{Page, signed_percent};
use crate::report::plot::{Plot, Scale, Series, Stroke};
use crate::studies::paper::figure3::{Figure3, HIERARCHY_LEVEL, PUBLISHED_GAIN, SINGLE_LEVEL};
use crate::studies::paper::tables::{LevelRow, SceneTable};
use crate::studies::separation::SeparationRow;

/// Measurements that the page shows.
pub struct PaperEvidence<'e> {
    /// Measurements of figure 3.
    pub figure3: &'e Figure3,
    /// Measurements of tables 1 to 3.
    pub tables: &'e [SceneTable],
    /// Measurements of figure 3 with its clusters at other distances.
    pub separation: &'e [SeparationRow],
    /// Machine, compiler and commit of the measurements.
    pub provenance: &'e Provenance,
    /// Command that repeats the measurements.
    pub command: &'e str,
}

/// Makes the page.
pub fn paper_page(evidence: &PaperEvidence<'_>) -> Page {
    let mut page = Page::new("The paper's figures and tables, measured again");
    page.paragraph(
        "N. Aguilera, J. Revelles, M. Lastra, R. Montes, R. J. García: Representaciones Espaciales Para Escenas \
         Constituidas Mediante Agrupaciones de Objetos. Every index gives the same hits, bit for bit; that was \
         checked on these rays before they were timed. Times are processor times of one thread: medians of \
         interleaved repetitions. A gain is the time saved, as a share of the slower index's time. It is above 0 where \
         the octrees or the hierarchy are faster.",
    );
    page.note(&format!("{}. {}", evidence.command, evidence.provenance.line()));
    summary(&mut page, evidence.tables);
    figure3_section(&mut page, evidence.figure3);
    page.heading("Tables 1 to 3: octree hierarchy against grid hierarchy of the same size");
    page.plots(&[
        gain_plot("Gain over grids of the same size", evidence.tables, LevelRow::gain),
        gain_plot(
            "Gain over grids as large as octrees with pointers",
            evidence.tables,
            LevelRow::pointer_gain,
        ),
        bytes_plot(evidence.tables),
    ]);
    for table in evidence.tables {
        scene_table(&mut page, table);
    }
    separation_section(&mut page, evidence.separation);
    page
}

/// Writes the seconds of a measurement for a million photons.
fn seconds_per_million(measurement: &Measurement) -> String {
    format!("{:.2}", measurement.microseconds_per_photon())
}

fn summary(page: &mut Page, tables: &[SceneTable]) {
    page.heading("Best against best");
    let rows: Vec<Vec<String>> = tables
        .iter()
        .filter_map(|table| {
            let (octree, grid) = (table.best_octree()?, table.best_grid()?);
            Some(vec![
                table.published.label.to_owned(),
                table.cluster_count.to_string(),
                format!("{:.2}", table.published.octree_seconds),
                format!("{:.2}", table.published.grid_seconds),
                signed_percent(table.published.gain()),
                seconds_per_million(&octree.octree),
                octree.level.to_string(),
                seconds_per_million(&grid.grid),
                grid.level.to_string(),
                signed_percent(table.best_gain()),
                verdict(table.best_gain(), table.published.gain()).to_owned(),
                signed_percent(table.best_pointer_gain()),
                verdict(table.best_pointer_gain(), table.published.gain()).to_owned(),
            ])
        })
        .collect();
    page.table(
        "Paper: seconds for its photons on its machine. Ours: seconds for a million photons.",
        &[
            "scene",
            "clusters",
            "paper: octrees",
            "paper: grids",
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

fn figure3_section(page: &mut Page, figure3: &Figure3) {
    page.heading("Figure 3: two distant clusters of cubes");
    let row = |one: &Measurement| {
        vec![
            one.case.kind.name().to_owned(),
            one.deepest_level.to_string(),
            format!("{:.0}", one.photons_per_second()),
            format!("{:.2}", one.nodes_per_ray()),
            format!("{:.1}", one.tests_per_ray()),
            one.bytes.to_string(),
            one.subdivision_bytes.to_string(),
        ]
    };
    let rows: Vec<_> = figure3.hierarchy.iter().chain(&figure3.single).map(row).collect();
    page.table(
        &format!(
            "With leaves of at most 12 triangles the hierarchy is finished at level {HIERARCHY_LEVEL}, the single \
             octree at level {SINGLE_LEVEL}"
        ),
        &["index", "level", "photons/s", "nodes/ray", "tests/ray", "bytes", "without triangles"],
        &rows,
    );
    if let Some((hierarchy, single)) = figure3.finished() {
        let most = figure3.gains().map(|(_, gain)| gain).fold(f64::NEG_INFINITY, f64::max);
        page.paragraph(&format!(
            "Level for level the hierarchy saves up to {most:.0}% of the time (the paper: up to {PUBLISHED_GAIN}%), and \
             it is finished at level {HIERARCHY_LEVEL} with {} bytes beside the triangles. The single octree needs level \
             {SINGLE_LEVEL} and {} bytes, {:.0} times as many. Both finished, the hierarchy visits {:.1} nodes and tests \
             {:.1} triangles a ray, the single octree {:.1} and {:.1}, and of the time the hierarchy {}. Level {SINGLE_LEVEL} \
             cuts the cubes apart, which saves tests, and an empty cell is not a node here: it is a bit that is not set, \
             and costs neither memory nor a visit.",
            hierarchy.subdivision_bytes,
            single.subdivision_bytes,
            single.subdivision_bytes as f64 / hierarchy.subdivision_bytes as f64,
            hierarchy.nodes_per_ray(),
            hierarchy.tests_per_ray(),
            single.nodes_per_ray(),
            single.tests_per_ray(),
            saves_or_loses(gain_percent(
                hierarchy.microseconds_per_photon(),
                single.microseconds_per_photon()
            )),
        ));
    }
    let line =
        |label: &str, colour, measured: &[Measurement], value: fn(&Measurement) -> f64| Series {
            label: label.to_owned(),
            colour,
            stroke: Stroke::Solid,
            points: measured.iter().map(|one| (f64::from(one.deepest_level), value(one))).collect(),
        };
    let plot = |title: &str, y_label: &str, value: fn(&Measurement) -> f64| Plot {
        title: title.to_owned(),
        x_label: "level".to_owned(),
        y_label: y_label.to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Logarithmic,
        x_ticks: level_ticks(SINGLE_LEVEL),
        series: vec![
            line("octree hierarchy", 0, &figure3.hierarchy, value),
            line("single octree", 1, &figure3.single, value),
        ],
    };
    page.plots(&[
        plot("Figure 3: time against level", "us per photon", Measurement::microseconds_per_photon),
        plot("Figure 3: memory against level", "bytes beside the triangles", |one| {
            one.subdivision_bytes as f64
        }),
    ]);
}

fn level_ticks(most: u32) -> Vec<(f64, String)> {
    (1..=most).map(|level| (f64::from(level), level.to_string())).collect()
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
        label: table.published.label.to_owned(),
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
        x_ticks: level_ticks(8),
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
            table.published.label, table.cluster_count
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
        x_ticks: level_ticks(8),
        series,
    };
    let label = table.published.label;
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
