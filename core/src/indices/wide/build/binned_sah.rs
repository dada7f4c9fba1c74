//! Split of primitives by the binned surface-area heuristic (SAH).
//!
//! ```text
//! primitives, or a sample -> bins along each axis -> planes between them -> the cheapest -> primitives below and above
//! ```
//! 1. [`Bins`]: the box around the centroids is divided into bins, along all three axes.
//! 2. [`Binned::add_all`]: each primitive, or a sample of very many, adds its box and its count to its bin on each axis.
//! 3. [`Binned::best_plane`]: a sweep upwards sums up (half area) * √(leaves) of what lies below each plane, see
//!    [`cost_of`](super::bins::cost_of). A sweep downwards adds what lies above, on all axes at once. The least sum wins.
//! 4. [`partition_by_plane`]: the primitives are partitioned by the plane, the cheaper side to the front.
//!
//! All of a split is compiled for each [`SimdLevel`]. The bytes are the same.
//!
//! # Measured
//! Figure 3, a city and a district, Zen 5, medians of pairs in turns:
//!
//! - A box as one register of eight numbers, in AVX2: builds take 14 to 16% less time; in SSE2 0 to 3%.
//! - Other changes, which saved 7% of the instructions, saved no time. Stalls count: see [`Partition::go_on`].
//!
//! # Source
//! I. Wald, *On Fast Construction of SAH-Based Bounding Volume Hierarchies*, 2007.

use core::cell::Cell;

use super::bins::{BinPlane, Binned, Bins, MOST_COUNTED};
use super::primitive::{Primitive, PrimitiveBounds};
use crate::input::SimdLevel;
use crate::simd::Work;

/// Number of bins along an axis.
///
/// # Measured
/// - 16: 1.5% more steps of a ray, over the built-in scenes. 64 are as good as 32.
pub(super) const BINS: usize = 32;
/// Number of bins along an axis for fewer than `FEW` primitives, because sweeping over the bins is most of the work
/// there.
///
/// # Measured
/// - 4 or 6 for at most 16 primitives were no faster.
const BINS_OF_FEW: usize = 8;
/// Number of primitives from which on there are `BINS` bins.
pub(super) const FEW: usize = 96;

/// Number of primitives from which on every fifth is binned; fewer are binned one and all. The stride is odd, because
/// scenes are made of pairs and dozens.
///
/// # What lost
/// - Every third from 256 primitives on: a tenth to a sixth less time to build, and 1% to 2% more steps.
/// - Cells of neighbours along a Morton curve as the primitives of the upper levels: no faster than a sample, with 1 to
///   5% more nodes and half as much scratch again.
const EVERY_FIFTH: usize = 16_384;
/// Number of primitives from which on every 129th is binned, so that fewer than `MOST_COUNTED` are. 129 is the least odd
/// stride for the largest scene, and one for all of them, because they are rare.
const EVERY_129TH: usize = 5 * (MOST_COUNTED as usize - 1);

/// The stride with which `count` primitives are binned: 1 bins all of them.
pub(super) fn stride_of(count: usize) -> u8 {
    if count >= EVERY_129TH {
        129
    } else if count >= EVERY_FIFTH {
        5
    } else {
        1
    }
}

/// Splits more than eight primitives in two at the least cost, or equally where there is no plane: none separates them,
/// or all costs overflow, or rounding leaves a side empty. Returns the length of the first part, and the bounds of both.
pub(crate) fn split_by_sah(
    primitives: &mut [Primitive],
    part: &PrimitiveBounds,
    level: SimdLevel,
) -> (usize, [PrimitiveBounds; 2]) {
    if primitives.len() < FEW {
        split_by_bins::<BINS_OF_FEW>(primitives, part, level)
    } else {
        split_by_bins::<BINS>(primitives, part, level)
    }
}

// Not inlined: in the frame of the recursion, the bins of each depth would be on the stack at once.
#[inline(never)]
fn split_by_bins<const N: usize>(
    primitives: &mut [Primitive],
    part: &PrimitiveBounds,
    level: SimdLevel,
) -> (usize, [PrimitiveBounds; 2]) {
    level.run(SplitByBins::<N> { primitives, part })
}

/// Split by `N` bins along each axis.
struct SplitByBins<'p, const N: usize> {
    primitives: &'p mut [Primitive],
    part: &'p PrimitiveBounds,
}

impl<const N: usize> Work for SplitByBins<'_, N> {
    type Output = (usize, [PrimitiveBounds; 2]);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { primitives, part } = self;
        let stride = stride_of(primitives.len());
        let bins = Bins::new(part, N);
        let mut binned = Binned::<N>::EMPTY;
        binned.add_all(primitives, stride, &bins);
        match binned.best_plane(stride) {
            Some(plane) => partition_by_plane(primitives, &bins, &plane),
            None => split_equally(primitives),
        }
    }
}

/// Splits primitives in two equal parts, as they lie. Returns the length of the first part, and the bounds of both.
#[cold]
#[inline(never)]
pub(crate) fn split_equally(primitives: &[Primitive]) -> (usize, [PrimitiveBounds; 2]) {
    let half = primitives.len() / 2;
    let (left, right) = primitives.split_at_checked(half).unwrap_or_default();
    (half, [left, right].map(PrimitiveBounds::around))
}

