//! Which triangles go together.
//!
//! Triangles are divided in two until eight or fewer are left: a join of clusters into those that were joined,
//! other triangles by the best plane of all axes by estimated tests. A test of up to eight triangles costs the
//! same, so counts are rounded up to full leaves: this fills them.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec4};

use super::{BALANCED_FROM, LANES};
use crate::cluster::{Clusters, MAX_TREE_DEPTH};
use crate::memory::{ClusterNode, NodeId};
use crate::{Aabb, Mesh, Triangle, Vec3};

/// Bins an axis, and for fewer triangles than `FEW`: there, sweeping over the bins is most of the work. 8
/// for all cost about 2% more steps, 32 were no better.
const BINS: usize = 16;
const BINS_OF_FEW: usize = 8;
const FEW: usize = 48;

/// A box, in registers of four; the last component is not used.
///
/// No coordinate is -0.0, so the least and the largest are the same on every target.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::indices) struct Box4 {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Box4 {
    pub const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    /// The smallest box around some items.
    pub fn around(items: &[Item]) -> Self {
        items.iter().fold(Self::EMPTY, |all, item| all.union(item.0))
    }

    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// In three components.
    pub fn aabb(self) -> Aabb {
        Aabb::new(self.lo.truncate(), self.hi.truncate())
    }

    /// Half the surface.
    pub fn surface(&self) -> f32 {
        let [x, y, z, _] = (self.hi - self.lo).to_array();
        x * y + y * z + z * x
    }

    /// The middle; halves are summed, so nothing overflows.
    fn middle(&self) -> Vec4 {
        self.lo * 0.5 + self.hi * 0.5
    }
}

/// A triangle while it is being sorted into the tree: its box, and in the fourth components its id, the
/// upper 16 bits and the lower as numbers.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub(in crate::indices) struct Item(Box4);

impl Item {
    fn new(triangle: &Triangle, id: u32) -> Self {
        let bounds = triangle.bounds();
        let (lo, hi) = (bounds.lo + Vec3::ZERO, bounds.hi + Vec3::ZERO);
        Self(Box4 { lo: lo.extend((id >> 16) as f32), hi: hi.extend((id & 0xffff) as f32) })
    }

    pub fn id(&self) -> u32 {
        (self.0.lo.w as u32) << 16 | self.0.hi.w as u32
    }

    pub fn largest_coordinate(&self) -> f32 {
        self.0.lo.abs().max(self.0.hi.abs()).truncate().max_element()
    }
}

/// A part of the triangles, and where it stands.
#[derive(Clone, Copy)]
pub(super) enum Place {
    /// A join of clusters.
    Join(NodeId),
    /// In a cluster, so many divisions below it.
    Inside(Part, u32),
}

/// What is known of some items.
#[derive(Clone, Copy)]
pub(super) struct Part {
    bounds: Box4,
    /// The box around the middles of their boxes.
    middles: Box4,
}

impl Part {
    fn around(items: &[Item]) -> Self {
        let middles = items.iter().fold(Box4::EMPTY, |all, item| {
            let middle = item.0.middle();
            all.union(Box4 { lo: middle, hi: middle })
        });
        Self { bounds: Box4::around(items), middles }
    }
}

pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Tests of so many triangles.
fn tests(count: usize) -> f32 {
    count.div_ceil(LANES) as f32
}

/// Divides triangles: those of a join of clusters into what was joined, others where it costs least.
pub(super) struct Divider<'b> {
    nodes: &'b [ClusterNode],
    /// The triangles below each of them.
    counts: &'b [u32],
}

impl<'b> Divider<'b> {
    /// Files the triangles so that each node of the cluster tree has a run of its own; `counts` is as long as
    /// there are nodes.
    pub fn new(
        items: &mut [Item],
        counts: &'b mut [u32],
        triangles: Mesh<'_>,
        clusters: &Clusters<'_>,
        nodes: &'b [ClusterNode],
    ) -> Self {
        count_triangles(counts, clusters, nodes);
        let divider = Self { nodes, counts };
        divider.file(items, triangles, clusters);
        divider
    }

    /// Where the whole stands.
    pub fn root(&self, items: &[Item]) -> Place {
        self.place((self.nodes.len() as u32).saturating_sub(1), items)
    }

    /// Where a node of the cluster tree stands.
    fn place(&self, id: u32, items: &[Item]) -> Place {
        // Leaves come first, and there is one more of them than of joins.
        if id as usize > self.nodes.len() / 2 {
            Place::Join(NodeId(id))
        } else {
            Place::Inside(Part::around(items), 0)
        }
    }

