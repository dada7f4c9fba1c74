//! Section about tables 1 to 3 as printed: the paper's numbers, ours, and a verdict for each row.

use super::paper::{level_ticks, seconds_per_million};
use crate::benchmark::studies::paper::printed::PrintedRow;
use crate::benchmark::studies::paper::protocol::{LEAF_CAPACITIES, ProtocolRow, ProtocolTable};
use crate::benchmark::studies::paper::verdict::{Costs, NEAR, UNDECIDED, Verdict};
use crate::report::html::{Page, signed_percent};
use crate::report::plot::{Plot, Scale, Series, Stroke};

/// Adds the section.
pub fn tables_section(page: &mut Page, tables: &[ProtocolTable]) {
    let costs = Costs::fit(tables);
    page.heading("Tables 1 to 3, as printed");
    page.paragraph(
        "Each row of the paper's tables names the level of the octrees and, as \"Nivel Grid\", the cells on each axis \
         of the grid in every cluster. Both are built here with exactly these numbers. Level 2 of 4(a) and 4(b) is \
         empty in the paper, so it has no row.",
    );
    page.paragraph(
        "The paper does not say how full a leaf may be in these tables; the 12 triangles of figure 3 belong to that \
         scene. Its grids have the memory of its octrees, and grow with every level by a factor of 2 to 5. With 12 \
         triangles a leaf an octree over a teapot stops growing at level 8, because no more than about six triangles \
         meet at a corner. Two meet along every edge, so with 1 triangle a leaf it goes on, as the paper's did. Both \
         are measured, on the same photons as the grids and in turns with them.",
    );
    best(page, tables);
    page.paragraph(&fitted(&costs));
    page.list(
        LEAF_CAPACITIES
            .iter()
            .enumerate()
            .map(|(which, capacity)| tally(tables, which, *capacity, &costs)),
    );
    page.paragraph(&same_cells(tables));
    page.plots(&tables.iter().map(gain_plot).collect::<Vec<_>>());
    for table in tables {
        gains(page, table, &costs);
        counters(page, table);
        page.paragraph(&format!("Figure {}, why rows differ:", table.printed.label));
        page.list(why(table, &costs));
    }
}

/// Writes the level of a crossover.
fn level(crossover: Option<u32>) -> String {
    crossover.map_or_else(|| "never".to_owned(), |level| level.to_string())
}

fn best(page: &mut Page, tables: &[ProtocolTable]) {
    let rows = tables.iter().filter_map(|table| {
        let printed = table.printed;
        let [octree, grid] = printed.best();
        let mut cells = vec![
            printed.label.to_owned(),
            table.cluster_count.to_string(),
            format!("{:.2} at {}", octree.octree_seconds, octree.level),
            format!("{:.2} at {}", grid.grid_seconds, grid.grid),
            format!("{:+.2}%", printed.best_gain()),
            level(printed.crossover()),
        ];
        for (at, (best, crossover)) in table.best()?.iter().zip(table.crossovers()).enumerate() {
            if at == 0 {
                cells.push(format!("{} at {}", seconds_per_million(best.grid), best.cells));
            }
            cells.extend([
                format!("{} at {}", seconds_per_million(best.octree), best.octree_level),
                signed_percent(best.gain()),
                level(crossover),
            ]);
        }
        Some(cells)
    });
    page.table(
        "Best against best: the fastest octrees at their level, the fastest grids at their cells on an axis. The \
         octrees win every level from the one given on. Paper: seconds for its photons; ours: seconds for a million \
         photons",
        &[
            "scene",
            "clusters",
            "paper: octrees",
            "grids",
            "gain",
            "from level",
            "ours: grids",
            "octrees, leaves of 1",
            "gain",
            "from level",
            "octrees, leaves of 12",
            "gain",
            "from level",
        ],
        &rows.collect::<Vec<_>>(),
    );
}

/// Writes the fitted times.
fn fitted(costs: &Costs) -> String {
    let Costs { octree, grid } = costs;
    format!(
        "Fitted to the rows of this run: an octree hierarchy with leaves of 12 takes {:.0} ns a ray, {:.0} ns a node \
         and {:.0} ns a test (within {:.0}%); a grid hierarchy {:.0} ns a ray, {:.0} ns a cell and {:.0} ns a test \
         (within {:.0}%). The reasons below are reckoned with these. Octrees with leaves of 1 take more than that at \
         deep levels, where they no longer fit into the caches.",
        octree.ray,
        octree.node,
        octree.test,
        octree.error * 100.0,
        grid.ray,
        grid.node,
        grid.test,
        grid.error * 100.0,
    )
}

/// Counts the rows that agree.
fn tally(tables: &[ProtocolTable], which: usize, capacity: u32, costs: &Costs) -> String {
    let rows = tables.iter().flat_map(|table| &table.rows);
    let verdicts: Vec<Verdict> = rows.map(|row| Verdict::of(row, which, costs)).collect();
    let count = |is: fn(&Verdict) -> bool| verdicts.iter().filter(|verdict| is(verdict)).count();
    format!(
        "Leaves of {capacity}: {} of {} rows have the paper's sign, {} more are undecided in the paper (within \
         {UNDECIDED:.0}% of zero); {} rows are within {NEAR:.0} points of the paper's gain.",
        count(|verdict| verdict.same_sign),
        verdicts.len(),
        count(|verdict| !verdict.same_sign && verdict.undecided),
        count(Verdict::is_near),
    )
}

