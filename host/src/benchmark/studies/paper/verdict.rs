//! How far a measured row agrees with the paper's, and why not further, by counters and by the time of a node and a
//! cell.
//!
//! The times of a ray, a node, a cell and a test are fitted to the rows of the same run. They say which node would give
//! the paper's gain: the grids' time and the paper's gain give the time that the octrees should take; what the ray and
//! its tests leave of it is for the nodes.
//!
//! Octrees with leaves of 12 triangles and grids stay in the caches, so the times are fitted to these. Octrees with
//! leaves of one triangle do not: at the deepest levels they have 140 MB, and take twice the time that their nodes and
//! tests say.

use super::protocol::{ProtocolRow, ProtocolTable};
use crate::benchmark::harness::measurement::Measurement;
use crate::benchmark::harness::summary::gain_percent;
use crate::benchmark::studies::weights::Weights;

/// Points of gain within which two gains count as the same.
pub const NEAR: f64 = 10.0;
/// Gain of the paper below which its sign decides nothing, in percent.
pub const UNDECIDED: f64 = 5.0;
/// Multiple of the grids' tests from which on the octrees' tests are a reason.
const MORE_TESTS: f64 = 1.05;
/// Multiple of the time by counters from which on an index is slowed down by something that is not counted.
const UNCOUNTED: f64 = 1.25;

/// Times of the parts of a query, in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub struct Costs {
    /// The octree hierarchy's.
    pub octree: Weights,
    /// The grid hierarchy's; a node is a cell.
    pub grid: Weights,
}

impl Costs {
    /// Fits the times to all grids, and to all octrees of the larger leaf capacity.
    pub fn fit(tables: &[ProtocolTable]) -> Self {
        let rows = || tables.iter().flat_map(|table| &table.rows);
        Self {
            octree: Weights::fit(rows().map(|row| &row.octrees[1])),
            grid: Weights::fit(rows().map(|row| &row.grid)),
        }
    }
}

/// Judgement of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// True if the octrees win where the paper's do.
    pub same_sign: bool,
    /// True if the paper's gain is too small for its sign to count.
    pub undecided: bool,
    /// Our gain less the paper's, in points.
    pub points: f64,
    /// Why it is not the same: `None` if the sign is, or does not count, and the gain is near.
    pub reason: Option<String>,
}

impl Verdict {
    /// Judges the octrees of one capacity, the first or the second.
    pub fn of(row: &ProtocolRow, which: usize, costs: &Costs) -> Self {
        let (gain, published) = (row.gains()[which], row.printed.gain_percent);
        let mut verdict = Self {
            same_sign: (gain > 0.0) == (published > 0.0),
            undecided: published.abs() < UNDECIDED,
            points: gain - published,
            reason: None,
        };
        if !verdict.agrees() {
            verdict.reason = Some(reason(row, &row.octrees[which], costs, verdict.points));
        }
        verdict
    }

    /// Tells whether the gain is within [`NEAR`] of the paper's.
    pub fn is_near(&self) -> bool {
        self.points.abs() <= NEAR
    }

    /// Tells whether the row says what the paper's says.
    pub fn agrees(&self) -> bool {
        self.is_near() && (self.same_sign || self.undecided)
    }

    /// Writes the judgement in a few words.
    pub fn words(&self) -> String {
        let sign = match (self.same_sign, self.undecided) {
            (true, _) => "same sign",
            (false, true) => "other sign, the paper's within 5%",
            (false, false) => "other sign",
        };
        let points = self.points.abs();
        match (self.is_near(), self.points > 0.0) {
            (true, _) => format!("{sign}, within 10"),
            (false, true) => format!("{sign}, {points:.0} more"),
            (false, false) => format!("{sign}, {points:.0} less"),
        }
    }
}

/// Returns the nanoseconds a ray that the octrees may take for a gain over the grids.
fn wanted(grid_nanoseconds: f64, gain: f64) -> f64 {
    let share = gain / 100.0;
    if share >= 0.0 { grid_nanoseconds * (1.0 - share) } else { grid_nanoseconds / (1.0 + share) }
}

