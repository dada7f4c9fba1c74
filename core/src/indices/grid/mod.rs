//! The uniform grid: cells of one size, visited in order along the ray (3D-DDA).
//!
//! ```text
//! words:  cells in x | in y | in z | first reference of each cell, and one past the last | id id id ...
//! ```
//! The number of a cell is `x + nx (y + ny z)`. Plane `i` across an axis of `n` cells lies at `lo + i (hi - lo) / n`,
//! and the last plane at `hi` itself. Build and traversal compute the same planes, in `f64`.
//!
//! # Source
//! J. Amanatides, A. Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, 1987.

mod resolution;
mod walk;

use core::ops::ControlFlow;

use resolution::{bounded, cells_asked_for, cells_at_most, cheapest_cells};
use walk::{GridAxis, walk};

use crate::cost::{ProbeRay, Weights, ray_count};
use crate::error::BuildError;
use crate::geometry::{RaySpan, Span, Triangle, may_overlap};
use crate::input::{CostModel, MOST_CELLS_ON_AXIS, Options, Resolution};
use crate::memory::{Arena, Words, size_of_slice};
use crate::query::Query;
use crate::structure::{Described, Group, Local, LocalIndex, Statistics};

/// Uniform grid, over the whole scene or over a cluster. `Clustered<UniformGrid>` is the hierarchy of uniform grids of
/// Cazals, Drettakis and Puech.
pub enum UniformGrid {}

/// Number of words before the cells.
const HEAD: u32 = 3;
/// Largest number of cells: cell numbers are `u32`, and so is the number past the last.
const MOST_CELLS: usize = u32::MAX as usize - 1;

const fn cell_count([x, y, z]: [u32; 3]) -> usize {
    (x as usize).saturating_mul(y as usize).saturating_mul(z as usize)
}

/// The triangles of a group with their ids, ascending.
fn triangles_of<'a>(group: &Group<'a>) -> impl Iterator<Item = (u32, Triangle)> + Clone + use<'a> {
    let Group { triangles, ids, .. } = *group;
    ids.iter().filter_map(move |&id| Some((id, triangles.get(id)?)))
}

/// Grid under construction: a group, and the planes across the axes.
struct Grid<'g> {
    group: &'g Group<'g>,
    axes: [GridAxis; 3],
    cells: [u32; 3],
}

impl<'g> Grid<'g> {
    fn new(group: &'g Group<'g>, cells: [u32; 3]) -> Self {
        Self { group, axes: GridAxis::all(&group.bounds, cells), cells }
    }

    /// Finds the first and the last cell that the box of a triangle reaches into, on each axis.
    fn cells_of(&self, triangle: &Triangle) -> [(u32, u32); 3] {
        let bounds = triangle.bounds();
        let [x, y, z] = &self.axes;
        [
            x.cells_of(bounds.lo.x, bounds.hi.x),
            y.cells_of(bounds.lo.y, bounds.hi.y),
            z.cells_of(bounds.lo.z, bounds.hi.z),
        ]
    }

    /// Counts the steps of filing the triangles once: one for each cell that a triangle's box reaches into. Cost: a
    /// look at each triangle.
    fn steps(&self) -> u64 {
        let cells = |triangle: &Triangle| {
            let sides = self.cells_of(triangle).map(|(first, last)| u64::from(last - first) + 1);
            // Below 2^48: at most 2^16 cells on an axis.
            sides.into_iter().product::<u64>()
        };
        triangles_of(self.group).map(|(_, triangle)| cells(&triangle)).fold(0, u64::saturating_add)
    }

    /// Calls `show` with every cell in which a triangle is filed.
    fn for_each_cell(&self, triangle: &Triangle, mut show: impl FnMut(usize)) {
        let [ax, ay, az] = &self.axes;
        let [(x0, x1), (y0, y1), (z0, z1)] = self.cells_of(triangle);
        let single = (x0, y0, z0) == (x1, y1, z1);
        let [nx, ny, _] = self.cells.map(|n| n as usize);
        for z in z0..=z1 {
            for y in y0..=y1 {
                for x in x0..=x1 {
                    let lo = [ax.plane(x), ay.plane(y), az.plane(z)];
                    let hi = [ax.plane(x + 1), ay.plane(y + 1), az.plane(z + 1)];
                    if single || may_overlap(triangle, lo, hi) {
                        show(x as usize + nx * (y as usize + ny * z as usize));
                    }
                }
            }
        }
    }