fn gain_plot(table: &ProtocolTable) -> Plot {
    let line = |label: &str, colour, stroke, value: fn(&ProtocolRow) -> f64| Series {
        label: label.to_owned(),
        colour,
        stroke,
        points: table.rows.iter().map(|row| (f64::from(row.printed.level), value(row))).collect(),
    };
    Plot {
        title: format!("Figure {}: gain against level", table.printed.label),
        x_label: "octree level".to_owned(),
        y_label: "time saved by octrees, %".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        x_ticks: level_ticks(table.rows.last().map_or(1, |row| row.printed.level)),
        series: vec![
            line("the paper", 2, Stroke::Dashed, |row| row.printed.gain_percent),
            line("ours, leaves of 1", 0, Stroke::Solid, |row| row.gains()[0]),
            line("ours, leaves of 12", 1, Stroke::Solid, |row| row.gains()[1]),
        ],
    }
}

fn gains(page: &mut Page, table: &ProtocolTable, costs: &Costs) {
    let cells = |row: &ProtocolRow| {
        let PrintedRow { level, grid, octree_seconds, grid_seconds, gain_percent } = row.printed;
        let mut cells = vec![
            level.to_string(),
            grid.to_string(),
            format!("{octree_seconds:.2}"),
            format!("{grid_seconds:.2}"),
            format!("{gain_percent:+.2}%"),
            seconds_per_million(&row.grid),
        ];
        for (which, (octree, gain)) in row.octrees.iter().zip(row.gains()).enumerate() {
            cells.extend([
                seconds_per_million(octree),
                signed_percent(gain),
                Verdict::of(row, which, costs).words(),
            ]);
        }
        cells
    };
    page.table(
        &format!(
            "Figure {}, {} clusters: times and gains. Paper: seconds for its photons; ours: seconds for a million \
             photons. The verdict is on our gain and the paper's: the same sign, and within {NEAR:.0} points or how \
             many more or less",
            table.printed.label, table.cluster_count
        ),
        &[
            "level",
            "grid",
            "paper: octrees",
            "grids",
            "gain",
            "ours: grids",
            "octrees, leaves of 1",
            "gain",
            "verdict",
            "octrees, leaves of 12",
            "gain",
            "verdict",
        ],
        &table.rows.iter().map(cells).collect::<Vec<_>>(),
    );
}

fn counters(page: &mut Page, table: &ProtocolTable) {
    let cells = |row: &ProtocolRow| {
        let mut cells = vec![row.printed.level.to_string(), row.printed.grid.to_string()];
        for one in [&row.grid].into_iter().chain(&row.octrees) {
            cells.extend([
                format!("{:.2}", one.nodes_per_ray()),
                format!("{:.1}", one.tests_per_ray()),
                one.subdivision_bytes.to_string(),
            ]);
        }
        cells.extend([row.grid.photons.to_string(), row.grid.ray_count.to_string()]);
        cells
    };
    page.table(
        &format!(
            "Figure {}: counters. Nodes, cells and tests are per ray, not per photon; nodes of the cluster tree are \
             included. Bytes are beside the triangles",
            table.printed.label
        ),
        &[
            "level",
            "grid",
            "grids: cells",
            "tests",
            "bytes",
            "leaves of 1: nodes",
            "tests",
            "bytes",
            "leaves of 12: nodes",
            "tests",
            "bytes",
            "photons",
            "rays",
        ],
        &table.rows.iter().map(cells).collect::<Vec<_>>(),
    );
}

/// Writes the tests at the levels at which grids have the same number of cells on an axis as octrees.
fn same_cells(tables: &[ProtocolTable]) -> String {
    let mut said = Vec::new();
    for table in tables {
        let same = table.rows.iter().filter(|row| row.printed.grid == 1 << row.printed.level);
        let each = same.map(|row| {
            let ratio = row.octrees[0].tests_per_ray() / row.grid.tests_per_ray();
            let PrintedRow { level, gain_percent, .. } = row.printed;
            format!("{ratio:.2} at level {level} (paper: {gain_percent:+.1}%)")
        });
        said.push(format!("{} {}", table.printed.label, each.collect::<Vec<_>>().join(", ")));
    }
    format!(
        "Every side of a cell is halved on every level, so octrees and grids of a cluster divide the same box. At \
         levels 1 and 3 the printed grids have as many cells on an axis as the octrees, 2 and 8: the cells are the \
         same, and so are the tests, but for empty cells that are not divided. The paper's octrees lose little there, \
         so their cells most likely had the proportions of the box, too. Tests of our octrees as a multiple of the \
         grids': {}.",
        said.join("; ")
    )
}

/// Writes a line for each row that does not agree, one for both capacities where they have the same reason; or one that
/// all agree.
fn why(table: &ProtocolTable, costs: &Costs) -> Vec<String> {
    let mut lines = Vec::new();
    for row in &table.rows {
        let level = row.printed.level;
        let line = |leaves: &str, verdict: &Verdict| {
            let reason = verdict.reason.as_ref()?;
            Some(format!("Level {level}, leaves of {leaves} ({}): {reason}.", verdict.words()))
        };
        let [one, twelve] = [0, 1].map(|which| Verdict::of(row, which, costs));
        let [few, many] = LEAF_CAPACITIES.map(|capacity| capacity.to_string());
        if one.reason == twelve.reason && one.words() == twelve.words() {
            lines.extend(line(&format!("{few} and of {many}"), &one));
        } else {
            lines.extend([line(&few, &one), line(&many, &twelve)].into_iter().flatten());
        }
    }
    if lines.is_empty() {
        lines.push("None does: all have the paper's sign and are near its gain.".to_owned());
    }
    lines
}
