//! Section about figure 3: a single octree over two distant clusters against one in each.

use super::paper::level_ticks;
use super::paper_words::saves_or_loses;
use crate::benchmark::harness::measurement::Measurement;
use crate::benchmark::harness::summary::gain_percent;
use crate::benchmark::studies::paper::figure3::{
    Figure3, HIERARCHY_LEVEL, PUBLISHED_GAIN, SINGLE_LEVEL,
};
use crate::benchmark::studies::paper::figure3_apart::{ApartRow, Finished, met};
use crate::report::html::{Page, signed_percent};
use crate::report::plot::{Plot, Scale, Series, Stroke, number};

/// Adds the section: level by level, then as the clusters move apart.
pub fn figure3_section(page: &mut Page, figure3: &Figure3, apart: &[ApartRow]) {
    page.heading("Figure 3: two distant clusters of cubes");
    levels(page, figure3);
    distances(page, apart);
}

fn levels(page: &mut Page, figure3: &Figure3) {
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
            "Clusters {} sizes apart. With leaves of at most 12 triangles the hierarchy is finished at level \
             {HIERARCHY_LEVEL}, the single octree at level {SINGLE_LEVEL}",
            number(figure3.gap)
        ),
        &["index", "level", "photons/s", "nodes/ray", "tests/ray", "bytes", "without triangles"],
        &rows,
    );
    if let Some((hierarchy, single)) = figure3.finished() {
        let most = figure3.gains().map(|(_, gain)| gain).fold(f64::NEG_INFINITY, f64::max);
        page.paragraph(&format!(
            "Level for level the hierarchy saves up to {most:.0}% of the time (the paper: up to {PUBLISHED_GAIN}%), \
             and it is finished at level {HIERARCHY_LEVEL} with {} bytes beside the triangles. The single octree needs \
             level {SINGLE_LEVEL} and {} bytes, {:.0} times as many. Both finished, the hierarchy visits {:.1} nodes \
             and tests {:.1} triangles a ray, the single octree {:.1} and {:.1}, and of the time the hierarchy {}. An \
             empty cell is not a node here: it is a bit that is not set, and costs neither memory nor a visit.",
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

fn distances(page: &mut Page, apart: &[ApartRow]) {
    page.paragraph(&format!(
        "Figure 3 again, with the clusters closer and further apart, each tree at the level at which no leaf has more \
         than 12 triangles. The paper saves up to {PUBLISHED_GAIN}%, with a single octree of level {SINGLE_LEVEL}. It \
         does not say how far the clusters are apart, nor which sides of a cell are halved. Its tables suggest every \
         side on every level, which keeps cells in proportion to the box of the scene; that is measured, and beside it \
         an octree that halves only the longest sides, so that its cells become nearly cubic. {}",
        outcome(apart)
    ));
    let line = |label: &str, colour, gain: fn(&ApartRow) -> Option<f64>| Series {
        label: label.to_owned(),
        colour,
        stroke: Stroke::Solid,
        points: apart.iter().filter_map(|row| Some((row.gap, gain(row)?))).collect(),
    };
    let ends = apart.first().zip(apart.last());
    let ends = ends.map(|(first, last)| [first, last].map(|row| row.gap));
    let published = Series {
        label: format!("the paper's {PUBLISHED_GAIN}%"),
        colour: 2,
        stroke: Stroke::Dashed,
        points: ends.into_iter().flatten().map(|gap| (gap, PUBLISHED_GAIN)).collect(),
    };
    page.plots(&[Plot {
        title: "Figure 3: gain at the levels needed, as the clusters move apart".to_owned(),
        x_label: "gap, as a multiple of a cluster's size".to_owned(),
        y_label: "time saved, %".to_owned(),
        x_scale: Scale::Logarithmic,
        y_scale: Scale::Linear,
        x_ticks: [1.0, 10.0, 100.0, 1_000.0, 10_000.0].map(|gap| (gap, number(gap))).to_vec(),
        series: vec![
            line("over an octree with nearly cubic cells", 0, |row| Some(row.cubic_gain())),
            line("over an octree with cells in proportion", 1, ApartRow::proportion_gain),
            published,
        ],
    }]);
    let cells = |row: &ApartRow| {
        let mut cells = vec![number(row.gap)];
        let tree = |one: &Finished| {
            let unfinished = if one.largest_leaf > 12 { "*" } else { "" };
            vec![
                format!("{}{unfinished}", one.figures.deepest_level),
                format!("{:.3}", one.figures.microseconds_per_photon()),
                format!("{:.1}", one.figures.nodes_per_ray()),
                format!("{:.1}", one.figures.tests_per_ray()),
                one.figures.subdivision_bytes.to_string(),
            ]
        };
        cells.extend(tree(&row.hierarchy));
        cells.extend(tree(&row.cubic));
        cells.push(signed_percent(row.cubic_gain()));
        match (&row.in_proportion, row.proportion_gain()) {
            (Some(single), Some(gain)) => {
                cells.extend(tree(single));
                cells.push(signed_percent(gain));
            }
            _ => cells.extend(vec![String::new(); 6]),
        }
        cells
    };
    page.table(
        "The hierarchy, a single octree with nearly cubic cells, one with cells in proportion to the scene. Nodes and \
         tests are per ray, times in microseconds a photon, bytes beside the triangles. *: some leaves have more than \
         12 triangles, because the division ends at 4,096 references a triangle",
        &[
            "gap", "level", "us", "nodes", "tests", "bytes",
            "nearly cubic: level", "us", "nodes", "tests", "bytes", "gain",
            "in proportion: level", "us", "nodes", "tests", "bytes", "gain",
        ],
        &apart.iter().map(cells).collect::<Vec<_>>(),
    );
}

/// Writes where the paper's gain is met, and why.
fn outcome(apart: &[ApartRow]) -> String {
    let mut said = Vec::new();
    if let Some((first, last)) = apart.first().zip(apart.last()) {
        said.push(format!(
            "Against an octree with nearly cubic cells the gain grows slowly, from {:.0}% at {} sizes to {:.0}% at {}. \
             In the clusters its cells are like those of the hierarchy, whatever the distance; a ray only pays the way \
             down from the root, {:.1} nodes instead of {:.1}, because an empty cell is not a node here.",
            first.cubic_gain(),
            number(first.gap),
            last.cubic_gain(),
            number(last.gap),
            last.cubic.figures.nodes_per_ray(),
            last.hierarchy.figures.nodes_per_ray(),
        ));
    }
    let same_level: Vec<(f64, f64)> = apart
        .iter()
        .filter_map(|row| {
            let level = row.in_proportion.as_ref()?.figures.deepest_level;
            (level == SINGLE_LEVEL).then_some((row.gap, row.proportion_gain()?))
        })
        .collect();
    let ended = "Cells in proportion are long and flat in the clusters: to cut cubes apart along the \
                 axis, the octree must cut them into slices across, which a ray visits one by one.";
    match met(apart) {
        Some(row) => said.push(format!(
            "{ended} The paper's gain is met at {} sizes, with {:.0}%.",
            number(row.gap),
            row.proportion_gain().unwrap_or(f64::NAN)
        )),
        None => said.push(format!("{ended} The paper's gain is not met.")),
    }
    for (gap, gain) in same_level {
        said.push(format!(
            "At {} sizes it needs the paper's level {SINGLE_LEVEL}, and the gain is {gain:.0}%.",
            number(gap)
        ));
    }
    said.join(" ")
}
