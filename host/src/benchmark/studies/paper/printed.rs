//! The paper's tables 1 to 3, as printed.
//!
//! Each row has the level of the octrees, the cells on each axis of every grid ("Nivel Grid"), the seconds of both, and
//! the gain. At level 2 the tables of 4(a) and 4(b) are empty, so these have no such row.
//!
//! # Source
//! N. Aguilera, J. Revelles, M. Lastra, R. Montes, R. J. García, *Representaciones Espaciales Para Escenas
//! Constituidas Mediante Agrupaciones de Objetos*, tables 1 to 3.

use crate::benchmark::harness::summary::gain_percent;

/// Row of a table: octrees of one level against grids of one subdivision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintedRow {
    /// The highest level of the octrees.
    pub level: u32,
    /// The cells on each axis of the grid in every cluster.
    pub grid: u32,
    /// Time of the octree hierarchy.
    pub octree_seconds: f64,
    /// Time of the grid hierarchy.
    pub grid_seconds: f64,
    /// Time that the octrees save over the slower of the two, in percent, as printed.
    pub gain_percent: f64,
}

/// Table of one scene of figure 4.
#[derive(Clone, Copy, Debug)]
pub struct PrintedTable {
    /// Name of the built-in scene.
    pub scene: &'static str,
    /// Name in the paper.
    pub label: &'static str,
    /// The rows, from the lowest level on.
    pub rows: &'static [PrintedRow],
}

impl PrintedTable {
    /// Returns the row with the fastest octrees, and the row with the fastest grids.
    ///
    /// # Panics
    /// Never: no table is empty.
    pub fn best(&self) -> [&PrintedRow; 2] {
        [|row: &PrintedRow| row.octree_seconds, |row: &PrintedRow| row.grid_seconds].map(|time| {
            let best = self.rows.iter().min_by(|a, b| time(a).total_cmp(&time(b)));
            best.expect("no table is empty")
        })
    }

    /// Compares the best with the best: the time saved by octrees, in percent.
    pub fn best_gain(&self) -> f64 {
        let [octree, grid] = self.best();
        gain_percent(octree.octree_seconds, grid.grid_seconds)
    }

    /// Returns the lowest level from which on the octrees are always ahead.
    pub fn crossover(&self) -> Option<u32> {
        crossover(self.rows.iter().map(|row| (row.level, row.gain_percent)))
    }
}

/// Returns the lowest level from which on all gains are above 0. Pairs of level and gain, the lowest level first.
pub fn crossover(gains: impl DoubleEndedIterator<Item = (u32, f64)>) -> Option<u32> {
    gains.rev().take_while(|&(_, gain)| gain > 0.0).last().map(|(level, _)| level)
}

const fn row(
    level: u32,
    grid: u32,
    octree_seconds: f64,
    grid_seconds: f64,
    gain_percent: f64,
) -> PrintedRow {
    PrintedRow { level, grid, octree_seconds, grid_seconds, gain_percent }
}

