//! The page that compares all indices.

use std::path::Path;

use arboleda::IndexKind;

use super::separation::separation_section;
use crate::benchmark::harness::measurement::Measurement;
use crate::benchmark::harness::provenance::Provenance;
use crate::benchmark::studies::growth::{FAMILIES, GrowthRow};
use crate::benchmark::studies::indices::SceneComparison;
use crate::benchmark::studies::levels::LevelCheck;
use crate::benchmark::studies::separation::SeparationRow;
use crate::report::html::{Page, signed_percent};
use crate::report::plot::{Plot, Scale, Series, Stroke, number};

/// All that the page shows.
pub struct CompareEvidence<'e> {
    /// Every index on every scene.
    pub scenes: &'e [SceneComparison],
    /// The same kinds of scene in several sizes.
    pub growth: &'e [GrowthRow],
    /// Clusters that move apart.
    pub separation: &'e [SeparationRow],
    /// The automatic choices against all others.
    pub levels: &'e [LevelCheck],
    /// A picture of the clusters of each scene, and a line about it.
    pub pictures: &'e [(&'e Path, String)],
    /// Provenance of the figures.
    pub provenance: &'e Provenance,
    /// The command that gives them again.
    pub command: &'e str,
}

/// Writes the page. Sections without figures are left out.
///
/// # Errors
/// If a picture cannot be read.
pub fn compare_page(evidence: &CompareEvidence<'_>) -> anyhow::Result<Page> {
    let mut page = Page::new("Every index on every scene");
    page.paragraph(
        "Every index gives the same hits, bit for bit: checked on these rays before they were timed, and against the \
         linear scan on a share of them. Times are processor times of one thread, medians of repetitions that take \
         turns. All rows are kept, also those in which clusters lose.",
    );
    page.note(&format!("{}. {}", evidence.command, evidence.provenance.line()));
    if !evidence.pictures.is_empty() {
        page.heading("Clusters");
        page.pictures(evidence.pictures.iter().map(|(path, line)| (*path, line.clone())))?;
    }
    if !evidence.scenes.is_empty() {
        scenes_section(&mut page, evidence.scenes);
    }
    if !evidence.scenes.is_empty() {
        selection_section(&mut page, evidence.scenes);
    }
    if !evidence.growth.is_empty() {
        growth_section(&mut page, evidence.growth);
    }
    if !evidence.levels.is_empty() {
        levels_section(&mut page, evidence.levels);
    }
    if !evidence.separation.is_empty() {
        separation_section(&mut page, evidence.separation);
    }
    Ok(page)
}

fn scenes_section(page: &mut Page, scenes: &[SceneComparison]) {
    page.heading("Photons per second");
    let mut headings = vec!["index"];
    headings.extend(scenes.iter().map(|scene| scene.scene.as_str()));
    let overview = |value: &dyn Fn(&Measurement) -> String| -> Vec<Vec<String>> {
        IndexKind::ALL
            .iter()
            .enumerate()
            .map(|(at, kind)| {
                let cells = scenes.iter().map(|scene| value(&scene.measured[at]));
                std::iter::once(kind.name().to_owned()).chain(cells).collect()
            })
            .collect()
    };
    page.table(
        "Thousand photons per second",
        &headings,
        &overview(&|one| {
            let thousands = one.photons_per_second() / 1e3;
            if thousands < 100.0 { format!("{thousands:.1}") } else { format!("{thousands:.0}") }
        }),
    );
    page.table(
        "Bytes per triangle, with all that answering needs",
        &headings,
        &overview(&|one| format!("{:.0}", one.bytes as f64 / one.triangle_count as f64)),
    );
    for scene in scenes {
        let triangles = scene.measured.first().map_or(0, |one| one.triangle_count);
        let rows: Vec<Vec<String>> =
            scene.measured.iter().map(|one| scene_row(scene, one)).collect();
        page.table(
            &format!("{}: {triangles} triangles", scene.scene),
            &[
                "index",
                "build, ms",
                "bytes",
                "photons/s",
                "rays/s",
                "times the fastest",
                "spread",
                "nodes/ray",
                "tests/ray",
                "clusters",
                "level",
                "photons",
            ],
            &rows,
        );
    }
}

fn scene_row(scene: &SceneComparison, one: &Measurement) -> Vec<String> {
    vec![
        one.case.kind.name().to_owned(),
        format!("{:.1}", one.build_seconds * 1e3),
        one.bytes.to_string(),
        format!("{:.0}", one.photons_per_second()),
        format!("{:.0}", one.rays_per_second()),
        format!("{:.2}", scene.times_fastest(one)),
        format!(
            "{:.2} to {:.2}",
            one.seconds.min / one.seconds.median,
            one.seconds.max / one.seconds.median
        ),
        format!("{:.1}", one.nodes_per_ray()),
        format!("{:.1}", one.tests_per_ray()),
        one.cluster_count.to_string(),
        one.deepest_level.to_string(),
        one.photons.to_string(),
    ]
}

