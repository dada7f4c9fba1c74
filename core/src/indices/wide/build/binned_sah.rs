//! Split of primitives by the binned surface-area heuristic (SAH).
//!
//! ```text
//! primitives, or a sample -> bins along each axis -> planes between them -> the cheapest -> primitives below and above
//! ```
//! 1. [`Bins`]: the box around the centroids is divided into bins, along all three axes.
//! 2. [`Binned::add_all`]: each primitive, or each fifth of very many, adds its box and its count to its bin on each axis.
//! 3. [`Binned::best_plane`]: a sweep upwards sums up (half area) * √(leaves), see [`cost_of`], of what lies below each plane, a sweep
//!    downwards adds what lies above, on all axes at once. The least sum wins.
//! 4. [`partition_by_plane`]: the primitives are partitioned by the plane, the cheaper side to the front.
//!
//! # Source
//! I. Wald, *On Fast Construction of SAH-Based Bounding Volume Hierarchies*, 2007.

use core::cell::Cell;

use glam::{Mat4, Vec4};

use super::LEAF_TRIANGLES;
use super::primitive::{Primitive, PrimitiveBounds};
use crate::geometry::Box4;

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

/// The stride with which `count` primitives are binned: 1 bins all of them.
pub(super) fn stride_of(count: usize) -> u8 {
    if count >= EVERY_FIFTH { 5 } else { 1 }
}

/// Splits more than eight primitives in two at the least cost, or equally where there is no plane: none separates them,
/// or all costs overflow, or rounding leaves a side empty. Returns
/// the length of the first part, and the bounds of both.
pub(crate) fn split_by_sah(
    primitives: &mut [Primitive],
    part: &PrimitiveBounds,
) -> (usize, [PrimitiveBounds; 2]) {
    if primitives.len() < FEW {
        split_by_bins::<BINS_OF_FEW>(primitives, part)
    } else {
        split_by_bins::<BINS>(primitives, part)
    }
}

// Not inlined: in the frame of the recursion, the bins of each depth would be on the stack at once.
#[inline(never)]
fn split_by_bins<const N: usize>(
    primitives: &mut [Primitive],
    part: &PrimitiveBounds,
) -> (usize, [PrimitiveBounds; 2]) {
    let bins = Bins::new(part, N);
    let mut binned = Binned::<N>::EMPTY;
    binned.add_all(primitives, stride_of(primitives.len()), &bins);
    match binned.best_plane() {
        Some(plane) => partition_by_plane(primitives, &bins, &plane),
        None => split_equally(primitives),
    }
}

#[cold]
#[inline(never)]
/// Splits primitives in two equal parts, as they lie. Returns the length of the first part, and the bounds of both.
pub(crate) fn split_equally(primitives: &[Primitive]) -> (usize, [PrimitiveBounds; 2]) {
    let half = primitives.len() / 2;
    let (left, right) = primitives.split_at_checked(half).unwrap_or_default();
    (half, [left, right].map(PrimitiveBounds::around))
}

/// What a ray that enters the box of `count` triangles has to pay: the square root of their leaves.
///
/// The surface-area heuristic has the leaves themselves, as if a ray tested all of them. A ray that enters a subtree
/// tests only those along its way.
///
/// # Measured
/// - The leaves themselves: 3% to 4% more steps over the built-in scenes, a tenth more in cities.
/// - Powers of 5/8 and 3/4: 1% and 2% more than the root.
pub(crate) fn cost_of(count: i32) -> f32 {
    let leaves = ((count - 1) >> LEAF_TRIANGLES.ilog2()) + 1;
    match ROOTS.get(leaves as usize) {
        Some(&root) => root,
        None => libm::sqrtf(leaves as f32),
    }
}

/// The square roots of 0 to 255, rounded as `sqrtf` rounds.
///
/// # Measured
/// - The roots computed each time: builds take 7% to 10% longer.
const ROOTS: [f32; 256] = {
    let mut roots = [0.0; 256];
    let mut number = 1;
    while number < roots.len() {
        // Newton's method from above, which ends within 12 steps.
        let square = number as f64;
        let mut root = square;
        let mut step = 0;
        while step < 12 {
            root = 0.5 * (root + square / root);
            step += 1;
        }
        roots[number] = root as f32;
        number += 1;
    }
    roots
};

/// Mapping from centroids to bins, along each axis.
pub(super) struct Bins {
    from: Vec4,
    scale: Vec4,
}