/// Partitions primitives by a plane, the cheaper side to the front. Returns the length of the front, and the bounds of
/// both sides.
#[inline(always)]
fn partition_by_plane(
    primitives: &mut [Primitive],
    bins: &Bins,
    plane: &BinPlane,
) -> (usize, [PrimitiveBounds; 2]) {
    let mut partition = Partition::new(bins, plane);
    partition.go_on(primitives, primitives.len());
    match primitives.split_at_checked(partition.front) {
        Some((left, right)) if !left.is_empty() && !right.is_empty() => {
            (partition.front, [PrimitiveBounds::around(left), PrimitiveBounds::around(right)])
        }
        // Rounding put the plane outside the centroids.
        _ => split_equally(primitives),
    }
}

/// Partition of primitives by a plane, the cheaper side to the front, which can pause.
///
/// Each primitive is swapped with the first one behind the front, and the front grows if the primitive belongs there.
/// No branch depends on a primitive, because half of those would be mispredicted.
///
/// # Measured
/// - Without that branch the build takes a tenth less time.
///
/// # What lost
/// - Finding the sides of 32 primitives from either end, and then exchanging only those on the wrong side: as long.
/// - A stable order by way of spare memory: as long.
pub(super) struct Partition {
    axis: usize,
    plane_at: f32,
    /// True if what lies above the plane goes to the front.
    above_first: bool,
    /// The length of the front so far.
    pub front: usize,
    /// The next primitive to look at.
    pub next: usize,
}

impl Partition {
    #[inline(always)]
    pub fn new(bins: &Bins, plane: &BinPlane) -> Self {
        let BinPlane { axis, above_first, .. } = *plane;
        Self { axis, plane_at: bins.coordinate_of(plane), above_first, front: 0, next: 0 }
    }

    /// Looks at up to `count` more primitives of all `primitives`.
    #[inline(always)]
    pub fn go_on(&mut self, primitives: &mut [Primitive], count: usize) {
        // Number by number, of which compilers make whole registers, and no loop where there are none. A primitive that is
        // moved as two corners and read as one value stalls the processor.
        let numbers = bytemuck::cast_slice_mut::<Primitive, f32>(primitives);
        let (cells, _) = Cell::from_mut(numbers).as_slice_of_cells().as_chunks::<8>();
        let mut front = self.front;
        let end = self.next.saturating_add(count).min(cells.len());
        for cell in cells.get(self.next..end).unwrap_or_default() {
            let doubled_centroid = cell[self.axis % 4].get() - cell[4 + self.axis % 4].get();
            if let Some(first) = cells.get(front) {
                let (primitive, at_front) = (get(cell), get(first));
                set(cell, at_front);
                set(first, primitive);
            }
            front += usize::from((doubled_centroid >= self.plane_at) == self.above_first);
        }
        self.front = front;
        self.next = end;
    }
}

#[inline(always)]
fn get(cells: &[Cell<f32>; 8]) -> [f32; 8] {
    let [a, b, c, d, e, f, g, h] = cells;
    [a.get(), b.get(), c.get(), d.get(), e.get(), f.get(), g.get(), h.get()]
}

#[inline(always)]
fn set(cells: &[Cell<f32>; 8], numbers: [f32; 8]) {
    let [a, b, c, d, e, f, g, h] = cells;
    let [i, j, k, l, m, n, o, p] = numbers;
    a.set(i);
    b.set(j);
    c.set(k);
    d.set(l);
    e.set(m);
    f.set(n);
    g.set(o);
    h.set(p);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;
    use crate::geometry::Triangle;
    use crate::input::MOST_TRIANGLES;

    /// Primitives of small triangles in a box whose sides are some `size`, that along z `depth` times that.
    fn primitives<const COUNT: usize>(size: f32, depth: f32) -> [Primitive; COUNT] {
        let mut random = 1_u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((random >> 8) as f32 / 1e6 - 8.0) * size
        };
        core::array::from_fn(|id| {
            let corner = Vec3::new(next(), next(), next() * depth);
            let triangle = Triangle::new(corner, corner + Vec3::X, corner + Vec3::Y * depth);
            Primitive::new(&triangle, 70_000 * id as u32)
        })
    }

    #[test]
    fn splits_are_the_same_at_every_level() {
        let detected = SimdLevel::detect();
        // Of the largest, the centroids overflow.
        for (size, depth) in [(1.0, 0.0), (1.0, 1.0), (3e37, 1.0)] {
            let all = primitives::<1_000>(size, depth);
            for count in [9, 10, 31, FEW - 1, FEW, 999, 1_000] {
                let split = |level| {
                    let mut primitives = all;
                    let some = &mut primitives[..count];
                    let around = PrimitiveBounds::around(some);
                    let (length, bounds) = split_by_sah(some, &around, level);
                    let bounds = bounds.map(|part| bytemuck::must_cast::<_, [u32; 8]>(part.bounds));
                    (length, bounds, bytemuck::must_cast::<_, [[u32; 8]; 1_000]>(primitives))
                };
                let expected = split(SimdLevel::COMPILED);
                assert!((1..count).contains(&expected.0));
                for level in [detected.without_avx512(), detected] {
                    assert!(
                        split(level) == expected,
                        "{count} primitives, {size}, {depth}, {level:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_f32_counts_what_is_binned() {
        for count in [1, EVERY_FIFTH - 1, EVERY_FIFTH, EVERY_129TH - 1, EVERY_129TH, MOST_TRIANGLES]
        {
            let binned = count.div_ceil(stride_of(count).into());
            assert!(binned < MOST_COUNTED as usize, "{count}");
        }
    }
}
