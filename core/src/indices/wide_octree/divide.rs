//! Which triangles go together.
//!
//! Triangles are divided in two until eight or fewer are left: a join of clusters into those that were joined,
//! other triangles by the best plane of all axes by estimated tests. A test of up to eight triangles costs the
//! same, so counts are rounded up to full leaves: this fills them.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

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

/// Where a part stands.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// The join of clusters that it is, if it is one.
    join: Option<NodeId>,
    /// The divisions above it in its cluster.
    depth: u32,
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
    pub fn root(&self) -> Place {
        Place { join: self.join((self.nodes.len() as u32).saturating_sub(1)), depth: 0 }
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
            node.zip(count).map_or(0.0, |(node, &count)| {
                let [x, y, z] = (node.bounds.hi - node.bounds.lo).to_array();
                (x * y + y * z + z * x) * tests(count as usize)
            })
        };
        let [left, right] = node.links;
        if cost(right) < cost(left) { [right, left] } else { [left, right] }
    }

    /// The node, if it is a join.
    fn join(&self, id: u32) -> Option<NodeId> {
        // Leaves come first, and there is one more of them than of joins.
        (id as usize > self.nodes.len() / 2).then_some(NodeId(id))
    }

    /// Sorts more than eight items into two parts, one behind the other, and returns the length of the first,
    /// which is the one that costs less. So it gets the lower lane: where a ray enters both at once, as one
    /// that begins in both, it is the cheaper to be asked first.
    pub fn divide(&self, items: &mut [Item], place: Place) -> (usize, [Place; 2]) {
        let below = Place { join: None, depth: place.depth + 1 };
        if let Some(node) = place.join.and_then(|join| self.nodes.get(join.0 as usize)) {
            let links = self.cheaper_first(node);
            let length = self.counts.get(links[0] as usize).map_or(0, |&count| count as usize);
            (length, links.map(|link| Place { join: self.join(link), depth: 0 }))
        } else if place.depth >= BALANCED_FROM {
            (items.len() / 2, [below; 2])
        } else {
            (halve(items), [below; 2])
        }
    }
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

/// Divides more than eight items in two by the least estimated cost, and returns the length of the
/// first part; in equal parts where no plane tells them apart.
fn halve(items: &mut [Item]) -> usize {
    let bins = if items.len() < FEW { BINS_OF_FEW } else { BINS };
    let middles = items.iter().fold(Box4::EMPTY, |all, item| {
        let middle = item.0.middle();
        all.union(Box4 { lo: middle, hi: middle })
    });
    let scale = Vec4::splat(bins as f32) / (middles.hi - middles.lo);
    let bins_of = |item: &Item| {
        // The cast saturates, and takes a NaN (0 / 0) to 0.
        let [x, y, z, _] = ((item.0.middle() - middles.lo) * scale).to_array();
        [x, y, z].map(|place| (place as i32 as usize).min(bins - 1) % BINS)
    };

    let mut counts = [[0_usize; BINS]; 3];
    let mut boxes = [[Box4::EMPTY; BINS]; 3];
    for item in items.iter() {
        for (axis, bin) in bins_of(item).into_iter().enumerate() {
            counts[axis][bin] += 1;
            boxes[axis][bin] = boxes[axis][bin].union(item.0);
        }
    }
    let mut best: Option<(f32, usize, usize, bool)> = None;
    for (axis, (counts, boxes)) in counts.iter().zip(&boxes).enumerate() {
        let mut below = [0.0; BINS];
        let (mut sum, mut part) = (0, Box4::EMPTY);
        for ((cost, &count), bounds) in below.iter_mut().zip(counts).zip(boxes).take(bins) {
            sum += count;
            part = part.union(*bounds);
            *cost = part.surface() * tests(sum);
        }
        let (mut sum, mut part) = (0, Box4::EMPTY);
        for (bin, ((&count, bounds), below)) in
            (1..BINS).zip(counts.iter().zip(boxes).skip(1).zip(&below)).take(bins - 1).rev()
        {
            sum += count;
            part = part.union(*bounds);
            let above = part.surface() * tests(sum);
            let cost = below + above;
            let divides = sum > 0 && sum < items.len();
            if divides && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, bin, above < *below));
            }
        }
    }
    let Some((_, axis, bin, above_first)) = best else {
        return items.len() / 2;
    };
    // The cheaper to the front, the others to the back.
    let (mut front, mut back) = (0, items.len());
    while front < back {
        if items.get(front).is_some_and(|item| (bins_of(item)[axis % 3] < bin) != above_first) {
            front += 1;
        } else {
            back -= 1;
            if let (Some(&a), Some(&b)) = (items.get(front), items.get(back)) {
                if let Some(slot) = items.get_mut(front) {
                    *slot = b;
                }
                if let Some(slot) = items.get_mut(back) {
                    *slot = a;
                }
            }
        }
    }
    front
}
