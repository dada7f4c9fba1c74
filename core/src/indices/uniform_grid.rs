//! The uniform grid: cells of one size, visited one after the other along the ray.
//!
//! ```text
//! words:  cells in x | in y | in z | first reference of each cell, and one past the last | id id id ...
//! ```
//! A cell's number is `x + nx (y + ny z)`; plane `i` across an axis of `n` cells lies at `lo + i (hi - lo)
//! / n`, computed in `f64`, alike for building and walking, the last at `hi` itself.
//!
//! # Walking
//! Amanatides and Woo step to the neighbour whose plane is crossed first. Where two planes are crossed
//! within the rounding of each other, the first is not known, and a ray that runs in a plane never leaves
//! two rows of cells. So the walk goes by slices across the axis along which the ray passes most cells;
//! for each slice it keeps, on the two other axes, the range of cells that the ray may touch there. The
//! range is one cell, or two where the ray crosses over, and the product of both is tested against
//! the crossings again. Each plane's parameter is computed from its index, not accumulated.
//!
//! # Source
//! J. Amanatides, A. Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, 1987. Resolution:
//! J. Cleary, G. Wyvill 1988, as many cubic cells as a constant times the triangles.

use core::ops::ControlFlow;

use super::{Group, Local, LocalIndex, Statistics};
use crate::auto::{CostModel, Estimate, surface};
use crate::geometry::{Aabb, RaySpan, Span, Triangle, may_overlap};
use crate::memory::{Arena, Words, size_of_slice};
use crate::query::Query;
use crate::scene::Resolution;
use crate::{BuildError, Options};

/// The uniform grid; `Clustered<UniformGrid>` is the hierarchy of uniform grids of Cazals, Drettakis and
/// Puech.
pub enum UniformGrid {}

/// Words before the cells.
const HEAD: u32 = 3;
/// Cells along an axis: their planes stay apart in `f64` whatever the `f32` box.
pub(crate) const MOST_CELLS_ON_AXIS: u32 = 1 << 16;
/// Densities tried by the automatic resolution, in cells per triangle, from here on a factor of
/// `DENSITY_STEP` apart. With a factor of 2, figure 2 cost 15% more.
const LEAST_DENSITY: f64 = 1.0 / 512.0;
const MOST_DENSITY: f64 = 16.0;
const DENSITY_STEP: f64 = core::f64::consts::SQRT_2;
/// The search ends where a grid is estimated to cost so many times the cheapest before it.
const HOPELESS: f64 = 1.5;

/// The planes across one axis.
#[derive(Clone, Copy)]
struct Axis {
    number: usize,
    lo: f64,
    hi: f64,
    step: f64,
    cells: u32,
}

impl Axis {
    fn all(bounds: &Aabb, cells: [u32; 3]) -> [Self; 3] {
        let (lo, hi) = (bounds.lo.to_array(), bounds.hi.to_array());
        let axis = |number: usize| {
            let (lo, hi) = (f64::from(lo[number]), f64::from(hi[number]));
            let cells = cells[number].max(1);
            Self { number, lo, hi, step: (hi - lo) / f64::from(cells), cells }
        };
        [axis(0), axis(1), axis(2)]
    }

    fn plane(&self, index: u32) -> f64 {
        if index >= self.cells { self.hi } else { self.lo + f64::from(index) * self.step }
    }

    /// A cell that holds `x`, or the nearest; of two, the upper.
    fn cell_of(&self, x: f64) -> u32 {
        // The cast saturates, and takes a NaN (0 / 0) to 0.
        let mut cell = (((x - self.lo) / self.step) as u32).min(self.cells - 1);
        while cell > 0 && self.plane(cell) > x {
            cell -= 1;
        }
        while cell + 1 < self.cells && self.plane(cell + 1) <= x {
            cell += 1;
        }
        cell
    }

    /// The cells in which the extent `lo..=hi` of a triangle is filed, both included: those it reaches
    /// into, and one of those it lies on the face of.
    fn cells_of(&self, lo: f32, hi: f32) -> (u32, u32) {
        let first = self.cell_of(f64::from(lo));
        let mut last = self.cell_of(f64::from(hi));
        while last > first && self.plane(last) >= f64::from(hi) {
            last -= 1;
        }
        (first, last)
    }
}

fn cell_count([x, y, z]: [u32; 3]) -> usize {
    (x as usize).saturating_mul(y as usize).saturating_mul(z as usize)
}

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

/// At most so many cells for a group of so many triangles, whatever its box.
fn cells_at_most(triangle_count: usize, options: &Options) -> usize {
    match options.resolution {
        Resolution::Cells(cells) => cell_count(cells.map(|n| n.clamp(1, MOST_CELLS_ON_AXIS))),
        // The cells on each axis are rounded down, so there are never more than wanted.
        Resolution::CellsPerTriangle(density) => {
            (f64::from(density) * triangle_count as f64) as usize + 1
        }
        Resolution::Automatic => triangle_count.saturating_mul(16) + 1,
    }
}