fn nanoseconds(measured: &Measurement) -> f64 {
    measured.seconds.median / measured.ray_count as f64 * 1e9
}

/// Writes why a gain is not the paper's.
fn reason(row: &ProtocolRow, octree: &Measurement, costs: &Costs, points: f64) -> String {
    let (grid, printed) = (&row.grid, &row.printed);
    let (nodes, tests) = (octree.nodes_per_ray(), octree.tests_per_ray());
    let (cells, grid_tests) = (grid.nodes_per_ray(), grid.tests_per_ray());
    let wanted = wanted(nanoseconds(grid), printed.gain_percent);
    let of_tests = costs.octree.ray + tests * costs.octree.test;
    let (allowed, node) = ((wanted - of_tests) / nodes, costs.octree.node);
    let counted = format!(
        "{nodes:.1} nodes and {tests:.1} tests a ray against {cells:.1} cells and {grid_tests:.1} tests"
    );
    let [octree_by_counters, grid_by_counters] =
        [costs.octree.nanoseconds(nodes, tests), costs.grid.nanoseconds(cells, grid_tests)];
    let by_counters = gain_percent(octree_by_counters, grid_by_counters);
    let out_of_caches = |name: &str, one: &Measurement| {
        let megabytes = one.subdivision_bytes as f64 / 1e6;
        format!(
            "{counted}: by these {by_counters:+.0}%, but {name} of {megabytes:.0} MB leave the caches"
        )
    };
    if points < 0.0 {
        if nanoseconds(octree) > octree_by_counters * UNCOUNTED {
            return out_of_caches("octrees", octree);
        }
        let excess = (tests - grid_tests) * costs.octree.test;
        let missing = nanoseconds(octree) - wanted;
        if tests > grid_tests * MORE_TESTS && excess > missing * 0.5 {
            let capacity = octree.case.options.leaf_capacity;
            return match larger_cells(printed.level, printed.grid, capacity) {
                Some(why) => format!("{counted}: {why}"),
                None => format!("{counted}: the octree's tests make the difference"),
            };
        }
        return if allowed > 0.0 {
            let cell = costs.grid.node;
            format!(
                "{counted}: a node would have to take {allowed:.0} ns, not {node:.0}; a cell takes {cell:.0}"
            )
        } else {
            format!(
                "{counted}: not even a node that takes no time would do, {of_tests:.0} ns are for the ray and its tests"
            )
        };
    }
    if nanoseconds(grid) > grid_by_counters * UNCOUNTED {
        return out_of_caches("grids", grid);
    }
    if allowed > node {
        return format!(
            "{counted}: with the paper's gain a node would take {allowed:.0} ns, not {node:.0}"
        );
    }
    format!("{counted}: the octrees take {:.0} ns, less than counted", nanoseconds(octree))
}