fn selection_section(page: &mut Page, scenes: &[SceneComparison]) {
    page.heading("How good the automatic selection is");
    page.paragraph(
        "Each index is built, tried on some rays and weighed by what a ray, a node and a test of it were once \
         measured to take; the cheapest is chosen. The rays are a sample that the core makes of the scene's \
         triangles, or those of the first photons. Gain: below 0 by how many rays per second \
         fewer than the fastest of all it answers, in percent of the fastest.",
    );
    let rows: Vec<Vec<String>> = scenes
        .iter()
        .map(|scene| {
            let rate = |one: Option<&Measurement>| {
                format!("{:.0}", one.map_or(0.0, Measurement::rays_per_second))
            };
            let (by_sample, by_rays) = (&scene.by_sample, &scene.by_rays);
            let fastest = scene.fastest();
            vec![
                scene.scene.clone(),
                by_sample.kind().name().to_owned(),
                rate(scene.of(by_sample.kind())),
                signed_percent(-scene.loss_percent(by_sample)),
                by_rays.kind().name().to_owned(),
                rate(scene.of(by_rays.kind())),
                signed_percent(-scene.loss_percent(by_rays)),
                fastest.map_or("", |one| one.case.kind.name()).to_owned(),
                rate(fastest),
            ]
        })
        .collect();
    page.table(
        "Chosen by the scene's sample, by the photons' rays, and the fastest measured",
        &[
            "scene",
            "by a sample",
            "rays/s",
            "gain",
            "by photons",
            "rays/s",
            "gain",
            "fastest",
            "rays/s",
        ],
        &rows,
    );
    page.paragraph("In the words of the selection, by the photons' rays:");
    page.list(scenes.iter().map(|scene| format!("{}: {}", scene.scene, scene.by_rays)));
}

fn growth_section(page: &mut Page, growth: &[GrowthRow]) {
    page.heading("Cost against triangle count");
    page.list(FAMILIES.iter().map(|family| format!("{}: {}", family.name, family.description)));
    for family in &FAMILIES {
        let rows: Vec<&GrowthRow> = growth.iter().filter(|row| row.family == family.name).collect();
        let plot = |what: &str, y_label: &str, value: fn(&Measurement) -> f64| {
            let series = (0..rows.first().map_or(0, |row| row.measured.len())).map(|at| {
                let points = rows.iter().map(|row| {
                    let one = &row.measured[at];
                    (one.triangle_count as f64, value(one))
                });
                let kind = rows[0].measured[at].case.kind;
                line(kind, points.collect())
            });
            Plot {
                title: format!("{}: {what}", family.name),
                x_label: "triangles".to_owned(),
                y_label: y_label.to_owned(),
                x_scale: Scale::Logarithmic,
                y_scale: Scale::Logarithmic,
                x_ticks: Vec::new(),
                series: series.collect(),
            }
        };
        page.plots(&[
            plot("time", "us per photon", Measurement::microseconds_per_photon),
            plot("nodes and tests", "per ray", |one| one.nodes_per_ray() + one.tests_per_ray()),
            plot("memory", "bytes per triangle", |one| {
                one.bytes as f64 / one.triangle_count as f64
            }),
            plot("build", "us per triangle", |one| {
                one.build_seconds * 1e6 / one.triangle_count as f64
            }),
        ]);
    }
}

/// Simple indices solid, their hierarchies dashed in the same colour.
fn line(kind: IndexKind, points: Vec<(f64, f64)>) -> Series {
    let colour = IndexKind::ALL
        .iter()
        .take_while(|&&other| other != kind)
        .filter(|other| !other.is_clustered())
        .count();
    let (colour, stroke) =
        if kind.is_clustered() { (colour - 1, Stroke::Dashed) } else { (colour, Stroke::Solid) };
    Series { label: kind.name().to_owned(), colour, stroke, points }
}

fn levels_section(page: &mut Page, levels: &[LevelCheck]) {
    page.heading("How good the automatic choices are");
    page.paragraph(
        "Levels from 0 to 12 and 18 densities of cells were tried, until one cost 1.5 times the cheapest before it; \
         the four cheapest were timed. Cost: nodes and tests a ray, weighted by the index's cost model. Gain: below 0 \
         where the automatic choice costs more than the best of all, in percent of the best; above 0 where it is \
         better than all others. Times take turns, and the gain is the median over the rounds. With a level given, \
         leaves hold up to 12 triangles; automatic kd-trees divide as long as it pays, and may cost less than any \
         level.",
    );
    let choice = |one: &Measurement| match one.case.setting.strip_suffix(" cells per triangle") {
        Some(density) => density.to_owned(),
        None => one.deepest_level.to_string(),
    };
    let rows: Vec<Vec<String>> = levels
        .iter()
        .map(|check| {
            let (cheapest, fastest) = (check.best_by_counters(), check.best_by_time());
            vec![
                format!("{} {}", check.scene, check.automatic.case.kind.name()),
                check.automatic.deepest_level.to_string(),
                format!("{:.2}", check.automatic.cost_per_ray()),
                number(check.automatic.subdivision_bytes as f64),
                choice(cheapest),
                format!("{:.2}", cheapest.cost_per_ray()),
                number(cheapest.subdivision_bytes as f64),
                signed_percent(-check.excess_cost()),
                choice(fastest),
                number(fastest.subdivision_bytes as f64),
                signed_percent(-check.excess_time()),
            ]
        })
        .collect();
    page.table(
        "Automatic, best by counters, best by time; the best are given as level or cells per triangle",
        &[
            "scene, index", "level", "cost/ray", "bytes", "cheapest", "cost/ray", "bytes", "gain, cost",
            "fastest", "bytes", "gain, time",
        ],
        &rows,
    );
}