    /// Half the surface of a part.
    pub fn surface(&self, place: &Place) -> f32 {
        match *place {
            Place::Inside(part, _) => part.bounds.surface(),
            Place::Join(join) => self.nodes.get(join.0 as usize).map_or(0.0, surface),
        }
    }

    fn file(&self, items: &mut [Item], triangles: Mesh<'_>, clusters: &Clusters<'_>) {
        let mut slots = items.iter_mut();
        let mut stack = heapless::Vec::<usize, { MAX_TREE_DEPTH + 1 }>::new();
        let mut next = self.nodes.len().checked_sub(1);
        while let Some(at) = next.or_else(|| stack.pop()) {
            next = None;
            if at < clusters.count() {
                for (&id, slot) in clusters.get(at).iter().zip(slots.by_ref()) {
                    let triangle = triangles.get(id).unwrap_or_default();
                    *slot = Item::new(&triangle, id);
                }
            } else if let Some(node) = self.nodes.get(at) {
                let [first, second] = self.cheaper_first(node).map(|link| link as usize);
                let pushed = stack.push(second).is_ok();
                debug_assert!(pushed, "one for each level");
                next = Some(first);
            }
        }
    }

    /// What a node of the cluster tree joins: first what costs less to test.
    fn cheaper_first(&self, node: &ClusterNode) -> [u32; 2] {
        let cost = |link: u32| {
            let (node, count) = (self.nodes.get(link as usize), self.counts.get(link as usize));
            node.zip(count).map_or(0.0, |(node, &count)| surface(node) * tests(count as usize))
        };
        let [left, right] = node.links;
        if cost(right) < cost(left) { [right, left] } else { [left, right] }
    }

    /// Sorts more than eight items into two parts, one behind the other, and returns the length of the first,
    /// which is the one that costs less. So it gets the lower lane: where a ray enters both at once, as one
    /// that begins in both, it is the cheaper to be asked first.
    pub fn divide(&self, items: &mut [Item], place: &Place) -> (usize, [Place; 2]) {
        match *place {
            Place::Join(join) => {
                let node = self.nodes.get(join.0 as usize);
                let links = node.map_or([0; 2], |node| self.cheaper_first(node));
                let length = self.counts.get(links[0] as usize).map_or(0, |&count| count as usize);
                let (left, right) = items.split_at_checked(length).unwrap_or_default();
                (length, [self.place(links[0], left), self.place(links[1], right)])
            }
            Place::Inside(ref part, depth) => {
                let (length, parts) =
                    if depth < BALANCED_FROM { halve(items, part) } else { in_equal_parts(items) };
                (length, parts.map(|part| Place::Inside(part, depth + 1)))
            }
        }
    }
}

/// Half the surface of a node of the cluster tree.
fn surface(node: &ClusterNode) -> f32 {
    let [x, y, z] = (node.bounds.hi - node.bounds.lo).to_array();
    x * y + y * z + z * x
}

/// How many triangles are below each node of the cluster tree.
fn count_triangles(counts: &mut [u32], clusters: &Clusters<'_>, nodes: &[ClusterNode]) {
    for at in 0..counts.len() {
        let count = if at < clusters.count() {
            clusters.get(at).len() as u32
        } else {
            let below = |link: u32| counts.get(link as usize).copied().unwrap_or(0);
            nodes.get(at).map_or(0, |node| below(node.links[0]) + below(node.links[1]))
        };
        if let Some(slot) = counts.get_mut(at) {
            *slot = count;
        }
    }
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
        let places = ((item.0.middle() - self.from) * self.scale).min(Vec4::splat(self.last));
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
            (*lo, *hi) = (lo.min(item.0.lo), hi.max(item.0.hi));
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
        let tests = self.counts.map(|count| (((count - 1) >> LANES.ilog2()) + 1) as f32);
        (x * y + y * z + z * x) * Vec4::from_array(tests)
    }
}

/// Divides more than eight items in two by the least estimated cost, and returns the length of the
/// first part and what both are; in equal parts where no plane tells them apart.
fn halve(items: &mut [Item], part: &Part) -> (usize, [Part; 2]) {
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
fn in_equal_parts(items: &[Item]) -> (usize, [Part; 2]) {
    let half = items.len() / 2;
    let (left, right) = items.split_at_checked(half).unwrap_or_default();
    (half, [left, right].map(Part::around))
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
        let middle = first.0.middle();
        let is_above = (middle.to_array()[axis] - from) * scale >= from_bin;
        let there = Box4 { lo: middle, hi: middle };
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
