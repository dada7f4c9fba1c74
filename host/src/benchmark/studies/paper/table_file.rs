//! The file `tables.csv`: tables 1 to 3 as measured, beside the paper's gains.
//!
//! A line for each scene, level and leaf capacity, in this order. The grids of a level stand in both of its lines.
//! There is no line where the paper prints nothing, at level 2 of 4(a) and 4(b).

use std::path::Path;

use serde::Serialize;

use super::protocol::{LEAF_CAPACITIES, ProtocolTable};
use crate::benchmark::harness::record::write_csv;

/// Line of the file.
#[derive(Clone, Debug, Serialize)]
struct Line {
    /// Name of the built-in scene.
    scene: &'static str,
    /// The highest level of the octrees.
    level: u32,
    /// The number of triangles up to which a cell of the octrees is not divided.
    leaf_capacity: u32,
    /// The cells on each axis of the grid in every cluster.
    grid: u32,
    /// Microseconds a photon, the median.
    octree_us_per_photon: f64,
    /// Microseconds a photon, the median.
    grid_us_per_photon: f64,
    /// Time saved by the octrees over the slower.
    gain_percent: f64,
    /// The paper's.
    paper_gain_percent: f64,
    /// Nodes visited for each ray, those of the cluster tree included.
    octree_nodes: f64,
    /// Triangles tested for each ray.
    octree_tests: f64,
    /// Cells visited for each ray, and nodes of the cluster tree.
    grid_nodes: f64,
    /// Triangles tested for each ray.
    grid_tests: f64,
    /// Bytes beside the triangles.
    octree_bytes: usize,
    /// Bytes beside the triangles.
    grid_bytes: usize,
}

/// Writes the tables to a file.
///
/// # Errors
/// If the file cannot be written.
pub fn write_tables(path: &Path, tables: &[ProtocolTable]) -> anyhow::Result<()> {
    let rows =
        tables.iter().flat_map(|table| table.rows.iter().map(|row| (table.printed.scene, row)));
    let lines = rows.flat_map(|(scene, row)| {
        let octrees = LEAF_CAPACITIES.into_iter().zip(&row.octrees).zip(row.gains());
        octrees.map(move |((leaf_capacity, octree), gain_percent)| Line {
            scene,
            level: row.printed.level,
            leaf_capacity,
            grid: row.printed.grid,
            octree_us_per_photon: octree.microseconds_per_photon(),
            grid_us_per_photon: row.grid.microseconds_per_photon(),
            gain_percent,
            paper_gain_percent: row.printed.gain_percent,
            octree_nodes: octree.nodes_per_ray(),
            octree_tests: octree.tests_per_ray(),
            grid_nodes: row.grid.nodes_per_ray(),
            grid_tests: row.grid.tests_per_ray(),
            octree_bytes: octree.subdivision_bytes,
            grid_bytes: row.grid.subdivision_bytes,
        })
    });
    write_csv(path, lines)
}
