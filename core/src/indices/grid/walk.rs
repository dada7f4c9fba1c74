//! Traversal of the cells along a ray, front to back, with conservative crossings.
//!
//! Amanatides and Woo step to the neighbour whose plane is crossed first. If two planes are crossed within the rounding
//! of each other, the first is not known. And a ray that runs in a plane never leaves two rows of cells. So this
//! traversal goes by slices:
//! 1. Slices lie across the main axis: the one along which the ray passes most cells.
//! 2. For each slice, a range of cells that the ray may touch is kept on each of the two other axes. A range is one
//!    cell, or two where the ray crosses a plane.
//! 3. The product of both ranges is tested against the crossings again.
//!

use core::ops::ControlFlow;

use crate::geometry::{Aabb, RaySpan, Span};
use crate::query::Query;

/// Planes across one axis.
#[derive(Clone, Copy)]
pub(super) struct GridAxis {
    number: usize,
    lo: f64,
    hi: f64,
    step: f64,
    pub cells: u32,
}

impl GridAxis {
    pub fn all(bounds: &Aabb, cells: [u32; 3]) -> [Self; 3] {
        let (lo, hi) = (bounds.lo.to_array(), bounds.hi.to_array());
        let axis = |number: usize| {
            let (lo, hi) = (f64::from(lo[number]), f64::from(hi[number]));
            let cells = cells[number].max(1);
            Self { number, lo, hi, step: (hi - lo) / f64::from(cells), cells }
        };
        [axis(0), axis(1), axis(2)]
    }

    pub fn plane(&self, index: u32) -> f64 {
        if index >= self.cells { self.hi } else { self.lo + f64::from(index) * self.step }
    }

    /// Finds the cell that holds `x`, or the nearest; of two, the upper.
    fn cell_of(&self, x: f64) -> u32 {
        // The cast saturates, and maps a NaN (0 / 0) to 0.
        let mut cell = (((x - self.lo) / self.step) as u32).min(self.cells - 1);
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
        let first = self.cell_of(f64::from(lo));
        let mut last = self.cell_of(f64::from(hi));
        while last > first && self.plane(last) >= f64::from(hi) {
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
    let tracks = axes.map(|axis| Track::new(axis, ray, span.from));
    // 1. Choose the main axis: the one on which most cells are passed for each unit of t.
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
    let stride = [1, axes[0].cells, axes[0].cells.wrapping_mul(axes[1].cells)];
    let number = |track: &Track<'_>, step: u32| {
        let stride = stride.get(track.axis.number).copied().unwrap_or(0);
        track.cell(step).wrapping_mul(stride)
    };
    loop {
        // 2. Clip the ray to the slice, and leave behind the cells on the other axes that it has left.
        let slice = main.within(main.step, span);
        if slice.from > span.to || slice.from > query.last() {
            return ControlFlow::Continue(());
        }
        b.leave_behind(slice.from);
        c.leave_behind(slice.from);
        // 3. Visit the product of both ranges.
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
                    visit(query, cell)?;
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
        // 4. Step to the next slice.
        if main.step + 1 >= main.axis.cells {
            return ControlFlow::Continue(());
        }
        main.step += 1;
    }
}

/// Ray along one axis: steps count cells in the direction of the ray.
#[derive(Clone, Copy)]
struct Track<'r> {
    axis: GridAxis,
    ray: &'r RaySpan,
    downwards: bool,
    speed: f64,
    step: u32,
}

impl<'r> Track<'r> {
    /// Starts in the first cell that the ray may touch at `from`.
    fn new(axis: GridAxis, ray: &'r RaySpan, from: f64) -> Self {
        let downwards = ray.sign_mask() >> axis.number & 1 == 1;
        let (origin, speed) = ray.along(axis.number);
        let cell = axis.cell_of(origin + speed * from);
        let step = if downwards { axis.cells - 1 - cell } else { cell };
        let mut track = Self { axis, ray, downwards, speed: speed.abs(), step };
        // The position is rounded, and a position on a plane belongs to two cells.
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

    /// The plane through which the ray enters the cell of a step.
    fn entry(&self, step: u32) -> f64 {
        self.axis.plane(if self.downwards { self.axis.cells - step } else { step })
    }

    fn exit(&self, step: u32) -> f64 {
        self.entry(step + 1)
    }

    /// Clips `span` to what may lie between the planes of a step.
    fn within(&self, step: u32, span: Span) -> Span {
        let from = self.ray.crossing(self.axis.number, self.entry(step)).earliest;
        let to = self.ray.crossing(self.axis.number, self.exit(step)).latest;
        Span {
            from: if from > span.from { from } else { span.from },
            to: if to < span.to { to } else { span.to },
        }
    }

    /// Skips the cells that the ray has surely left at `from`.
    fn leave_behind(&mut self, from: f64) {
        while self.step + 1 < self.axis.cells
            && self.ray.crossing(self.axis.number, self.exit(self.step)).latest < from
        {
            self.step += 1;
        }
    }

    /// Tells whether the ray may be in the next cell at `to`.
    fn reaches_beyond(&self, step: u32, to: f64) -> bool {
        step + 1 < self.axis.cells
            && self.ray.crossing(self.axis.number, self.exit(step)).earliest <= to
    }
}
