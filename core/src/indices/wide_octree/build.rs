//! Building from above.
//!
//! A node's triangles are divided in two, then the costliest part again, until there are eight parts
//! or none is left to divide: a join of clusters into those that were joined, other triangles by the best
//! plane of all axes by estimated tests. A test of up to eight triangles costs the same, so counts are
//! rounded up to full leaves: this fills them.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use super::{
    BALANCED_FROM, EMPTY, HEAD_ROWS, LANES, LEAF_ROWS, NO_ID, NODE_ROWS, ROW_MASK, leaf_link,
};
use crate::cluster::{Clusters, MAX_TREE_DEPTH};
use crate::indices::Division;
use crate::memory::{Arena, ClusterNode, NodeId, Words, size_of_slice};
use crate::{BuildError, Triangle, Vec3};

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
struct Box4 {
    lo: Vec4,
    hi: Vec4,
}

impl Box4 {
    const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Half the surface.
    fn surface(&self) -> f32 {
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
struct Item(Box4);

impl Item {
    fn new(triangle: &Triangle, id: u32) -> Self {
        let bounds = triangle.bounds();
        let (lo, hi) = (bounds.lo + Vec3::ZERO, bounds.hi + Vec3::ZERO);
        Self(Box4 { lo: lo.extend((id >> 16) as f32), hi: hi.extend((id & 0xffff) as f32) })
    }

    fn id(&self) -> u32 {
        (self.0.lo.w as u32) << 16 | self.0.hi.w as u32
    }

    fn largest_coordinate(&self) -> f32 {
        self.0.lo.abs().max(self.0.hi.abs()).truncate().max_element()
    }
}

pub(super) const fn scratch_bytes(triangle_count: usize) -> usize {
    let counts = size_of_slice::<u32>(triangle_count.saturating_mul(2));
    size_of_slice::<Item>(triangle_count).saturating_add(counts)
}

pub(super) fn build(
    division: Division<'_>,
    words: &mut Words<'_>,
    scratch: &mut [u8],
) -> Result<(), BuildError> {
    let Division { triangles, clusters, nodes } = division;
    let count = triangles.len();
    let full = BuildError::ScratchFull { needed: scratch_bytes(count), given: scratch.len() };
    // Every triangle a leaf, and a node for every two children.
    if count.saturating_mul((LEAF_ROWS + NODE_ROWS) as usize) >= ROW_MASK as usize {
        return Err(BuildError::TooLarge);
    }
    if count == 0 {
        return Ok(());
    }
    let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
    let items = arena.take::<Item>(count).ok_or(full)?;
    let counts = arena.take::<u32>(nodes.len()).ok_or(full)?;
    sort_by_cluster_tree(items, triangles, clusters, nodes);
    count_triangles(counts, clusters, nodes);

    let head = words.len();
    words.extend(&[0; HEAD_ROWS as usize * LANES]);
    let largest = items.iter().fold(0.0, |all, item| larger(all, item.largest_coordinate()));
    let root = NodeId((nodes.len() as u32).saturating_sub(1));
    let builder = Builder { triangles, nodes, counts, words: &mut *words };
    let (link, edge) = builder.all(items, root);
    words.set(head, link);
    words.set(head + 1, edge.to_bits());
    words.set(head + 2, largest.to_bits());
    // One index over all clusters: it belongs to the first.
    for (leaf, _) in nodes.iter_mut().zip(clusters.iter()) {
        leaf.links = [words.len() as u32, 0];
    }
    if let Some(first) = nodes.first_mut() {
        first.links = [0, words.len() as u32];
    }
    Ok(())
}

/// Files the triangles so that each node of the cluster tree has a run of its own.
fn sort_by_cluster_tree(
    items: &mut [Item],
    triangles: &[Triangle],
    clusters: &Clusters<'_>,
    nodes: &[ClusterNode],
) {
    let mut slots = items.iter_mut();
    let mut stack = heapless::Vec::<usize, { MAX_TREE_DEPTH + 1 }>::new();
    let mut next = nodes.len().checked_sub(1);
    while let Some(at) = next.or_else(|| stack.pop()) {
        next = None;
        if at < clusters.count() {
            for (&id, slot) in clusters.get(at).iter().zip(slots.by_ref()) {
                let triangle = triangles.get(id as usize).copied().unwrap_or_default();
                *slot = Item::new(&triangle, id);
            }
        } else if let Some(node) = nodes.get(at) {
            let [left, right] = node.links.map(|link| link as usize);
            let pushed = stack.push(right).is_ok();
            debug_assert!(pushed, "one for each level");
            next = Some(left);
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

/// A run of items, and the join of clusters that it is, if it is one.
#[derive(Clone, Copy)]
struct Part {
    from: usize,
    to: usize,
    bounds: Box4,
    join: Option<NodeId>,
}

impl Part {
    fn of(items: &[Item], from: usize, to: usize, join: Option<NodeId>) -> Self {
        let part = items.get(from..to).unwrap_or(&[]);
        let bounds = part.iter().fold(Box4::EMPTY, |all, item| all.union(item.0));
        Self { from, to, bounds, join }
    }

    fn count(&self) -> usize {
        self.to - self.from
    }
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Tests of so many triangles.
fn tests(count: usize) -> f32 {
    count.div_ceil(LANES) as f32
}

struct Builder<'b, 'w> {
    triangles: &'b [Triangle],
    nodes: &'b [ClusterNode],
    /// The triangles below each of them.
    counts: &'b [u32],
    words: &'b mut Words<'w>,
}

impl Builder<'_, '_> {
    fn row(&self) -> u32 {
        (self.words.len() / LANES) as u32
    }

    /// The node, if it is a join.
    fn join(&self, id: NodeId) -> Option<NodeId> {
        // Leaves come first, and there is one more of them than of joins.
        (id.0 as usize > self.nodes.len() / 2).then_some(id)
    }

    /// Appends everything, and returns the link to it and its edge.
    fn all(mut self, items: &mut [Item], root: NodeId) -> (u32, f32) {
        let join = self.join(root);
        self.subtree(items, join, 0)
    }

    /// Appends the subtree of some triangles, and returns the link to it and its edge. As deep a recursion
    /// as the tree; `depth` counts from the clusters.
    fn subtree(&mut self, items: &mut [Item], join: Option<NodeId>, depth: u32) -> (u32, f32) {
        if items.len() <= LANES {
            return self.leaf(items);
        }
        let parts = self.divide(items, join, depth);
        let row = self.row();
        let node = self.words.reserve(NODE_ROWS as usize * LANES);
        for lane in 0..LANES {
            let part = parts.get(lane);
            let bounds = part.map_or(Box4::EMPTY, |part| part.bounds);
            let below = part.and_then(|part| Some((items.get_mut(part.from..part.to)?, part.join)));
            let (link, edge) = match below {
                Some((items, None)) => self.subtree(items, None, depth + 1),
                Some((items, join)) => self.subtree(items, join, 0),
                None => (EMPTY, 0.0),
            };
            let sides = bounds.lo.to_array().into_iter().zip(bounds.hi.to_array()).take(3);
            let numbers = sides.flat_map(|(lo, hi)| [lo, hi]).map(f32::to_bits);
            for (row, word) in numbers.chain([link, edge.to_bits()]).enumerate() {
                self.words.set(node + row * LANES + lane, word);
            }
        }
        (row, 0.0)
    }

    /// Appends a leaf, and returns the link to it and its longest edge along an axis.
    fn leaf(&mut self, items: &mut [Item]) -> (u32, f32) {
        let row = self.row();
        let mut longest = 0.0;
        let leaf = self.words.reserve(LEAF_ROWS as usize * LANES);
        for lane in 0..LANES {
            let item = items.get(lane);
            let triangle = item
                .and_then(|item| self.triangles.get(item.id() as usize))
                .copied()
                .unwrap_or_default();
            for edge in [triangle.b - triangle.a, triangle.c - triangle.a] {
                longest = edge.to_array().into_iter().fold(longest, |all, x| larger(all, x.abs()));
            }
            let corners = [triangle.a, triangle.b, triangle.c]
                .into_iter()
                .flat_map(|corner| corner.to_array());
            for (row, number) in corners.enumerate() {
                self.words.set(leaf + row * LANES + lane, number.to_bits());
            }
            let id = item.map_or(NO_ID, Item::id);
            self.words.set(leaf + (LEAF_ROWS as usize - 1) * LANES + lane, id);
        }
        (leaf_link(row, items.len() as u32), longest)
    }

    /// Sorts the items into two to eight parts.
    fn divide(
        &self,
        items: &mut [Item],
        join: Option<NodeId>,
        depth: u32,
    ) -> heapless::Vec<Part, LANES> {
        let mut parts = heapless::Vec::new();
        let count = items.len();
        if parts.push(Part::of(items, 0, count, join)).is_err() {
            return parts;
        }
        while parts.len() < LANES {
            // The part whose triangles cost most.
            let mut costliest: Option<(f32, usize)> = None;
            for (at, part) in parts.iter().enumerate() {
                let cost = part.bounds.surface() * tests(part.count());
                if part.count() > LANES && costliest.is_none_or(|(most, _)| cost > most) {
                    costliest = Some((cost, at));
                }
            }
            let Some(part) = costliest.and_then(|(_, at)| parts.get_mut(at)) else {
                break;
            };
            let (from, to) = (part.from, part.to);
            let Some(run) = items.get_mut(from..to) else { break };
            let joined = part.join.and_then(|join| self.nodes.get(join.0 as usize));
            let (length, joins) = if let Some(node) = joined {
                let [left, right] = node.links;
                let length = self.counts.get(left as usize).map_or(0, |&count| count as usize);
                (length, [self.join(NodeId(left)), self.join(NodeId(right))])
            } else if depth >= BALANCED_FROM {
                (run.len() / 2, [None; 2])
            } else {
                (Self::halve(run), [None; 2])
            };
            let middle = from + length;
            *part = Part::of(items, from, middle, joins[0]);
            if parts.push(Part::of(items, middle, to, joins[1])).is_err() {
                break;
            }
        }
        parts
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
        let mut best: Option<(f32, usize, usize)> = None;
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
                let cost = below + part.surface() * tests(sum);
                let divides = sum > 0 && sum < items.len();
                if divides && best.is_none_or(|(least, _, _)| cost < least) {
                    best = Some((cost, axis, bin));
                }
            }
        }
        let Some((_, axis, bin)) = best else {
            return items.len() / 2;
        };
        // Those below to the front, those above to the back.
        let (mut front, mut back) = (0, items.len());
        while front < back {
            if items.get(front).is_some_and(|item| bins_of(item)[axis % 3] < bin) {
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
}
