//! Where some triangles are divided in two: by the plane of the least estimated cost.
//!
//! ```text
//! primitives, or a sample -> bins along each axis -> planes between them -> the cheapest -> primitives below and above
//! ```

use core::cell::Cell;

use glam::{Mat4, Vec4};

use super::primitive::{Primitive, PrimitiveBounds};
use crate::geometry::Box4;
use crate::indices::wide::rows::LANES;

/// Bins an axis, and for fewer triangles than `FEW`: there, sweeping over the bins is most of the work. 8
/// for all cost about 2% more steps, 32 were no better. 4 or 6 for at most 16 triangles were no faster.
const BINS: usize = 16;
const BINS_OF_FEW: usize = 8;
const FEW: usize = 48;

/// Of so many primitives and more, every third is binned, or every fifth: it takes a tenth to a sixth less time, and a ray
/// enters 2% fewer to 1.5% more nodes. Odd, because scenes are made of pairs and dozens.
///
/// What lost: up to every fifteenth, which was hardly faster, and in a city with a large floor cost 4% more nodes;
/// doing that over with all primitives where the sides turn out costlier than the sample had it, which in that city took
/// all that was gained; cells of neighbours along a Morton curve as the primitives of the upper levels, which was no faster
/// than this, with 1 to 5% more nodes and half as much scratch again.
const EVERY_THIRD: usize = 256;
const EVERY_FIFTH: usize = 1024;

/// Divides more than eight primitives in two by the least estimated cost, and returns the length of the
/// first part and what both are; in equal parts where no plane tells them apart.
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

fn split_by_bins<const N: usize>(
    primitives: &mut [Primitive],
    part: &PrimitiveBounds,
) -> (usize, [PrimitiveBounds; 2]) {
    let bins = Bins::new(part, N);
    match Binned::<N>::new(primitives, &bins).best_plane() {
        Some(plane) => sort_by_plane(primitives, &bins, &plane),
        None => split_equally(primitives),
    }
}

#[cold]
#[inline(never)]
pub(crate) fn split_equally(primitives: &[Primitive]) -> (usize, [PrimitiveBounds; 2]) {
    let half = primitives.len() / 2;
    let (left, right) = primitives.split_at_checked(half).unwrap_or_default();
    (half, [left, right].map(PrimitiveBounds::around))
}

/// Tests of so many triangles. In the numbers that vectors have.
pub(crate) fn leaf_tests(count: i32) -> f32 {
    (((count - 1) >> LANES.ilog2()) + 1) as f32
}

/// How the centroids of a part are binned along each axis.
struct Bins {
    from: Vec4,
    scale: Vec4,
}

impl Bins {
    fn new(part: &PrimitiveBounds, count: usize) -> Self {
        let Box4 { lo, hi } = part.centroids;
        // So that the largest middle is in the last bin, not beyond it, and one where a bin begins in that bin.
        let count = count as f32;
        let scale = Vec4::splat(count - BIN_ERROR * (1.0 + 0.5 / count)) / (hi - lo);
        // Where the centroids do not differ, or too little or too much for a number, all are in the first bin.
        let usable = scale.cmpgt(Vec4::ZERO) & scale.cmplt(Vec4::INFINITY);
        let or_zero = |numbers| Vec4::select(usable, numbers, Vec4::ZERO);
        Self { from: or_zero(lo), scale: or_zero(scale) }
    }

    /// The bin along each axis; the next where it is that by rounding.
    #[inline(always)]
    fn of(&self, primitive: &Primitive) -> [usize; 3] {
        // A cast, which saturates, would be many more instructions.
        let positions =
            (primitive.doubled_centroid() - self.from) * self.scale + Vec4::splat(INTEGERS);
        let [x, y, z, _] = positions.to_array();
        [x, y, z].map(|position| position.to_bits() as usize >> FRACTION_BITS)
    }

    /// Where a plane lies along its axis: as far below the bin as a middle may be and still be rounded into it.
    fn coordinate_of(&self, plane: &BinPlane) -> f32 {
        let axis = plane.axis % 3;
        self.from.to_array()[axis] + (plane.bin as f32 - BIN_ERROR) / self.scale.to_array()[axis]
    }
}

/// From here on, the last bits of a number are an integer and so many bits behind the point.
const INTEGERS: f32 = 131_072.0; // 2^17
const FRACTION_BITS: u32 = 6;
/// By which the place of a middle is rounded, in bins.
const BIN_ERROR: f32 = 1.0 / 128.0;