struct Grid<'g> {
    group: &'g Group<'g>,
    axes: [Axis; 3],
    cells: [u32; 3],
}

impl<'g> Grid<'g> {
    fn new(group: &'g Group<'g>, cells: [u32; 3]) -> Self {
        Self { group, axes: Axis::all(&group.bounds, cells), cells }
    }

    /// Shows every cell in which a triangle is filed.
    fn for_each_cell(&self, triangle: &Triangle, mut show: impl FnMut(usize)) {
        let bounds = triangle.bounds();
        let [ax, ay, az] = &self.axes;
        let (x0, x1) = ax.cells_of(bounds.lo.x, bounds.hi.x);
        let (y0, y1) = ay.cells_of(bounds.lo.y, bounds.hi.y);
        let (z0, z1) = az.cells_of(bounds.lo.z, bounds.hi.z);
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

    fn triangles(&self) -> impl Iterator<Item = (u32, &'g Triangle)> {
        let group = self.group;
        group.ids.iter().filter_map(|&id| Some((id, group.triangles.get(id as usize)?)))
    }

    /// The expected cost of a ray through the box. A cell is entered with the ratio of the surfaces.
    fn estimated_cost(&self, model: &CostModel) -> f64 {
        let mut estimate = Estimate::new(model);
        let whole = surface(self.group.bounds.extent());
        let cell = surface([self.axes[0].step, self.axes[1].step, self.axes[2].step]);
        let probability = if whole > 0.0 { cell / whole } else { 1.0 };
        let mut references = 0;
        for (_, triangle) in self.triangles() {
            self.for_each_cell(triangle, |_| references += 1);
        }
        estimate.add_node(probability * cell_count(self.cells) as f64);
        estimate.add_tests(probability, references);
        estimate.total()
    }
}

fn choose_cells(group: &Group<'_>, options: &Options) -> [u32; 3] {
    let count = group.ids.len();
    match options.resolution {
        Resolution::Cells(mut cells) => {
            for (n, side) in cells.iter_mut().zip(group.bounds.extent()) {
                // Where the box is flat, planes cannot be told apart.
                *n = if side > 0.0 { (*n).clamp(1, MOST_CELLS_ON_AXIS) } else { 1 };
            }
            cells
        }
        Resolution::CellsPerTriangle(density) => {
            cells_for(&group.bounds, count, f64::from(density))
        }
        Resolution::Automatic => {
            // From coarse to fine until it is hopeless; the cost goes up and down where planes and
            // triangles are in step. So the work is dominated by the last steps, and triangles that lie
            // in one place do not fill fine grids.
            let mut best = (f64::INFINITY, [1; 3]);
            let mut last = [0; 3];
            let mut density = LEAST_DENSITY;
            while density <= MOST_DENSITY {
                let cells = cells_for(&group.bounds, count, density);
                density *= DENSITY_STEP;
                if cells == last {
                    continue;
                }
                last = cells;
                let cost = Grid::new(group, cells).estimated_cost(&options.cost_model());
                if cost < best.0 {
                    best = (cost, cells);
                } else if cost > best.0 * HOPELESS {
                    break;
                }
            }
            best.1
        }
    }
}

impl LocalIndex for UniformGrid {
    const NAME: &'static str = "uniform-grid";
    const HIERARCHY_NAME: &'static str = "grid-hierarchy";
    const KIND: u32 = 6;
    const COST: CostModel = CostModel::tests_per_node(2.5);

    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        size_of_slice::<u32>(cells_at_most(triangle_count, options))
    }

    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let cells = choose_cells(group, options);
        let count = cell_count(cells);
        if count >= u32::MAX as usize {
            return Err(BuildError::TooLarge);
        }
        let grid = Grid::new(group, cells);
        let needed = Self::scratch_bytes(group.ids.len(), options);
        let full = BuildError::ScratchFull { needed, given: scratch.len() };
        let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        let next = arena.take::<u32>(count).ok_or(full)?;

        // 1. Count the references of each cell, and sum up.
        next.fill(0);
        for (_, triangle) in grid.triangles() {
            grid.for_each_cell(triangle, |cell| {
                if let Some(count) = next.get_mut(cell) {
                    *count = count.saturating_add(1);
                }
            });
        }
        words.extend(&cells);
        let mut sum = 0_u32;
        for slot in next.iter_mut() {
            words.push(sum);
            let first = sum;
            sum = sum.checked_add(*slot).ok_or(BuildError::TooLarge)?;
            *slot = first;
        }
        words.push(sum);

