//! Choice of the number of cells: as the options say, or those with which some rays cost least.
//!
//! ```text
//! a grid of usual density -> where some rays end -> for each density: file, count, walk to the end -> the cheapest
//! ```
//! # Source
//! J. Cleary, G. Wyvill 1988: as many cubic cells as a constant times the triangles; the constant is found.

use core::ops::ControlFlow;

use super::walk::walk;
use super::{Grid, MOST_CELLS_ON_AXIS, UniformGrid, cell_count, triangles_of};
use crate::cost::{Probe, ProbeRay, search_steps};
use crate::error::BuildError;
use crate::geometry::Aabb;
use crate::input::{CostModel, Options, Resolution};
use crate::memory::Words;
use crate::query::Query;
use crate::structure::{Group, Local, LocalIndex};

/// Densities tried by the automatic resolution, in cells per triangle, from here on a factor of
/// `DENSITY_STEP` apart. With a factor of 2, figure 2 cost 15% more.
const LEAST_DENSITY: f64 = 1.0 / 512.0;
const MOST_DENSITY: f64 = 16.0;
const DENSITY_STEP: f64 = core::f64::consts::SQRT_2;
/// The search ends where a grid costs so many times the cheapest before it. With 1.5, some samples of 64 rays ended
/// it too early on the flat scenes 4(a) and 4(d), with a grid that cost 20 times the best.
const HOPELESS: f64 = 2.0;

/// Nearly cubic cells, `density` for each triangle: one only on an axis where the box is flat.
fn cells_for(bounds: &Aabb, triangle_count: usize, density: f64) -> [u32; 3] {
    let extent = bounds.extent();
    let wanted = (density * triangle_count as f64).max(1.0);
    let longest = extent.into_iter().fold(0.0, |a: f64, b| if b > a { b } else { a });
    if longest <= 0.0 {
        return [1; 3];
    }
    // Axes thinner than a cell get one; the others share the rest.
    let mut thick = extent.map(|side| side > 0.0);
    let mut side_of_cell = longest;
    for _ in 0..3 {
        let mut volume = 1.0;
        let mut dimension = 0;
        for axis in 0..3 {
            if thick[axis] {
                volume *= extent[axis] / longest;
                dimension += 1;
            }
        }
        side_of_cell = longest
            * match dimension {
                3 => libm::cbrt(volume / wanted),
                2 => libm::sqrt(volume / wanted),
                _ => volume / wanted,
            };
        for axis in 0..3 {
            thick[axis] &= extent[axis] > side_of_cell;
        }
    }
    extent.map(|side| ((side / side_of_cell) as u32).clamp(1, MOST_CELLS_ON_AXIS))
}

const fn cells_on_axis(asked_for: u32) -> u32 {
    match asked_for {
        0 => 1,
        1..MOST_CELLS_ON_AXIS => asked_for,
        _ => MOST_CELLS_ON_AXIS,
    }
}

/// At most so many cells for a group of so many triangles, whatever its box.
pub(super) const fn cells_at_most(triangle_count: usize, options: &Options) -> usize {
    match options.resolution {
        Resolution::Cells([x, y, z]) => {
            cell_count([cells_on_axis(x), cells_on_axis(y), cells_on_axis(z)])
        }
        // The cells on each axis are rounded down, so there are never more than wanted.
        Resolution::CellsPerTriangle(density) => {
            (density as f64 * triangle_count as f64) as usize + 1
        }
        Resolution::Automatic => triangle_count.saturating_mul(16) + 1,
    }
}

/// The cells along each axis, where the options say.
pub(super) fn cells_asked_for(group: &Group<'_>, options: &Options) -> Option<[u32; 3]> {
    match options.resolution {
        Resolution::Cells(mut cells) => {
            for (n, side) in cells.iter_mut().zip(group.bounds.extent()) {
                // Where the box is flat, planes cannot be told apart.
                *n = if side > 0.0 { cells_on_axis(*n) } else { 1 };
            }
            Some(cells)
        }
        Resolution::CellsPerTriangle(density) => {
            Some(cells_for(&group.bounds, group.ids.len(), f64::from(density)))
        }
        Resolution::Automatic => None,
    }
}

/// Steps of filing for each triangle that a grid of given resolution may take; see [`bounded`].
const STEPS_A_TRIANGLE: u64 = 4096;
/// Steps of filing for each cell, on top.
const STEPS_A_CELL: u64 = 8;

/// Makes a grid of the cells asked for. As long as filing would take more than 4,096 steps a triangle and 8 a cell,
/// because the boxes of triangles reach into many cells, the cells on each axis are halved.
pub(super) fn bounded<'g>(group: &'g Group<'g>, mut cells: [u32; 3]) -> Grid<'g> {
    loop {
        let grid = Grid::new(group, cells);
        let most = STEPS_A_TRIANGLE
            .saturating_mul(group.ids.len() as u64)
            .saturating_add(STEPS_A_CELL.saturating_mul(cell_count(cells) as u64));
        if grid.steps() <= most || cells == [1; 3] {
            return grid;
        }
        cells = cells.map(|n| (n / 2).max(1));
    }
}