impl Bins {
    pub fn new(part: &PrimitiveBounds, count: usize) -> Self {
        let Box4 { lo, hi } = part.centroids;
        // Scaled down by the rounding error, so that the largest centroid falls into the last bin, and one at the begin
        // of a bin into that bin.
        let count = count as f32;
        let scale = Vec4::splat(count - BIN_ERROR * (1.0 + 0.5 / count)) / (hi - lo);
        // On an axis on which the centroids do not differ, or too little or too much for an `f32`, all are in the first
        // bin.
        let usable = scale.cmpgt(Vec4::ZERO) & scale.cmplt(Vec4::INFINITY);
        let or_zero = |numbers| Vec4::select(usable, numbers, Vec4::ZERO);
        Self { from: or_zero(lo), scale: or_zero(scale) }
    }

    /// The bin of a primitive along each axis; or the next, if rounding takes the centroid there.
    #[inline(always)]
    fn of(&self, primitive: &Primitive) -> [usize; 3] {
        // Adding 2^17 leaves the bin in the bits of the sum. A cast would saturate, which takes many more instructions.
        let positions =
            (primitive.doubled_centroid() - self.from) * self.scale + Vec4::splat(INTEGERS);
        let [x, y, z, _] = positions.to_array();
        [x, y, z].map(|position| position.to_bits() as usize >> FRACTION_BITS)
    }

    /// The coordinate of a plane on its axis: as far below the start of its bin as a centroid may lie and still be
    /// rounded into the bin.
    fn coordinate_of(&self, plane: &BinPlane) -> f32 {
        let axis = plane.axis % 3;
        self.from.to_array()[axis] + (plane.bin as f32 - BIN_ERROR) / self.scale.to_array()[axis]
    }
}

/// Number from which on the last bits of an `f32` are an integer and `FRACTION_BITS` bits behind the point.
const INTEGERS: f32 = 131_072.0; // 2^17
const FRACTION_BITS: u32 = 6;
/// Error in bins of a rounded centroid.
const BIN_ERROR: f32 = 1.0 / 128.0;

/// Contents of the `N` bins of each axis: structure of arrays.
///
/// The lower and the upper corners lie apart, so that one offset in bytes addresses both and the counts.
///
/// # What lost
/// - Boxes of eight numbers, the upper corner negated so that one minimum is enough: twice as long, because the
///   compiler stores them through masks.
pub(super) struct Binned<const N: usize> {
    lo: [[Vec4; N]; 3],
    hi: [[Vec4; N]; 3],
    /// The counts along x, y and z.
    counts: [[i32; 4]; N],
}

/// Plane between two bins of an axis.
pub(super) struct BinPlane {
    axis: usize,
    /// The first bin above the plane.
    bin: usize,
    /// True if what lies above costs less than what lies below.
    above_first: bool,
}

impl<const N: usize> Binned<N> {
    pub const EMPTY: Self = {
        let Box4 { lo, hi } = Box4::EMPTY;
        Self { lo: [[lo; N]; 3], hi: [[hi; N]; 3], counts: [[0; 4]; N] }
    };

    /// Adds each primitive, or one in `stride`, to its bin on each axis.
    pub fn add_all(&mut self, primitives: &[Primitive], stride: u8, bins: &Bins) {
        if stride > 1 {
            for primitive in primitives.iter().step_by(stride.into()) {
                self.add(primitive, stride.into(), bins);
            }
            return;
        }
        // Neighbours fall into the same bin, and would wait for each other. So primitives of both halves alternate: one
        // after the other took up to a tenth longer.
        let (left, right) = primitives.split_at_checked(primitives.len() / 2).unwrap_or_default();
        for (left, right) in left.iter().zip(right) {
            self.add(left, 1, bins);
            self.add(right, 1, bins);
        }
        if let [.., last] = right
            && right.len() > left.len()
        {
            self.add(last, 1, bins);
        }
    }

    /// Adds a primitive, which stands for `count` primitives of the subset.
    #[inline(always)]
    fn add(&mut self, primitive: &Primitive, count: i32, bins: &Bins) {
        for (axis, bin) in bins.of(primitive).into_iter().enumerate() {
            self.counts[bin % N][axis] += count;
            let (lo, hi) = (&mut self.lo[axis][bin % N], &mut self.hi[axis][bin % N]);
            let bounds = primitive.bounds();
            (*lo, *hi) = (lo.min(bounds.lo), hi.max(bounds.hi));
        }
    }

