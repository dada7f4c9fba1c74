//! Traversal of the cells along a ray, front to back, with conservative crossings.
//!
//! Amanatides and Woo step to the neighbour whose plane is crossed first. If two planes are crossed within the rounding
//! of each other, the first is not known. And a ray that runs in a plane never leaves two rows of cells. So this
//! traversal keeps on each axis a *range* of cells in which the ray may be:
//! 1. A cell joins the range at the earliest crossing of the plane before it.
//! 2. A cell leaves the range at the latest crossing of the plane behind it.
//! 3. Whenever a cell joins on one axis, the product of that cell and the ranges of the other two axes is visited:
//!    nearly always one cell.
//!
//! At each parameter, the ray is in a cell of the product of the three ranges, and all of them have been visited by
//! then.

use core::ops::ControlFlow;

use crate::geometry::{Aabb, RaySpan, Span};
use crate::query::Query;

/// Planes across one axis, as `f32` holds them.
#[derive(Clone, Copy)]
pub(super) struct GridAxis {
    number: usize,
    lo: f32,
    hi: f32,
    step: f32,
    cells: u32,
}

impl GridAxis {
    pub fn all(bounds: &Aabb, cells: [u32; 3]) -> [Self; 3] {
        let axis = |number: usize| {
            let ([lo, hi], cells) = (bounds.along(number), cells[number % 3].max(1));
            // A single cell needs no planes but the sides, and its length may be beyond all `f32`.
            let step = if cells > 1 { (hi - lo) / cells as f32 } else { 0.0 };
            Self { number, lo, hi, step, cells }
        };
        [axis(0), axis(1), axis(2)]
    }

    /// Limits a number of cells on an axis to what planes that `f32` can tell apart divide: cells are at least 2^-20 of
    /// the largest coordinate long.
    pub fn most_cells([lo, hi]: [f32; 2]) -> u32 {
        const CELLS: f64 = 1_048_576.0; // 2^20
        let largest = if lo.abs() > hi.abs() { lo.abs() } else { hi.abs() };
        let extent = f64::from(hi) - f64::from(lo);
        if extent > f64::from(f32::MAX) {
            return 1;
        }
        // The cast saturates, and maps a NaN (0 / 0) to 0.
        ((extent / f64::from(largest) * CELLS) as u32).max(1)
    }

    /// The plane before a cell, or behind the last one.
    pub fn plane(&self, index: u32) -> f32 {
        if index >= self.cells { self.hi } else { self.inner_plane(index) }
    }

    /// The plane before a cell.
    #[inline]
    fn inner_plane(&self, index: u32) -> f32 {
        self.lo + index as f32 * self.step
    }

    /// Estimates the cell that holds `x`, or the nearest.
    #[inline]
    fn cell_near(&self, x: f32) -> u32 {
        // The cast saturates, and maps a NaN (0 / 0) to 0.
        (((x - self.lo) / self.step) as u32).min(self.cells - 1)
    }

    /// Finds the cell that holds `x`, or the nearest; of two, the upper.
    fn cell_of(&self, x: f32) -> u32 {
        let mut cell = self.cell_near(x);
        while cell > 0 && self.plane(cell) > x {
            cell -= 1;
        }
        while cell + 1 < self.cells && self.plane(cell + 1) <= x {
            cell += 1;
        }
        cell
    }

    /// Finds the first and the last cell in which the extent `lo..=hi` of a triangle is filed: the cells it reaches
    /// into, and one of the two cells whose common face it lies on.
    pub fn cells_of(&self, lo: f32, hi: f32) -> (u32, u32) {
        let first = self.cell_of(lo);
        let mut last = self.cell_of(hi);
        while last > first && self.plane(last) >= hi {
            last -= 1;
        }
        (first, last)
    }
}

