//! The uniform grid: cells of one size, visited in order along the ray (3D-DDA).
//!
//! ```text
//! words:  cells in x | in y | in z | full cells | masks | ranks | firsts | id id id ...
//! mask:   one bit for each of 32 cells, set if triangles are filed in the cell
//! rank:   for each mask, the number of full cells before it
//! first:  for each full cell, the number of its first reference; at last, the number of all references
//! ```
//! The number of a cell is `x + nx (y + ny z)`. Plane `i` across an axis of `n` cells lies at `lo + i ((hi - lo) / n)`,
//! and the last plane at `hi` itself. Build and traversal compute the same planes, in `f32`.
//!
//! Most cells of a fine grid are empty. A ray learns that from one bit, and an empty cell takes two bits of memory.
//!
//! # Source
//! J. Amanatides, A. Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, 1987.

mod resolution;
mod walk;

use core::ops::ControlFlow;

use resolution::{bounded, cells_asked_for, cells_at_most, cheapest_cells};
use walk::{GridAxis, walk};

use crate::error::BuildError;
use crate::geometry::{RaySpan, Span, Triangle, may_overlap};
use crate::indices::cost::{ProbeRay, ray_count};
use crate::input::{CostModel, MOST_CELLS_ON_AXIS, Options, Resolution};
use crate::memory::{Arena, Words, size_of_slice};
use crate::query::Query;
use crate::structure::{Described, Group, Local, LocalIndex, Statistics, Weights};

/// Uniform grid, over the whole scene or over a cluster. `Clustered<UniformGrid>` is the hierarchy of uniform grids of
/// Cazals, Drettakis and Puech.
pub enum UniformGrid {}

/// Number of words before the masks.
const HEAD: u32 = 4;
/// Number of cells of a mask.
const MASK_CELLS: u32 = u32::BITS;
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
    /// Plans as many cells along each axis, or as many as [planes can divide](GridAxis::most_cells).
    fn new(group: &'g Group<'g>, mut cells: [u32; 3]) -> Self {
        for (axis, n) in cells.iter_mut().enumerate() {
            *n = (*n).clamp(1, GridAxis::most_cells(group.bounds.along(axis)));
        }
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
                    let lo = [ax.plane(x), ay.plane(y), az.plane(z)].map(f64::from);
                    let hi = [ax.plane(x + 1), ay.plane(y + 1), az.plane(z + 1)].map(f64::from);
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
        // 1. Count the references of each cell. Write which cells are full, and where their references begin.
        self.count(next);
        let full = |cells: &[u32]| cells.iter().filter(|&&count| count > 0).count() as u32;
        words.extend(&self.cells);
        words.push(full(next));
        for cells in next.chunks(MASK_CELLS as usize) {
            let bit = |(bit, &count): (usize, &u32)| u32::from(count > 0) << bit;
            words.push(cells.iter().enumerate().map(bit).sum());
        }
        let mut rank = 0;
        for cells in next.chunks(MASK_CELLS as usize) {
            words.push(rank);
            rank += full(cells);
        }
        let mut sum = 0_u32;
        for slot in next.iter_mut() {
            let (count, first) = (*slot, sum);
            sum = sum.checked_add(count).ok_or(BuildError::TooLarge)?;
            *slot = first;
            if count > 0 {
                words.push(first);
            }
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
    const FORMAT: u32 = 13;
    const COST: CostModel = CostModel::tests_per_node(4.0);
    const WEIGHTS: Weights = Weights { ray: 8.1, node: 13.5, test: 6.7 }; // +-20%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 70_021.0, node: 5_417.0, test: 1_942.0 }; // +-7%
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
        let masks = (cell_count(cells) as u32).div_ceil(MASK_CELLS);
        let ranks = HEAD.wrapping_add(masks);
        let firsts = ranks.wrapping_add(masks);
        let ids = firsts.wrapping_add(local.word(3)).wrapping_add(1);
        walk(&GridAxis::all(&local.bounds, cells), ray, span, query, |query, cell| {
            let (group, bit) = (cell / MASK_CELLS, 1 << (cell % MASK_CELLS));
            let mask = local.word(HEAD.wrapping_add(group));
            if mask & bit == 0 {
                return ControlFlow::Continue(());
            }
            let full_before = (mask & (bit - 1)).count_ones();
            let at = local.word(ranks.wrapping_add(group)).wrapping_add(full_before);
            let first = local.word(firsts.wrapping_add(at));
            let end = local.word(firsts.wrapping_add(at).wrapping_add(1));
            local.test(ids.wrapping_add(first), end.wrapping_sub(first), ray, query)
        })
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let cells = [local.word(0), local.word(1), local.word(2)];
        if cells.iter().any(|n| !(1..=MOST_CELLS_ON_AXIS).contains(n)) {
            return None;
        }
        let count = u32::try_from(cell_count(cells)).ok()?;
        let masks = count.div_ceil(MASK_CELLS);
        let ranks = masks.checked_add(HEAD)?;
        let firsts = ranks.checked_add(masks)?;
        let ids = firsts.checked_add(local.word(3))?.checked_add(1)?;
        // 1. The masks, and the number of full cells before each.
        let mut full = 0_u32;
        for group in 0..masks {
            let (mask, cells) = (local.word(HEAD + group), count - group * MASK_CELLS);
            let has_more = cells < MASK_CELLS && mask >> cells != 0;
            if has_more || local.word(ranks + group) != full {
                return None;
            }
            full += mask.count_ones();
        }
        // 2. The references of each full cell.
        let mut statistics = Statistics { inner_nodes: 1, ..Statistics::default() };
        let mut end = 0;
        for at in 0..full {
            let first = local.word(firsts + at);
            let next = *local.words.get((firsts + at + 1) as usize)?;
            if first != end
                || next <= first
                || !local.are_ids(ids.checked_add(first)?, next - first)
            {
                return None;
            }
            statistics.add_leaf(next - first, 1);
            end = next;
        }
        let is_whole = full == local.word(3) && ids as usize + end as usize == local.words.len();
        is_whole.then_some(statistics)
    }
}