    /// Finds the plane of least SAH cost; of equals, the first axis, then the highest bin. `None` where no plane
    /// separates the primitives, or all costs overflow.
    pub fn best_plane(&self) -> Option<BinPlane> {
        // 1. Sweep upwards: the costs below each plane, on all axes at once. The cost of an empty side is NaN, and
        // never less.
        let mut below = [Vec4::ZERO; N];
        let mut side = Sides::EMPTY;
        for (bin, cost) in below.iter_mut().enumerate().skip(1) {
            side.add(self, bin - 1);
            *cost = side.costs();
        }
        // 2. Sweep downwards: add the costs above, and keep the least sum of each axis.
        let mut least = Vec4::INFINITY;
        let (mut bins, mut steps) = (Vec4::ZERO, Vec4::ZERO);
        let mut side = Sides::EMPTY;
        for (bin, below) in below.into_iter().enumerate().skip(1).rev() {
            side.add(self, bin);
            let above = side.costs();
            let costs = below + above;
            let less = costs.cmplt(least);
            least = Vec4::select(less, costs, least);
            bins = Vec4::select(less, Vec4::splat(bin as f32), bins);
            steps = Vec4::select(less, above - below, steps);
        }
        // 3. Choose the axis.
        let (bins, steps) = (bins.to_array(), steps.to_array());
        let mut best = None;
        let mut least_of_all = f32::INFINITY;
        for (axis, least) in least.to_array().into_iter().enumerate().take(3) {
            if least < least_of_all {
                least_of_all = least;
                best = Some(BinPlane {
                    axis,
                    bin: bins[axis] as usize,
                    above_first: steps[axis] < 0.0,
                });
            }
        }
        best
    }
}

/// Contents of one side of a plane across each axis.
struct Sides {
    boxes: [Box4; 3],
    counts: [i32; 4],
}

impl Sides {
    const EMPTY: Self = Self { boxes: [Box4::EMPTY; 3], counts: [0; 4] };

    #[inline(always)]
    fn add<const N: usize>(&mut self, binned: &Binned<N>, bin: usize) {
        for (all, (lo, hi)) in self.boxes.iter_mut().zip(binned.lo.iter().zip(&binned.hi)) {
            *all = all.union(Box4 { lo: lo[bin % N], hi: hi[bin % N] });
        }
        for (all, count) in self.counts.iter_mut().zip(&binned.counts[bin % N]) {
            *all += count;
        }
    }

    #[inline(always)]
    fn costs(&self) -> Vec4 {
        let [a, b, c] = self.boxes.map(|part| part.hi - part.lo);
        let Mat4 { x_axis: x, y_axis: y, z_axis: z, .. } = Mat4::from_cols(a, b, c, c).transpose();
        (x * y + y * z + z * x) * Vec4::from_array(self.counts.map(cost_of))
    }
}

/// Partitions primitives by a plane, the cheaper side to the front. Returns the length of the front, and the bounds of
/// both sides.
fn partition_by_plane(
    primitives: &mut [Primitive],
    bins: &Bins,
    plane: &BinPlane,
) -> (usize, [PrimitiveBounds; 2]) {
    let mut partition = Partition::new(bins, plane);
    partition.go_on(primitives, primitives.len());
    match primitives.split_at_checked(partition.front) {
        Some((left, right)) if !left.is_empty() && !right.is_empty() => {
            (partition.front, [left, right].map(PrimitiveBounds::around))
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
    plane_at: Vec4,
    front_is: u32,
    /// The length of the front so far.
    pub front: usize,
    /// The next primitive to look at.
    pub next: usize,
}

impl Partition {
    pub fn new(bins: &Bins, plane: &BinPlane) -> Self {
        let axis = plane.axis % 3;
        let mut plane_at = [f32::INFINITY; 4];
        plane_at[axis] = bins.coordinate_of(plane);
        let front_is = if plane.above_first { 1 << axis } else { 0 };
        Self { plane_at: Vec4::from_array(plane_at), front_is, front: 0, next: 0 }
    }

    /// Looks at up to `count` more primitives of all `primitives`.
    pub fn go_on(&mut self, primitives: &mut [Primitive], count: usize) {
        // Corner by corner: reading a primitive as one value that was just written as two corners would stall.
        let corners = Cell::from_mut(bytemuck::cast_slice_mut::<Primitive, Vec4>(primitives))
            .as_slice_of_cells();
        let (cells, _) = corners.as_chunks::<2>();
        let mut front = self.front;
        for [lo, hi] in cells.iter().skip(self.next).take(count) {
            let primitive: Primitive = bytemuck::must_cast([lo.get(), hi.get()]);
            let sides = primitive.doubled_centroid().cmpge(self.plane_at).bitmask();
            if let Some([first_lo, first_hi]) = cells.get(front) {
                lo.set(first_lo.get());
                hi.set(first_hi.get());
                let [primitive_lo, primitive_hi] = bytemuck::must_cast(primitive);
                first_lo.set(primitive_lo);
                first_hi.set(primitive_hi);
            }
            front += usize::from(sides == self.front_is);
        }
        self.front = front;
        self.next = (self.next + count).min(primitives.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_rounded_as_by_sqrtf() {
        for (number, root) in ROOTS.iter().enumerate() {
            assert_eq!(root.to_bits(), libm::sqrtf(number as f32).to_bits(), "{number}");
        }
    }
}