/// Tables 1 to 3, scene by scene.
pub const PRINTED: [PrintedTable; 5] = [
    PrintedTable {
        scene: "fig4a",
        label: "4(a)",
        rows: &[
            row(1, 2, 2727.17, 2540.46, -6.85),
            row(3, 8, 264.77, 222.55, -15.95),
            row(4, 14, 107.53, 110.89, 3.03),
            row(5, 22, 63.16, 80.58, 21.62),
            row(6, 37, 51.55, 70.25, 26.62),
            row(7, 60, 52.37, 81.46, 35.71),
            row(8, 102, 59.98, 118.00, 49.17),
            row(9, 176, 75.87, 197.55, 61.59),
        ],
    },
    PrintedTable {
        scene: "fig4b",
        label: "4(b)",
        rows: &[
            row(1, 2, 2204.75, 2116.47, -4.00),
            row(3, 8, 216.28, 185.05, -14.44),
            row(4, 13, 90.93, 103.28, 11.96),
            row(5, 20, 56.17, 73.61, 23.69),
            row(6, 29, 46.84, 66.05, 29.08),
            row(7, 40, 45.18, 65.53, 31.05),
            row(8, 54, 45.82, 75.58, 39.38),
            row(9, 71, 47.13, 87.87, 46.36),
            row(10, 94, 48.14, 107.53, 55.23),
            row(11, 133, 50.04, 143.95, 65.24),
        ],
    },
    PrintedTable {
        scene: "fig4c",
        label: "4(c)",
        rows: &[
            row(1, 2, 1802.86, 1738.97, -3.54),
            row(2, 5, 557.85, 329.65, -40.91),
            row(3, 8, 184.23, 157.48, -14.52),
            row(4, 12, 81.65, 96.28, 15.20),
            row(5, 19, 53.78, 69.23, 22.32),
            row(6, 28, 46.54, 63.12, 26.27),
            row(7, 37, 44.97, 65.39, 31.23),
            row(8, 49, 45.70, 72.42, 36.90),
            row(9, 64, 46.57, 84.20, 44.69),
            row(10, 85, 47.41, 102.61, 53.80),
            row(11, 121, 48.98, 137.26, 64.32),
        ],
    },
    PrintedTable {
        scene: "fig4d",
        label: "4(d)",
        rows: &[
            row(1, 2, 909.22, 866.77, -4.67),
            row(2, 5, 239.71, 153.28, -36.06),
            row(3, 8, 90.05, 82.02, -8.92),
            row(4, 12, 49.07, 57.95, 15.32),
            row(5, 18, 37.32, 47.63, 21.65),
            row(6, 26, 34.36, 47.02, 26.92),
            row(7, 35, 33.87, 49.76, 31.93),
            row(8, 47, 33.39, 55.97, 40.34),
            row(9, 62, 34.38, 65.44, 47.46),
            row(10, 85, 34.79, 81.35, 57.23),
        ],
    },
    PrintedTable {
        scene: "fig4e",
        label: "4(e)",
        rows: &[
            row(1, 2, 1956.44, 1561.63, -20.18),
            row(2, 5, 650.12, 338.37, -47.95),
            row(3, 8, 243.60, 179.89, -26.15),
            row(4, 14, 129.11, 109.49, -15.20),
            row(5, 21, 102.24, 95.92, -6.18),
            row(6, 29, 97.05, 97.29, 0.25),
            row(7, 40, 99.16, 107.42, 7.69),
            row(8, 52, 101.36, 123.40, 17.86),
            row(9, 69, 104.91, 153.13, 31.49),
            row(10, 98, 106.59, 207.65, 48.67),
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Gains have two digits after the point: a unit of the last is 0.01.
    const LAST_DIGIT: f64 = 0.01;

    #[test]
    fn printed_gains_follow_from_printed_times() {
        for table in PRINTED {
            for row in table.rows {
                let gain = gain_percent(row.octree_seconds, row.grid_seconds);
                let off = (gain - row.gain_percent).abs();
                assert!(off < LAST_DIGIT, "{} level {}: {gain}", table.label, row.level);
            }
        }
    }

    #[test]
    fn levels_and_grids_ascend_without_a_gap_but_level_2() {
        for table in PRINTED {
            let levels: Vec<u32> = table.rows.iter().map(|row| row.level).collect();
            let last = *levels.last().unwrap();
            let absent: Vec<u32> = (1..=last).filter(|level| !levels.contains(level)).collect();
            let expected: &[u32] = if ["4(a)", "4(b)"].contains(&table.label) { &[2] } else { &[] };
            assert_eq!(absent, expected, "{}", table.label);
            assert!(levels.is_sorted() && table.rows.is_sorted_by(|a, b| a.grid < b.grid));
            // Level 1 halves each axis, level 3 does it three times; so do the grids beside them.
            for row in table.rows.iter().filter(|row| [1, 3].contains(&row.level)) {
                assert_eq!(row.grid, 1 << row.level);
            }
        }
        assert_eq!(PRINTED.map(|table| table.rows.len()), [8, 10, 11, 10, 10]);
    }

    /// The figures that the paper's text and summary name.
    #[test]
    fn the_best_rows_are_those_of_the_text() {
        let best = PRINTED.map(|table| {
            let [octree, grid] = table.best();
            (octree.octree_seconds, grid.grid_seconds, (table.best_gain() * 10.0).round() / 10.0)
        });
        let expected = [
            (51.55, 70.25, 26.6),
            (45.18, 65.53, 31.1),
            (44.97, 63.12, 28.8),
            (33.39, 47.02, 29.0),
            (97.05, 95.92, -1.2),
        ];
        assert_eq!(best, expected);
        let crossovers = PRINTED.map(|table| table.crossover());
        assert_eq!(crossovers, [Some(4), Some(4), Some(4), Some(4), Some(6)]);
    }
}
