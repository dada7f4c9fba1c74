//! Section of pages about the gain of a hierarchy against the separation of clusters.

use crate::benchmark::harness::plan::pairs;
use crate::benchmark::studies::separation::{GAPS, Gains, SeparationRow};
use crate::report::html::{Page, signed_percent};
use crate::report::plot::{Plot, Scale, Series, Stroke, number};

/// Coordinate of touching clusters, whose gap of 0 is not on a logarithmic axis.
const COORDINATE_OF_TOUCHING: f64 = 0.3;

/// Adds plots and a table of the gain of a hierarchy over a single index.
pub fn separation_section(page: &mut Page, rows: &[SeparationRow]) {
    page.heading("Gain against separation");
    page.paragraph(
        "Figure 3's clusters, from touching to 10,000 times their size apart. Every index is built with default \
         options, over the whole scene and in each cluster. Counters: nodes and tests, weighted by the cost model. \
         Memory: bytes beside the triangles, or all bytes of an index that stores triangles in its own form. Savings \
         are relative to the worse of the two; below 0 the hierarchy loses. Touching clusters form one cluster, so \
         nothing is gained.",
    );
    page.plots(&[
        plot(rows, "Time saved by the hierarchy", |gains| gains.time),
        plot(rows, "Cost by counters saved", |gains| gains.counters),
        plot(rows, "Memory saved", |gains| gains.memory),
    ]);
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let gains = row.gains();
            vec![
                row.single.case.kind.name().to_owned(),
                number(f64::from(row.gap)),
                number(row.single.photons_per_second()),
                number(row.clustered.photons_per_second()),
                signed_percent(gains.time),
                signed_percent(gains.counters),
                signed_percent(gains.memory),
                format!("{:.1}", row.single.nodes_per_ray()),
                format!("{:.1}", row.clustered.nodes_per_ray()),
                format!("{:.1}", row.single.tests_per_ray()),
                format!("{:.1}", row.clustered.tests_per_ray()),
                row.single.subdivision_bytes.to_string(),
                row.clustered.subdivision_bytes.to_string(),
            ]
        })
        .collect();
    page.table(
        "One index over the whole scene against one in each cluster; the gap is a multiple of a cluster's size",
        &[
            "index",
            "gap",
            "photons/s",
            "clustered",
            "time",
            "counters",
            "memory",
            "nodes/ray",
            "clustered",
            "tests/ray",
            "clustered",
            "bytes",
            "clustered",
        ],
        &cells,
    );
}

fn plot(rows: &[SeparationRow], title: &str, value: fn(Gains) -> f64) -> Plot {
    let coordinate = |gap: u32| if gap == 0 { COORDINATE_OF_TOUCHING } else { f64::from(gap) };
    let series = pairs().enumerate().map(|(colour, (single, _))| Series {
        label: single.name().to_owned(),
        colour,
        stroke: Stroke::Solid,
        points: rows
            .iter()
            .filter(|row| row.single.case.kind == single)
            .map(|row| (coordinate(row.gap), value(row.gains())))
            .collect(),
    });
    let ticks = GAPS.iter().filter(|gap| gap.to_string().trim_end_matches('0').len() <= 1);
    let label = |gap: u32| match gap {
        0 => "touching".to_owned(),
        gap => number(f64::from(gap)),
    };
    Plot {
        title: title.to_owned(),
        x_label: "gap, as a multiple of a cluster's size".to_owned(),
        y_label: "saved, %".to_owned(),
        x_scale: Scale::Logarithmic,
        y_scale: Scale::Linear,
        x_ticks: ticks
            .filter(|gap| !gap.to_string().starts_with('3'))
            .map(|&gap| (coordinate(gap), label(gap)))
            .collect(),
        series: series.collect(),
    }
}