/// Writes why an octree tests more triangles than a grid of the same box; `None` if its cells are no larger.
fn larger_cells(level: u32, grid: u32, leaf_capacity: u32) -> Option<String> {
    let cells = 1_u32 << level;
    if grid > cells {
        Some(format!("the grid has {grid} cells an axis, the octree at most {cells}"))
    } else if leaf_capacity > 1 {
        Some(format!(
            "the octree does not divide cells of {leaf_capacity} triangles, the grid does"
        ))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::harness::plan::Case;
    use crate::benchmark::harness::summary::Spread;
    use crate::benchmark::studies::paper::printed::PrintedRow;
    use arboleda::{Counters, IndexKind};

    const RAYS: u64 = 1_000;

    fn measured(kind: IndexKind, nanoseconds: f64, nodes: u64, tests: u64) -> Measurement {
        Measurement {
            case: Case::usual(kind),
            triangle_count: 1,
            build_seconds: 0.0,
            bytes: 2,
            subdivision_bytes: 1,
            cluster_count: 1,
            deepest_level: 1,
            photons: RAYS,
            ray_count: RAYS as usize,
            counters: Counters { nodes_visited: nodes * RAYS, triangle_tests: tests * RAYS },
            seconds: Spread::of(&[nanoseconds * RAYS as f64 * 1e-9]),
            repetitions: 1,
        }
    }

    /// A row in which a ray takes 20 ns, a node 50, a cell 30 and a test 10.
    fn row(level: u32, grid: u32, paper: f64, octree: [u64; 2], cells: [u64; 2]) -> ProtocolRow {
        let time = |[nodes, tests]: [u64; 2], node| (20 + nodes * node + tests * 10) as f64;
        let one = |_| measured(IndexKind::OctreeHierarchy, time(octree, 50), octree[0], octree[1]);
        ProtocolRow {
            printed: PrintedRow {
                level,
                grid,
                octree_seconds: 1.0,
                grid_seconds: 1.0,
                gain_percent: paper,
            },
            octrees: [1, 12].map(one),
            grid: measured(IndexKind::GridHierarchy, time(cells, 30), cells[0], cells[1]),
        }
    }

    const COSTS: Costs = Costs {
        octree: Weights { ray: 20.0, node: 50.0, test: 10.0, error: 0.0 },
        grid: Weights { ray: 20.0, node: 30.0, test: 10.0, error: 0.0 },
    };

    fn verdict(row: &ProtocolRow) -> Verdict {
        Verdict::of(row, 0, &COSTS)
    }

    #[test]
    fn a_row_that_agrees_needs_no_reason() {
        // 320 against 320 ns.
        let same = row(5, 20, 4.0, [4, 10], [5, 15]);
        assert_eq!(verdict(&same).reason, None);
        assert_eq!(verdict(&same).words(), "other sign, the paper's within 5%, within 10");
        // 320 against 400 ns.
        let faster = row(5, 20, 21.0, [4, 10], [6, 20]);
        assert_eq!(verdict(&faster).words(), "same sign, within 10");
        assert_eq!(verdict(&faster).reason, None);
    }

    #[test]
    fn reasons_name_what_would_give_the_papers_gain() {
        // 320 against 400 ns; the paper's octrees would take 200, which leaves (200 - 20 - 100) / 4 for a node.
        let slow_nodes = verdict(&row(6, 29, 50.0, [4, 10], [6, 20]));
        assert_eq!(slow_nodes.words(), "same sign, 30 less");
        assert!(
            slow_nodes
                .reason
                .unwrap()
                .ends_with("a node would have to take 20 ns, not 50; a cell takes 30")
        );
        // The paper's octrees would take 80 ns, and the tests alone take 120.
        let hopeless = verdict(&row(6, 29, 80.0, [4, 10], [6, 20]));
        assert!(hopeless.reason.unwrap().contains("120 ns are for the ray and its tests"));
        // 2,170 against 1,110 ns, by tests.
        let full = verdict(&row(3, 8, -14.0, [3, 200], [3, 100]));
        assert_eq!(full.words(), "same sign, 35 less");
        assert!(full.reason.unwrap().contains("does not divide cells of 12 triangles"));
        // 640 ns where the counters say 320 against 400: the paper's octrees would take 200.
        let mut large = row(8, 54, 50.0, [4, 10], [6, 20]);
        large.octrees[0].seconds = Spread::of(&[640e-9 * RAYS as f64]);
        large.octrees[0].subdivision_bytes = 11_000_000;
        assert!(
            verdict(&large)
                .reason
                .unwrap()
                .ends_with("by these +20%, but octrees of 11 MB leave the caches")
        );
        let fine = verdict(&row(2, 5, -14.0, [3, 200], [3, 100]));
        assert!(
            fine.reason.unwrap().ends_with("the grid has 5 cells an axis, the octree at most 4")
        );
        // The paper's octrees would take 800 ns: (800 - 120) / 4.
        let faster = verdict(&row(6, 29, -50.0, [4, 10], [6, 20]));
        assert_eq!(faster.words(), "other sign, 70 more");
        assert!(faster.reason.unwrap().ends_with("a node would take 170 ns, not 50"));
    }
}