    /// Counts the references of each cell.
    fn count(&self, counts: &mut [u32]) {
        counts.fill(0);
        for (_, triangle) in triangles_of(self.group) {
            self.for_each_cell(&triangle, |cell| {
                if let Some(count) = counts.get_mut(cell) {
                    *count = count.saturating_add(1);
                }
            });
        }
    }

    /// Appends the grid to `words`, in twice as many [`steps`](Grid::steps). `next` has a word for each cell.
    fn write(&self, next: &mut [u32], words: &mut Words<'_>) -> Result<(), BuildError> {
        words.spend(self.steps().saturating_mul(2))?;
        // 1. Count the references of each cell, and sum them up to offsets.
        self.count(next);
        words.extend(&self.cells);
        let mut sum = 0_u32;
        for slot in next.iter_mut() {
            words.push(sum);
            let first = sum;
            sum = sum.checked_add(*slot).ok_or(BuildError::TooLarge)?;
            *slot = first;
        }
        words.push(sum);

        // 2. File the triangles. They come by ascending id, so ids ascend in each cell.
        let ids = words.reserve(sum as usize);
        for (id, triangle) in triangles_of(self.group) {
            self.for_each_cell(&triangle, |cell| {
                if let Some(offset) = next.get_mut(cell) {
                    words.set(ids + *offset as usize, id);
                    *offset += 1;
                }
            });
        }
        Ok(())
    }
}

/// Bounds the scratch; see [`LocalIndex::scratch_bytes`].
pub(crate) const fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
    let cells = size_of_slice::<u32>(cells_at_most(triangle_count, options));
    let rays = match options.resolution {
        Resolution::Automatic => size_of_slice::<ProbeRay>(ray_count(triangle_count)),
        _ => 0,
    };
    cells.saturating_add(rays)
}

impl Described for UniformGrid {
    const NAME: &'static str = "uniform-grid";
    const HIERARCHY_NAME: &'static str = "grid-hierarchy";
    const FORMAT: u32 = 6;
    const COST: CostModel = CostModel::tests_per_node(2.5);
    const WEIGHTS: Weights = Weights { ray: 27.0, node: 71.1, test: 27.5 }; // +-20%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 55_044.0, node: 90_339.0, test: 1_934.0 }; // +-10%
    const USES_RAYS: bool = true;
}

impl LocalIndex for UniformGrid {
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        scratch_bytes(triangle_count, options)
    }

    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let asked_for = cells_asked_for(group, options);
        let room = match asked_for {
            Some(cells) if cell_count(cells) > MOST_CELLS => return Err(BuildError::TooLarge),
            Some(cells) => cell_count(cells),
            None => cells_at_most(group.ids.len(), options).min(MOST_CELLS),
        };
        let needed = Self::scratch_bytes(group.ids.len(), options);
        let full = BuildError::ScratchFull { needed, given: scratch.len() };
        let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        let room = arena.take::<u32>(room).ok_or(full)?;
        let grid = if let Some(cells) = asked_for {
            bounded(group, cells)
        } else {
            let rays = arena.take::<ProbeRay>(ray_count(group.ids.len())).ok_or(full)?;
            let cells = cheapest_cells(group, &options.cost_model(), room, rays, words)?;
            Grid::new(group, cells)
        };
        let next = room.get_mut(..cell_count(grid.cells)).ok_or(full)?;
        grid.write(next, words)
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let cells = [local.word(0), local.word(1), local.word(2)];
        let ids = HEAD.wrapping_add(cell_count(cells) as u32).wrapping_add(1);
        walk(&GridAxis::all(&local.bounds, cells), ray, span, query, |query, cell| {
            let first = local.word(HEAD.wrapping_add(cell));
            let end = local.word(HEAD.wrapping_add(cell).wrapping_add(1));
            local.test(ids.wrapping_add(first), end.wrapping_sub(first), query)
        })
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let cells = [local.word(0), local.word(1), local.word(2)];
        if cells.iter().any(|n| !(1..=MOST_CELLS_ON_AXIS).contains(n)) {
            return None;
        }
        let count = u32::try_from(cell_count(cells)).ok()?;
        let ids = count.checked_add(HEAD + 1)?;
        let mut statistics = Statistics { inner_nodes: 1, ..Statistics::default() };
        let mut end = 0;
        for cell in 0..count {
            let first = local.word(HEAD + cell);
            let next = *local.words.get((HEAD + cell + 1) as usize)?;
            if first != end || next < first || !local.are_ids(ids.checked_add(first)?, next - first)
            {
                return None;
            }
            statistics.add_leaf(next - first, 1);
            end = next;
        }
        (ids as usize + end as usize == local.words.len()).then_some(statistics)
    }
}
