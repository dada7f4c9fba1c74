//! Sentences about the tables of equal bytes and the paper's: what agrees, what differs, and why.

use crate::benchmark::studies::paper::equal_bytes_tables::{
    DEEP_GAIN, LAST_LEVEL_OF_GRIDS, LevelRow, SceneTable,
};

/// Says whether a gain is at least the paper's.
pub fn verdict(gain: f64, published: f64) -> &'static str {
    if gain >= published { "at least the paper's" } else { "less than the paper's" }
}

/// Writes a gain as a verb and a percentage.
pub fn saves_or_loses(gain: f64) -> String {
    let what = if gain >= 0.0 { "saves" } else { "loses" };
    format!("{what} {:.1}%", gain.abs())
}

/// Writes one line for each scene: the levels at which grids or octrees are faster.
pub fn differences(tables: &[SceneTable]) -> Vec<String> {
    let line = |table: &SceneTable| {
        format!(
            "{}: against grids of the same size {}; against grids as large as octrees with pointers {}. The paper: \
             grids win levels 1 to {LAST_LEVEL_OF_GRIDS}, then octrees, by up to {DEEP_GAIN}%.",
            table.printed.label,
            who_wins(table, LevelRow::gain),
            who_wins(table, LevelRow::pointer_gain),
        )
    };
    tables.iter().map(line).collect()
}

fn who_wins(table: &SceneTable, gain: fn(&LevelRow) -> f64) -> String {
    let grids: Vec<String> =
        table.rows.iter().filter(|row| gain(row) < 0.0).map(|row| row.level.to_string()).collect();
    let grids = match grids.len() {
        0 => "grids win no level".to_owned(),
        all if all == table.rows.len() => "grids win every level".to_owned(),
        _ => format!("grids win levels {}", grids.join(", ")),
    };
    let deep = table.rows.iter().filter(|row| row.level > LAST_LEVEL_OF_GRIDS);
    let most = deep.map(gain).fold(f64::NEG_INFINITY, f64::max);
    match table.crossover(gain) {
        Some(level) => {
            format!("{grids}, octrees all from {level} on, at deep levels by up to {most:.0}%")
        }
        None => format!("{grids}; the best of the octrees at deep levels is {most:+.0}%"),
    }
}

/// Writes the reasons for the differences, from the counters.
pub fn reasons(tables: &[SceneTable]) -> Vec<String> {
    let mut points = vec![
        "Equal memory depends on how an octree is stored, which the paper does not say. Our octrees store a link to \
         each cell that is not empty, our grids a bit for each that is; both have contiguous lists. So a grid of the \
         same size has about the density at which grids are fastest. In an octree with pointers all eight children \
         exist, with eight links each, and lists are linked; a grid of that size has several times as many cells."
            .to_owned(),
    ];
    for table in tables {
        let (Some(first), Some(last)) = (table.rows.first(), table.rows.last()) else {
            continue;
        };
        let factor = last.pointer_bytes as f64 / last.octree.subdivision_bytes as f64;
        points.push(format!(
            "{}, level {}: {:.1} nodes and {:.1} tests a ray in the octrees; {:.1} and {:.1} in grids of the same \
             size; {:.1} and {:.1} in grids {factor:.1} times as large. {} Level {}: {:.0} tests in the octrees, {:.0} \
             in grids of the same size, {:.0} in large grids.",
            table.printed.label,
            last.level,
            last.octree.nodes_per_ray(),
            last.octree.tests_per_ray(),
            last.grid.nodes_per_ray(),
            last.grid.tests_per_ray(),
            last.pointer_grid.nodes_per_ray(),
            last.pointer_grid.tests_per_ray(),
            deepest_level(last),
            first.level,
            first.octree.tests_per_ray(),
            first.grid.tests_per_ray(),
            first.pointer_grid.tests_per_ray(),
        ));
    }
    points.push(first_level(tables));
    points
}

/// Writes the reasons at the deepest level.
fn deepest_level(last: &LevelRow) -> String {
    let mut said = Vec::new();
    if last.grid.tests_per_ray() < last.octree.tests_per_ray() {
        said.push(
            "Grids of the same size do fewer tests, because the octrees stop dividing at 12 triangles a leaf and the \
             grids do not.",
        );
    }
    if last.pointer_grid.nodes_per_ray() > last.grid.nodes_per_ray() {
        said.push("Large grids visit more cells.");
    }
    said.join(" ")
}

/// Writes the gains at the lowest level, with their reason.
fn first_level(tables: &[SceneTable]) -> String {
    let gains = |gain: fn(&LevelRow) -> f64| {
        let rows = tables.iter().filter_map(|table| Some((table, table.rows.first()?)));
        let each: Vec<String> = rows
            .map(|(table, row)| format!("{} {:+.0}%", table.printed.label, gain(row)))
            .collect();
        each.join(", ")
    };
    let level = tables.iter().find_map(|table| table.rows.first()).map_or(1, |row| row.level);
    format!(
        "At level {level} our octrees are so small that a grid of the same size has only a few cells. The gain of the \
         octrees at this level: {}. Over grids as large as octrees with pointers, which have more cells: {}. Where the \
         second gain is below the first, the crossover depends on the bytes of a node.",
        gains(LevelRow::gain),
        gains(LevelRow::pointer_gain),
    )
}