/// Enters the cells that the ray may touch within the span, front to back, and calls `visit` with each.
#[inline]
pub(super) fn walk<Q: Query>(
    axes: &[GridAxis; 3],
    ray: &RaySpan,
    span: Span,
    query: &mut Q,
    mut visit: impl FnMut(&mut Q, u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let [x, y, z] = axes;
    let row = x.cells.wrapping_mul(y.cells);
    let mut tracks = [
        Track::new(*x, 1, ray, span.from),
        Track::new(*y, x.cells, ray, span.from),
        Track::new(*z, row, ray, span.from),
    ];
    // 1. Visit the cells in which the ray begins.
    let [x, y, z] = &tracks;
    for first in x.low..=x.high {
        visit_product(x.cell(first), [y, z], query, &mut visit)?;
    }
    loop {
        // 2. Find the axis on which the next cell joins.
        let [x, y, z] = &tracks;
        let (mut next, mut joins) = (0, x.joins);
        if y.joins < joins {
            (next, joins) = (1, y.joins);
        }
        if z.joins < joins {
            (next, joins) = (2, z.joins);
        }
        if joins > span.to || joins > ray.last(query.last_t()) {
            return ControlFlow::Continue(());
        }
        // 3. Leave behind the cells that the ray has surely left by then.
        for track in &mut tracks {
            track.leave_behind(ray, joins);
        }
        // 4. Visit the cells that join.
        let [x, y, z] = &mut tracks;
        let (track, others) = match next {
            0 => (x, [&*y, &*z]),
            1 => (y, [&*x, &*z]),
            _ => (z, [&*x, &*y]),
        };
        track.join(ray);
        let cell = track.cell(track.high);
        if others[0].low == others[0].high && others[1].low == others[1].high {
            query.enter();
            let cell = cell.wrapping_add(others[0].cell(others[0].low));
            visit(query, cell.wrapping_add(others[1].cell(others[1].low)))?;
        } else {
            visit_product(cell, others, query, &mut visit)?;
        }
    }
}

/// Visits the product of one cell and of the ranges on the other axes.
// Apart: nearly always the product is one cell, which the loop visits itself.
#[inline(never)]
fn visit_product<Q: Query>(
    cell: u32,
    [b, c]: [&Track; 2],
    query: &mut Q,
    visit: &mut impl FnMut(&mut Q, u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    for b_step in b.low..=b.high {
        for c_step in c.low..=c.high {
            query.enter();
            visit(query, cell.wrapping_add(b.cell(b_step)).wrapping_add(c.cell(c_step)))?;
        }
    }
    ControlFlow::Continue(())
}

/// Ray along one axis: steps count cells in the direction of the ray.
#[derive(Clone, Copy)]
struct Track {
    axis: GridAxis,
    downwards: bool,
    /// Steps in which the ray may be.
    low: u32,
    high: u32,
    /// The earliest parameter at which step `high + 1` joins; infinite if there is none.
    joins: f32,
    /// The latest parameter at which the ray leaves step `low`; infinite if that is step `high` too.
    leaves: f32,
    /// What a step adds to the number of a cell: from the first step on, and for each step.
    first: u32,
    stride: u32,
}

impl Track {
    /// Starts in the cells in which the ray may be at `from`.
    #[inline]
    fn new(axis: GridAxis, stride: u32, ray: &RaySpan, from: f32) -> Self {
        let downwards = ray.sign_mask() >> axis.number & 1 == 1;
        let cell = axis.cell_near(ray.position(axis.number, from));
        let last = axis.cells - 1;
        let (step, first, stride) = if downwards {
            (last - cell, last.wrapping_mul(stride), stride.wrapping_neg())
        } else {
            (cell, 0, stride)
        };
        let (joins, leaves) = (f32::INFINITY, f32::INFINITY);
        let mut track =
            Self { axis, downwards, low: step, high: step, joins, leaves, first, stride };
        // The position is rounded, and a position on a plane belongs to two cells. A crossing that is NaN bounds
        // nothing.
        while track.low > 0 && !track.has_left(ray, track.low - 1, from) {
            track.low -= 1;
        }
        while track.low < last && track.has_left(ray, track.low, from) {
            track.low += 1;
        }
        track.high = track.low;
        while track.high < last && !track.is_before(ray, track.high, from) {
            track.high += 1;
        }
        if track.high < last {
            track.joins = track.earliest(ray, track.high);
        }
        if track.low < track.high {
            track.leaves = track.latest(ray, track.low);
        }
        track
    }

    /// What a step contributes to the number of a cell.
    #[inline]
    fn cell(&self, step: u32) -> u32 {
        self.first.wrapping_add(step.wrapping_mul(self.stride))
    }

    /// The plane through which the ray leaves a step for the next.
    #[inline]
    fn plane(&self, step: u32) -> f32 {
        let index = if self.downwards { self.axis.cells.wrapping_sub(step + 1) } else { step + 1 };
        self.axis.inner_plane(index)
    }

    #[inline]
    fn earliest(&self, ray: &RaySpan, step: u32) -> f32 {
        ray.crossing(self.axis.number, self.plane(step)).earliest
    }

    #[inline]
    fn latest(&self, ray: &RaySpan, step: u32) -> f32 {
        ray.crossing(self.axis.number, self.plane(step)).latest
    }

    /// Tells whether the ray has surely left a step at `t`.
    #[inline]
    fn has_left(&self, ray: &RaySpan, step: u32, t: f32) -> bool {
        self.latest(ray, step) < t
    }

    /// Tells whether the ray has surely not left a step at `t`.
    #[inline]
    fn is_before(&self, ray: &RaySpan, step: u32, t: f32) -> bool {
        self.earliest(ray, step) > t
    }

    /// Leaves behind the steps that the ray has surely left at `t`.
    #[inline]
    fn leave_behind(&mut self, ray: &RaySpan, t: f32) {
        while self.leaves < t {
            self.low += 1;
            self.leaves =
                if self.low < self.high { self.latest(ray, self.low) } else { f32::INFINITY };
        }
    }

    /// Adds the next step to the range.
    #[inline]
    fn join(&mut self, ray: &RaySpan) {
        if self.low == self.high {
            self.leaves = self.latest(ray, self.low);
        }
        self.high += 1;
        self.joins = if self.high + 1 < self.axis.cells {
            self.earliest(ray, self.high)
        } else {
            f32::INFINITY
        };
    }
}