/// The cells along each axis with which some rays cost least; `room` is for the most cells there may be.
///
/// Densities are tried from coarse to fine, until one is hopeless or would take the search beyond its budget. A single
/// rise of the cost ends nothing, because the cost goes up and down where planes and triangles are in step. The last
/// grids dominate the work, and triangles that lie in one place do not fill fine grids.
///
/// A model to which all cells are alike, entered with the ratio of the surfaces, lost to counting: the grid hierarchy
/// of figure 3 cost 61% more than the best density, because rays end in cells that hold something; with counting it
/// is 6% better than any one density.
pub(super) fn cheapest_cells(
    group: &Group<'_>,
    model: &CostModel,
    room: &mut [u32],
    rays: &mut [ProbeRay],
    words: &mut Words<'_>,
) -> Result<[u32; 3], BuildError> {
    // The search counts its steps apart, and ends where its budget does.
    let mut budget = Words::limited(&mut [], search_steps(group.ids.len(), 0));
    let cells = search(group, model, room, rays, &mut budget);
    words.spend(budget.steps())?;
    Ok(cells)
}

fn search(
    group: &Group<'_>,
    model: &CostModel,
    room: &mut [u32],
    rays: &mut [ProbeRay],
    budget: &mut Words<'_>,
) -> [u32; 3] {
    let probe = try_rays(group, room, rays, budget);
    let mut best = (f64::INFINITY, [1; 3]);
    let mut last = [0; 3];
    let mut density = LEAST_DENSITY;
    while density <= MOST_DENSITY {
        let cells = cells_for(&group.bounds, group.ids.len(), density);
        density *= DENSITY_STEP;
        if cells == last {
            continue;
        }
        last = cells;
        let grid = Grid::new(group, cells);
        let Some(counts) = room.get_mut(..cell_count(cells)) else { break };
        // Looking at the triangles tells what filing them takes; the chosen grid is counted and written, too.
        let steps = grid.steps();
        if steps.saturating_mul(3) > budget.steps_left() {
            break;
        }
        if budget.spend(steps.saturating_add(group.ids.len() as u64)).is_err() {
            break;
        }
        grid.count(counts);
        let cost = probe.cost(model, |ray, span, query| {
            // The query only counts: it never ends the walk.
            let (ControlFlow::Continue(()) | ControlFlow::Break(())) =
                walk(&grid.axes, ray, span, query, |query, cell| {
                    query.count_tests(counts.get(cell as usize).copied().unwrap_or(0));
                    ControlFlow::Continue(())
                });
        });
        if cost < best.0 {
            best = (cost, cells);
        } else if cost > best.0 * HOPELESS {
            break;
        }
    }
    best.1
}

/// Finds out where rays end, with the finest of a few grids for which there is room.
fn try_rays<'r>(
    group: &Group<'_>,
    room: &mut [u32],
    rays: &'r mut [ProbeRay],
    budget: &mut Words<'_>,
) -> Probe<'r> {
    let (mut words, mut spent): (&[u32], u64) = (&[], 0);
    let mut density = 1.0;
    loop {
        let cells = cells_for(&group.bounds, group.ids.len(), density);
        let grid = Grid::new(group, cells);
        let steps = grid.steps();
        if steps.saturating_mul(TRIES) <= budget.steps_left()
            && let Some((next, rest)) = room.split_at_mut_checked(cell_count(cells))
        {
            let most = rest.len();
            let mut written = Words::new(rest);
            if grid.write(next, &mut written).is_ok() && written.len() <= most {
                let len = written.len();
                words =
                    room.get(cell_count(cells)..).and_then(|rest| rest.get(..len)).unwrap_or(&[]);
                spent = steps.saturating_mul(2);
                break;
            }
        }
        if cell_count(cells) == 1 {
            break;
        }
        density *= 0.25;
    }
    let local = Local { triangles: group.triangles, bounds: group.bounds, words };
    let triangles = triangles_of(group).map(|(_, triangle)| triangle);
    let most_tests = budget.steps_left() / TRIES;
    let probe =
        Probe::new(triangles, &group.bounds, group.rays, rays, most_tests, |ray, span, query| {
            // The closest hit never ends the walk.
            let (ControlFlow::Continue(()) | ControlFlow::Break(())) =
                UniformGrid::traverse(&local, ray, span, query);
        });
    // Not refused: filing twice takes at most a quarter, the tests of all rays but the last an eighth. Cells entered
    // come on top; if they use the budget up, the search that follows tries no density.
    let _ = budget.spend(spent.saturating_add(probe.steps()));
    probe
}

/// Divisor of the budget: filing the grid once, and again testing triangles, may take an eighth each to find out where
/// rays end.
const TRIES: u64 = 8;
