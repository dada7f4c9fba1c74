//! Number of cells: given by the options, or found as the density at which probe rays cost least.
//!
//! ```text
//! a grid of usual density -> t at which probe rays end -> for each density: file, count, traverse -> the cheapest
//! ```
//! # Source
//! J. Cleary, G. Wyvill 1988: as many cubic cells as a constant times the triangles. Here, the constant is found.

use core::ops::ControlFlow;

use super::walk::walk;
use super::{Grid, MOST_CELLS_ON_AXIS, UniformGrid, cell_count, triangles_of};
use crate::error::BuildError;
use crate::geometry::Aabb;
use crate::indices::cost::{Probe, ProbeRay, resolution_search_steps};
use crate::input::{CostModel, Options, Resolution, SimdLevel};
use crate::memory::Words;
use crate::query::Query;
use crate::structure::{Group, Local, LocalIndex};

/// Lowest density tried by the automatic resolution, in cells a triangle.
const LEAST_DENSITY: f64 = 1.0 / 512.0;
/// Highest density tried by the automatic resolution, in cells a triangle.
const MOST_DENSITY: f64 = 16.0;
/// Factor between densities tried.
///
/// # Measured
/// - With a factor of 2, figure 2 cost 15% more.
const DENSITY_STEP: f64 = core::f64::consts::SQRT_2;
/// Factor that ends the search: a grid that costs `HOPELESS` times as much as the cheapest before it.
///
/// # Measured
/// - With 1.5, some samples of 64 rays ended the search too early on the flat scenes 4(a) and 4(d), with a grid that
///   cost 20 times the best.
const HOPELESS: f64 = 2.0;

/// Computes the number of nearly cubic cells along each axis, `density` cells a triangle in all; one on an axis on
/// which the box is flat.
fn cells_for(bounds: &Aabb, triangle_count: usize, density: f64) -> [u32; 3] {
    let extent = bounds.extent();
    let wanted = (density * triangle_count as f64).max(1.0);
    let longest = extent.into_iter().fold(0.0, |a: f64, b| if b > a { b } else { a });
    if longest <= 0.0 {
        return [1; 3];
    }
    // An axis thinner than a cell gets one cell; the other axes share the rest.
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

/// Clamps a number of cells on an axis to what is allowed.
const fn cells_on_axis(asked_for: u32) -> u32 {
    match asked_for {
        0 => 1,
        1..MOST_CELLS_ON_AXIS => asked_for,
        _ => MOST_CELLS_ON_AXIS,
    }
}

/// Bounds the number of cells for a group of `triangle_count` triangles, whatever its box.
pub(super) const fn cells_at_most(triangle_count: usize, options: &Options) -> usize {
    match options.resolution {
        Resolution::Cells([x, y, z]) => {
            cell_count([cells_on_axis(x), cells_on_axis(y), cells_on_axis(z)])
        }
        // The number of cells on each axis is rounded down, so there are never more than wanted.
        Resolution::CellsPerTriangle(density) => {
            (density as f64 * triangle_count as f64) as usize + 1
        }
        Resolution::Automatic => triangle_count.saturating_mul(16) + 1,
    }
}

/// The number of cells along each axis that the options ask for; `None` if it is to be found.
pub(super) fn cells_asked_for(group: &Group<'_>, options: &Options) -> Option<[u32; 3]> {
    match options.resolution {
        Resolution::Cells(mut cells) => {
            for (n, side) in cells.iter_mut().zip(group.bounds.extent()) {
                // On an axis on which the box is flat, planes cannot be told apart.
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

/// Steps of filing that a grid of given resolution may take for each triangle; see [`bounded`].
const STEPS_A_TRIANGLE: u64 = 4096;
/// Steps of filing that a grid of given resolution may take in addition for each cell.
const STEPS_A_CELL: u64 = 8;

/// Makes a grid of the cells asked for. The number of cells on each axis is halved as long as filing would take more
/// than 4,096 steps a triangle plus 8 a cell, because the boxes of triangles reach into many cells.
pub(super) fn bounded<'g>(group: &'g Group<'g>, mut cells: [u32; 3]) -> Grid<'g> {
    loop {
        let grid = Grid::new(group, cells);
        cells = grid.cells;
        let most = STEPS_A_TRIANGLE
            .saturating_mul(group.ids.len() as u64)
            .saturating_add(STEPS_A_CELL.saturating_mul(cell_count(cells) as u64));
        if grid.steps() <= most || cells == [1; 3] {
            return grid;
        }
        cells = cells.map(|n| (n / 2).max(1));
    }
}

/// Finds the number of cells along each axis with which probe rays cost least. `room` holds a word for each cell of the
/// finest grid.
///
/// - Densities are tried from coarse to fine, until one is [hopeless](HOPELESS) or would take the search beyond its
///   budget.
/// - A single rise of the cost does not end the search, because the cost goes up and down where planes and triangles
///   are in step.
/// - The last grids dominate the work, and triangles that lie in one place do not fill fine grids.
///
/// # What lost
/// - A model in which all cells are alike, entered with the ratio of the surfaces: the grid hierarchy of figure 3 cost
///   61% more than the best density, because rays end in cells that hold something. With counting it is 6% better than
///   any one density.
pub(super) fn cheapest_cells(
    group: &Group<'_>,
    model: &CostModel,
    room: &mut [u32],
    rays: &mut [ProbeRay],
    words: &mut Words<'_>,
) -> Result<[u32; 3], BuildError> {
    // The search counts its steps separately, and ends at its budget.
    let mut budget = Words::limited(&mut [], resolution_search_steps(group.ids.len()));
    let cells = search(group, model, room, rays, &mut budget);
    words.spend(budget.steps())?;
    Ok(cells)
}

/// Tries densities; see [`cheapest_cells`].
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
        let grid = Grid::new(group, cells);
        let cells = grid.cells;
        if cells == last {
            continue;
        }
        last = cells;
        let Some(counts) = room.get_mut(..cell_count(cells)) else { break };
        // A look at each triangle counts the steps of filing. The grid is filed once to be counted here and, if it is
        // chosen, twice to be written.
        let steps = grid.steps();
        if steps.saturating_mul(3) > budget.steps_left() {
            break;
        }
        if budget.spend(steps.saturating_add(group.ids.len() as u64)).is_err() {
            break;
        }
        grid.count(counts);
        let cost = probe.cost(model, |ray, span, query| {
            // The query only counts, and never ends the traversal.
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

/// Finds the t at which probe rays end, with the finest of a few grids for which there is room.
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
        let cells = grid.cells;
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
    let simd_level = SimdLevel::COMPILED;
    let local = Local { triangles: group.triangles, bounds: group.bounds, words, simd_level };
    let triangles = triangles_of(group).map(|(_, triangle)| triangle);
    let most_tests = budget.steps_left() / TRIES;
    let probe =
        Probe::new(triangles, &group.bounds, group.rays, rays, most_tests, |ray, span, query| {
            // A closest-hit query never ends the traversal.
            let (ControlFlow::Continue(()) | ControlFlow::Break(())) =
                UniformGrid::traverse(&local, ray, span, query);
        });
    // An error is ignored: filing twice takes at most a quarter of the budget, and the tests of all rays but the last
    // an eighth. The cells entered come on top; if they use up the budget, the search that follows tries no density.
    let _ = budget.spend(spent.saturating_add(probe.steps()));
    probe
}

/// Divisor of the budget for finding the t at which rays end: filing the grid once takes at most an eighth of the
/// budget, and testing triangles another eighth.
const TRIES: u64 = 8;