        // 2. File the triangles; ascending in each cell, since they come ascending.
        let ids = words.reserve(sum as usize);
        for (id, triangle) in grid.triangles() {
            grid.for_each_cell(triangle, |cell| {
                if let Some(place) = next.get_mut(cell) {
                    words.set(ids + *place as usize, id);
                    *place += 1;
                }
            });
        }
        Ok(())
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let cells = [local.word(0), local.word(1), local.word(2)];
        let count = cell_count(cells) as u32;
        let axes = Axis::all(&local.bounds, cells);
        let tracks = axes.map(|axis| Track::new(axis, ray, span.from));
        // Slices across the axis on which most cells are passed.
        let passed = |track: &Track<'_>| {
            let speed = if track.axis.step > 0.0 { track.speed / track.axis.step } else { 0.0 };
            (speed, track.speed)
        };
        let [x, y, z] = tracks;
        let (mut main, mut b, mut c) = if passed(&x) >= passed(&y) && passed(&x) >= passed(&z) {
            (x, y, z)
        } else if passed(&y) >= passed(&z) {
            (y, x, z)
        } else {
            (z, x, y)
        };
        let stride = [1, cells[0], cells[0].wrapping_mul(cells[1])];
        let number = |track: &Track<'_>, step: u32| {
            let stride = stride.get(track.axis.number).copied().unwrap_or(0);
            track.cell(step).wrapping_mul(stride)
        };
        loop {
            let slice = main.within(main.step, span);
            if slice.from > span.to || slice.from > query.last() {
                return ControlFlow::Continue(());
            }
            b.leave_behind(slice.from);
            c.leave_behind(slice.from);
            let mut b_step = b.step;
            loop {
                let row = b.within(b_step, slice);
                let mut c_step = c.step;
                while !row.is_empty() {
                    let part = c.within(c_step, row);
                    if !part.is_empty() && part.from <= query.last() {
                        query.enter();
                        let cell = number(&main, main.step)
                            .wrapping_add(number(&b, b_step))
                            .wrapping_add(number(&c, c_step));
                        let first = local.word(HEAD.wrapping_add(cell));
                        let end = local.word(HEAD.wrapping_add(cell).wrapping_add(1));
                        let ids = HEAD.wrapping_add(count).wrapping_add(1).wrapping_add(first);
                        local.test(ids, end.wrapping_sub(first), query)?;
                    }
                    if !c.reaches_beyond(c_step, slice.to) {
                        break;
                    }
                    c_step += 1;
                }
                if !b.reaches_beyond(b_step, slice.to) {
                    break;
                }
                b_step += 1;
            }
            if main.step + 1 >= main.axis.cells {
                return ControlFlow::Continue(());
            }
            main.step += 1;
        }
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

/// The way of a ray along one axis: steps count cells in the direction of the ray.
#[derive(Clone, Copy)]
struct Track<'r> {
    axis: Axis,
    ray: &'r RaySpan,
    downwards: bool,
    speed: f64,
    step: u32,
}

impl<'r> Track<'r> {
    /// Begins in the first cell that the ray may touch at `from`.
    fn new(axis: Axis, ray: &'r RaySpan, from: f64) -> Self {
        let downwards = ray.sign_mask() >> axis.number & 1 == 1;
        let (origin, speed) = ray.along(axis.number);
        let cell = axis.cell_of(origin + speed * from);
        let step = if downwards { axis.cells - 1 - cell } else { cell };
        let mut track = Self { axis, ray, downwards, speed: speed.abs(), step };
        // The position is rounded, and on a plane there are two cells.
        while track.step > 0
            && track.ray.crossing(axis.number, track.entry(track.step)).latest >= from
        {
            track.step -= 1;
        }
        track.leave_behind(from);
        track
    }

    fn cell(&self, step: u32) -> u32 {
        if self.downwards { (self.axis.cells - 1).wrapping_sub(step) } else { step }
    }

    /// The plane through which the cell of a step is entered.
    fn entry(&self, step: u32) -> f64 {
        self.axis.plane(if self.downwards { self.axis.cells - step } else { step })
    }

    fn exit(&self, step: u32) -> f64 {
        self.entry(step + 1)
    }

    /// The part of `span` that may lie between the planes of a step.
    fn within(&self, step: u32, span: Span) -> Span {
        let from = self.ray.crossing(self.axis.number, self.entry(step)).earliest;
        let to = self.ray.crossing(self.axis.number, self.exit(step)).latest;
        Span {
            from: if from > span.from { from } else { span.from },
            to: if to < span.to { to } else { span.to },
        }
    }

    /// Steps over the cells that the ray has surely left at `from`.
    fn leave_behind(&mut self, from: f64) {
        while self.step + 1 < self.axis.cells
            && self.ray.crossing(self.axis.number, self.exit(self.step)).latest < from
        {
            self.step += 1;
        }
    }

    /// Whether the ray may be in the next cell at `to`.
    fn reaches_beyond(&self, step: u32, to: f64) -> bool {
        step + 1 < self.axis.cells
            && self.ray.crossing(self.axis.number, self.exit(step)).earliest <= to
    }
}
