//! Bins of primitives along each axis, and the plane between them that costs least.

use core::hint::black_box;

use glam::{Mat4, Vec4};

use super::LEAF_TRIANGLES;
use super::box8::Box8;
use super::primitive::{Primitive, PrimitiveBounds};
use crate::geometry::Box4;
use crate::input::MOST_TRIANGLES;

/// Estimates the cost of the box of `count` triangles for a ray that enters it: the square root of their leaves.
///
/// The surface-area heuristic has the leaves themselves, as if a ray tested all of them. A ray that enters a subtree
/// tests only those along its way.
///
/// # Measured
/// - The leaves themselves: 3% to 4% more steps over the built-in scenes, a tenth more in cities.
/// - Powers of 5/8 and 3/4: 1% and 2% more than the root.
#[inline(always)]
pub(crate) fn cost_of(count: u32) -> f32 {
    let leaves = count.div_ceil(LEAF_TRIANGLES as u32);
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
    #[inline(always)]
    pub fn new(part: &PrimitiveBounds, count: usize) -> Self {
        let Box4 { lo, hi } = part.centroids;
        // Scaled down by a little more than the error, so that the largest centroid is not rounded into bin `count`; by
        // less than the error at the start of any other bin, so that a centroid there is rounded up into it.
        let count = count as f32;
        let scale = Vec4::splat(count - BIN_ERROR * (1.0 + 0.5 / count)) / (hi - lo);
        // On an axis on which the centroids do not differ, or too little or too much for an `f32`, all are in the first
        // bin: numbers from 0 times 0 are 0, and infinity times 0 is NaN, whose last bits are 0 on all processors for which
        // digests are compared.
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
    #[inline(always)]
    pub fn coordinate_of(&self, plane: &BinPlane) -> f32 {
        let axis = plane.axis % 3;
        self.from.to_array()[axis] + (plane.bin - BIN_ERROR) / self.scale.to_array()[axis]
    }
}

/// Number from which on the last bits of an `f32` are an integer and `FRACTION_BITS` bits behind the point.
const INTEGERS: f32 = 131_072.0; // 2^17
const FRACTION_BITS: u32 = 6;
/// Error in bins of a rounded centroid.
const BIN_ERROR: f32 = 1.0 / 128.0;

/// Contents of the `N` bins of each axis.
///
/// The number beside the lower corner is the negated count of the primitives of the bin. It is never above 0, so the
/// minimum with that of a primitive leaves it.
///
/// # What lost
/// - Counts in an array of their own: a primitive is binned in 8 cycles instead of 6, with AVX2.
/// - Two sets of bins in turns, so that neighbours in one bin do not wait for each other: from 3% less to 5% more time
///   to build, by what the compiler makes of it, and 3 KB of stack.
pub(super) struct Binned<const N: usize> {
    bins: [[Box8; N]; 3],
}

/// Plane between two bins of an axis.
pub(super) struct BinPlane {
    pub axis: usize,
    /// The first bin above the plane, as a number.
    bin: f32,
    /// True if what lies above costs less than what lies below.
    pub above_first: bool,
}

impl<const N: usize> Binned<N> {
    pub const EMPTY: Self = Self { bins: [[Box8::EMPTY.with_number(0.0); N]; 3] };

    /// Adds each primitive, or one in `stride`, to its bin on each axis.
    #[inline(always)]
    pub fn add_all(&mut self, primitives: &[Primitive], stride: u8, bins: &Bins) {
        // Hidden from the compiler, which would else add the one number alone, in an instruction of its own.
        let one = black_box([-0.0, -0.0, -0.0, -1.0, -0.0, -0.0, -0.0, -0.0]);
        if stride > 1 {
            for primitive in primitives.iter().step_by(stride.into()) {
                self.add(primitive, &one, bins);
            }
            return;
        }
        // Neighbours fall into the same bin, and would wait for each other. So primitives of both halves alternate: one
        // after the other took up to a tenth longer.
        let (left, right) = primitives.split_at_checked(primitives.len() / 2).unwrap_or_default();
        for (left, right) in left.iter().zip(right) {
            self.add(left, &one, bins);
            self.add(right, &one, bins);
        }
        if let [.., last] = right
            && right.len() > left.len()
        {
            self.add(last, &one, bins);
        }
    }

    #[inline(always)]
    fn add(&mut self, primitive: &Primitive, one: &[f32; 8], bins: &Bins) {
        for (binned, bin) in self.bins.iter_mut().zip(bins.of(primitive)) {
            let binned = &mut binned[bin % N];
            *binned = binned.union(primitive.bounds()).plus(one);
        }
    }

    /// Finds the plane of least SAH cost; of equals, the first axis, then the highest bin. `None` where no plane
    /// separates the primitives, or all costs overflow. Each primitive stands for `stride`.
    #[inline(always)]
    pub fn best_plane(&self, stride: u8) -> Option<BinPlane> {
        // 1. Sweep upwards: the costs below each plane, on all axes at once. The cost of an empty side is NaN, and
        // never less.
        let mut below = [Vec4::ZERO; N];
        let mut side = Sides::EMPTY;
        for (bin, cost) in below.iter_mut().enumerate().skip(1) {
            side.add(self, bin - 1);
            *cost = side.costs(stride);
        }
        // 2. Sweep downwards: add the costs above, and keep the least sum of each axis.
        let mut least = Vec4::INFINITY;
        let (mut bins, mut steps) = (Vec4::ZERO, Vec4::ZERO);
        let mut side = Sides::EMPTY;
        for (bin, below) in below.into_iter().enumerate().skip(1).rev() {
            side.add(self, bin);
            let above = side.costs(stride);
            let costs = below + above;
            let less = costs.cmplt(least);
            least = Vec4::select(less, costs, least);
            bins = Vec4::select(less, Vec4::splat(bin as f32), bins);
            steps = Vec4::select(less, above - below, steps);
        }
        // 3. Choose the axis.
        let mut best = None;
        let mut least_of_all = f32::INFINITY;
        for (axis, least) in least.to_array().into_iter().enumerate().take(3) {
            if least < least_of_all {
                least_of_all = least;
                best = Some(axis);
            }
        }
        best.map(|axis| BinPlane {
            axis,
            bin: bins.to_array()[axis],
            above_first: steps.to_array()[axis] < 0.0,
        })
    }
}

/// Contents of one side of a plane across each axis.
struct Sides {
    boxes: [Box8; 3],
    /// The negated counts of primitives.
    counts: [f32; 3],
}

impl Sides {
    const EMPTY: Self = Self { boxes: [Box8::EMPTY; 3], counts: [0.0; 3] };

    #[inline(always)]
    fn add<const N: usize>(&mut self, binned: &Binned<N>, bin: usize) {
        let sides = self.boxes.iter_mut().zip(&mut self.counts);
        for ((all, count), bins) in sides.zip(&binned.bins) {
            let bin = bins[bin % N];
            *all = all.union(bin);
            *count += bin.numbers()[0];
        }
    }

    #[inline(always)]
    fn costs(&self, stride: u8) -> Vec4 {
        // The areas of negated lengths are the areas.
        let [a, b, c] = self.boxes.map(|part| part.negated_size());
        let Mat4 { x_axis: x, y_axis: y, z_axis: z, .. } = Mat4::from_cols(a, b, c, c).transpose();
        let [a, b, c] = self.counts.map(|count| {
            // The difference has the count in its last bits. A cast would saturate, which takes more instructions.
            let count = (MOST_COUNTED as f32 - count).to_bits() & (MOST_COUNTED - 1);
            cost_of(count * u32::from(stride))
        });
        (x * y + y * z + z * x) * Vec4::new(a, b, c, 0.0)
    }
}

/// Number from which on the last bits of an `f32` are an integer; what is added has to be less.
pub(super) const MOST_COUNTED: u32 = 1 << 23;
const _: () = assert!(MOST_TRIANGLES.div_ceil(129) < MOST_COUNTED as usize);

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
