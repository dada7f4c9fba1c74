//! Where some triangles are divided in two: by the plane of the least estimated cost.
//!
//! ```text
//! items -> bins along each axis -> planes between them -> the cheapest -> items below and above
//! ```

use glam::{Mat4, Vec4};

use super::LANES;
use super::item::{Box4, Item, Part};

/// Bins an axis, and for fewer triangles than `FEW`: there, sweeping over the bins is most of the work. 8
/// for all cost about 2% more steps, 32 were no better.
const BINS: usize = 16;
const BINS_OF_FEW: usize = 8;
const FEW: usize = 48;

/// Divides more than eight items in two by the least estimated cost, and returns the length of the
/// first part and what both are; in equal parts where no plane tells them apart.
pub(super) fn halve(items: &mut [Item], part: &Part) -> (usize, [Part; 2]) {
    if items.len() < FEW {
        halve_by::<BINS_OF_FEW>(items, part)
    } else {
        halve_by::<BINS>(items, part)
    }
}

fn halve_by<const N: usize>(items: &mut [Item], part: &Part) -> (usize, [Part; 2]) {
    let bins = Bins::new(part, N);
    let binned = Binned::<N>::new(items, &bins);
    let Some(plane) = binned.best_plane() else {
        return in_equal_parts(items);
    };
    let [below, above] = binned.boxes_of_sides(&plane);
    let bounds = if plane.above_first { [above, below] } else { [below, above] };
    let (front, middles) = sort_by_plane(items, &bins, &plane);
    let [first, second] = [0, 1].map(|at| Part { bounds: bounds[at], middles: middles[at] });
    (front, [first, second])
}

#[cold]
#[inline(never)]
pub(super) fn in_equal_parts(items: &[Item]) -> (usize, [Part; 2]) {
    let half = items.len() / 2;
    let (left, right) = items.split_at_checked(half).unwrap_or_default();
    (half, [left, right].map(Part::around))
}

/// Tests of so many triangles. In the numbers that vectors have.
pub(super) fn tests(count: i32) -> f32 {
    (((count - 1) >> LANES.ilog2()) + 1) as f32
}

/// How the middles of a part are binned along each axis.
struct Bins {
    from: Vec4,
    scale: Vec4,
    last: f32,
}

impl Bins {
    fn new(part: &Part, count: usize) -> Self {
        let Box4 { lo, hi } = part.middles;
        let scale = Vec4::splat(count as f32) / (hi - lo);
        // Where the middles do not differ, or too little or too much for a number, all are in the first bin.
        let usable = scale.cmpgt(Vec4::ZERO) & scale.cmplt(Vec4::INFINITY);
        let or_zero = |numbers| Vec4::select(usable, numbers, Vec4::ZERO);
        Self { from: or_zero(lo), scale: or_zero(scale), last: (count - 1) as f32 }
    }

    /// The bin along each axis.
    fn of(&self, item: &Item) -> [usize; 3] {
        // A cast, which saturates, would be many more instructions.
        let places = ((item.middle() - self.from) * self.scale).min(Vec4::splat(self.last));
        let rounded = places + Vec4::splat(INTEGERS);
        let is_above = (rounded - Vec4::splat(INTEGERS)).cmpgt(places);
        let floor = rounded - Vec4::select(is_above, Vec4::ONE, Vec4::ZERO);
        let [x, y, z, _] = floor.to_array();
        [x, y, z].map(|bin| bin.to_bits() as usize)
    }
}

/// From here on the last bits of a number are an integer.
const INTEGERS: f32 = 8_388_608.0; // 2^23

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
struct Plane {
    axis: usize,
    /// The first bin above it.
    bin: usize,
    /// Whether what lies above costs less than what lies below.
    above_first: bool,
}

impl<const N: usize> Binned<N> {
    fn new(items: &[Item], bins: &Bins) -> Self {
        let Box4 { lo, hi } = Box4::EMPTY;
        let mut binned = Self { lo: [[lo; N]; 3], hi: [[hi; N]; 3], counts: [[0; 4]; N] };
        // Neighbours fall into the same bin, and would wait for each other: one after the other took up to a
        // tenth longer.
        let (left, right) = items.split_at_checked(items.len() / 2).unwrap_or_default();
        for (left, right) in left.iter().zip(right) {
            binned.add(left, bins);
            binned.add(right, bins);
        }
        if let [.., last] = right
            && right.len() > left.len()
        {
            binned.add(last, bins);
        }
        binned
    }

    #[inline(always)]
    fn add(&mut self, item: &Item, bins: &Bins) {
        for (axis, bin) in bins.of(item).into_iter().enumerate() {
            self.counts[bin % N][axis] += 1;
            let (lo, hi) = (&mut self.lo[axis][bin % N], &mut self.hi[axis][bin % N]);
            let bounds = item.bounds();
            (*lo, *hi) = (lo.min(bounds.lo), hi.max(bounds.hi));
        }
    }

    /// The plane of the least estimated cost; of equals, the first axis, the highest bin. `None` where no
    /// plane tells the items apart, or its cost overflows.
    fn best_plane(&self) -> Option<Plane> {
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
                best =
                    Some(Plane { axis, bin: bins[axis] as usize, above_first: steps[axis] < 0.0 });
            }
        }
        best
    }

    /// What lies below a plane, and above it.
    fn boxes_of_sides(&self, plane: &Plane) -> [Box4; 2] {
        let mut sides = [Box4::EMPTY; 2];
        let corners = self.lo[plane.axis % 3].iter().zip(&self.hi[plane.axis % 3]);
        for (bin, (&lo, &hi)) in corners.enumerate() {
            let side = &mut sides[usize::from(bin >= plane.bin)];
            *side = side.union(Box4 { lo, hi });
        }
        sides
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
        (x * y + y * z + z * x) * Vec4::from_array(self.counts.map(tests))
    }
}

/// Sorts items to the sides of a plane, the cheaper to the front, and returns how many are there and
/// the middles of both.
///
/// By way of a spare half, in order and without a branch that depends on an item, it took as long, and longer
/// on a mesh.
fn sort_by_plane(items: &mut [Item], bins: &Bins, plane: &Plane) -> (usize, [Box4; 2]) {
    let axis = plane.axis % 3;
    let (from, scale) = (bins.from.to_array()[axis], bins.scale.to_array()[axis]);
    let from_bin = plane.bin as f32;
    let mut middles = [Box4::EMPTY; 2];
    let mut front = 0;
    let mut rest = items;
    while let [first, ..] = rest {
        let middle = first.middle();
        let is_above = (middle.to_array()[axis] - from) * scale >= from_bin;
        let there = Box4::at(middle);
        if is_above == plane.above_first {
            middles[0] = middles[0].union(there);
            front += 1;
            let [_, others @ ..] = rest else { break };
            rest = others;
        } else {
            middles[1] = middles[1].union(there);
            match rest {
                [first, .., last] => core::mem::swap(first, last),
                _ => break,
            }
            let [others @ .., _] = rest else { break };
            rest = others;
        }
    }
    (front, middles)
}