/// What lies in each of `N` bins of each axis.
///
/// The corners of the boxes lie apart, so that one offset in bytes serves them and the counts.
/// Boxes of eight numbers, the upper corner negated so that one minimum is enough, took twice as long: the
/// compiler stores them through masks.
struct Binned<const N: usize> {
    lo: [[Vec4; N]; 3],
    hi: [[Vec4; N]; 3],
    /// Along x, y and z.
    counts: [[i32; 4]; N],
}

/// A plane across an axis.
struct BinPlane {
    axis: usize,
    /// The first bin above it.
    bin: usize,
    /// Whether what lies above costs less than what lies below.
    above_first: bool,
}

impl<const N: usize> Binned<N> {
    fn new(primitives: &[Primitive], bins: &Bins) -> Self {
        let Box4 { lo, hi } = Box4::EMPTY;
        let mut binned = Self { lo: [[lo; N]; 3], hi: [[hi; N]; 3], counts: [[0; 4]; N] };
        if primitives.len() >= EVERY_THIRD {
            let stride = if primitives.len() >= EVERY_FIFTH { 5_u8 } else { 3 };
            for primitive in primitives.iter().step_by(stride.into()) {
                binned.add(primitive, stride.into(), bins);
            }
            return binned;
        }
        // Neighbours fall into the same bin, and would wait for each other: one after the other took up to a
        // tenth longer.
        let (left, right) = primitives.split_at_checked(primitives.len() / 2).unwrap_or_default();
        for (left, right) in left.iter().zip(right) {
            binned.add(left, 1, bins);
            binned.add(right, 1, bins);
        }
        if let [.., last] = right
            && right.len() > left.len()
        {
            binned.add(last, 1, bins);
        }
        binned
    }

    /// Adds an primitive that stands for some.
    #[inline(always)]
    fn add(&mut self, primitive: &Primitive, count: i32, bins: &Bins) {
        for (axis, bin) in bins.of(primitive).into_iter().enumerate() {
            self.counts[bin % N][axis] += count;
            let (lo, hi) = (&mut self.lo[axis][bin % N], &mut self.hi[axis][bin % N]);
            let bounds = primitive.bounds();
            (*lo, *hi) = (lo.min(bounds.lo), hi.max(bounds.hi));
        }
    }

    /// The plane of the least estimated cost; of equals, the first axis, the highest bin. `None` where no
    /// plane tells the primitives apart, or its cost overflows.
    fn best_plane(&self) -> Option<BinPlane> {
        // All axes at once. Where one side is empty, its cost is not a number, and never less.
        let mut below = [Vec4::ZERO; N];
        let mut side = Sides::EMPTY;
        for (bin, cost) in below.iter_mut().enumerate().skip(1) {
            side.add(self, bin - 1);
            *cost = side.costs();
        }
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

/// What lies on one side of a plane across each axis.
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
        (x * y + y * z + z * x) * Vec4::from_array(self.counts.map(leaf_tests))
    }
}

/// Sorts primitives to the sides of a plane, the cheaper to the front, and returns how many are there and what both are.
///
/// Without a branch that depends on an primitive, as half of those would be mispredicted: the build takes a tenth less
/// time. Finding the sides of 32 primitives from either end and then changing only those that stand wrong took as long,
/// and so did a stable order by way of spare memory.
fn sort_by_plane(
    primitives: &mut [Primitive],
    bins: &Bins,
    plane: &BinPlane,
) -> (usize, [PrimitiveBounds; 2]) {
    let axis = plane.axis % 3;
    let mut plane_at = [f32::INFINITY; 4];
    plane_at[axis] = bins.coordinate_of(plane);
    let plane_at = Vec4::from_array(plane_at);
    let front_is = if plane.above_first { 1 << axis } else { 0 };
    // Corner by corner: an primitive read as one where it was just written as two is waited for.
    let corners =
        Cell::from_mut(bytemuck::cast_slice_mut::<Primitive, Vec4>(primitives)).as_slice_of_cells();
    let (cells, _) = corners.as_chunks::<2>();
    let mut front = 0;
    for [lo, hi] in cells {
        let primitive: Primitive = bytemuck::must_cast([lo.get(), hi.get()]);
        let is_front = primitive.doubled_centroid().cmpge(plane_at).bitmask() == front_is;
        if let Some([first_lo, first_hi]) = cells.get(front) {
            lo.set(first_lo.get());
            hi.set(first_hi.get());
            let [primitive_lo, primitive_hi] = bytemuck::must_cast(primitive);
            first_lo.set(primitive_lo);
            first_hi.set(primitive_hi);
        }
        front += usize::from(is_front);
    }
    match primitives.split_at_checked(front) {
        Some((left, right)) if !left.is_empty() && !right.is_empty() => {
            (front, [left, right].map(PrimitiveBounds::around))
        }
        // The plane lies beside all centroids, by rounding.
        _ => split_equally(primitives),
    }
}
