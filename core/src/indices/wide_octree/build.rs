//! Building from above.
//!
//! A node's triangles are divided in two, then the costliest part again, until there are eight parts
//! or none is left to divide: a join of clusters into those that were joined, other triangles by the best
//! plane of all axes by estimated tests. A test of up to eight triangles costs the same, so counts are
//! rounded up to full leaves: this fills them.
//!
//! First the triangles are sorted into the order of the leaves, with a [`Cut`] wherever a node divides
//! them, which tells how much its parts will take; then everything is written to where it belongs. Both go
//! down the tree in branches that know nothing of each other, so an executor may run them at once, and the
//! bytes are the same. Where nothing is to be written, the first half says how much it would be.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use super::{
    BALANCED_FROM, EMPTY, HEAD_ROWS, LANES, LEAF_ROWS, NO_ID, NODE_ROWS, ROW_MASK, Row, leaf_link,
};
use crate::cluster::{Clusters, MAX_TREE_DEPTH};
use crate::indices::Division;
use crate::memory::{Arena, ClusterNode, NodeId, Words, size_of_slice};
use crate::{BuildError, Executor, Triangle, Vec3};

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

/// Between two items: which node divides them.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Cut {
    /// The node's depth below the root; none has `NO_LEVEL`.
    level: u32,
    /// The rows of its part that begins here.
    rows: u32,
}

const NO_LEVEL: u32 = u32::MAX;

pub(super) const fn scratch_bytes(triangle_count: usize) -> usize {
    let counts = size_of_slice::<u32>(triangle_count.saturating_mul(2));
    size_of_slice::<Item>(triangle_count)
        .saturating_add(size_of_slice::<Cut>(triangle_count))
        .saturating_add(counts)
}

pub(super) fn build(
    mut division: Division<'_>,
    words: &mut Words<'_>,
    scratch: &mut [u8],
    executor: &impl Executor,
) -> Result<(), BuildError> {
    let Division { triangles, clusters, ref nodes } = division;
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
    let cuts = arena.take::<Cut>(count).ok_or(full)?;
    let counts = arena.take::<u32>(nodes.len()).ok_or(full)?;
    count_triangles(counts, clusters, nodes);
    sort_by_cluster_tree(items, triangles, clusters, nodes, counts);

    let largest = items.iter().fold(0.0, |all, item| larger(all, item.largest_coordinate()));
    let root = NodeId((nodes.len() as u32).saturating_sub(1));
    let builder = Builder { triangles, nodes, counts, executor };
    let rows = HEAD_ROWS
        + builder.sort(items, cuts, Place { join: builder.join(root), depth: 0, level: 0 });
    if let Some(words) = words.append(rows as usize * LANES) {
        let rows: &mut [Row] = bytemuck::try_cast_slice_mut(words).unwrap_or_default();
        if let Some((head, rows)) = rows.split_at_mut_checked(HEAD_ROWS as usize) {
            let root = builder.write(items, cuts, 0, HEAD_ROWS, rows);
            head.fill([0; LANES]);
            if let Some(head) = head.first_mut() {
                *head = [root.link, root.edge.to_bits(), largest.to_bits(), 0, 0, 0, 0, 0];
            }
        }
    }
    division.first_owns(words.len());
    Ok(())
}

/// Files the triangles so that each node of the cluster tree has a run of its own.
fn sort_by_cluster_tree(
    items: &mut [Item],
    triangles: &[Triangle],
    clusters: &Clusters<'_>,
    nodes: &[ClusterNode],
    counts: &[u32],
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
            let [first, second] = cheaper_first(node, nodes, counts).map(|link| link as usize);
            let pushed = stack.push(second).is_ok();
            debug_assert!(pushed, "one for each level");
            next = Some(first);
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

/// What a node of the cluster tree joins: first what costs less to test.
fn cheaper_first(node: &ClusterNode, nodes: &[ClusterNode], counts: &[u32]) -> [u32; 2] {
    let cost = |link: u32| {
        let (node, count) = (nodes.get(link as usize), counts.get(link as usize));
        node.zip(count).map_or(0.0, |(node, &count)| {
            let [x, y, z] = (node.bounds.hi - node.bounds.lo).to_array();
            (x * y + y * z + z * x) * tests(count as usize)
        })
    };
    let [left, right] = node.links;
    if cost(right) < cost(left) { [right, left] } else { [left, right] }
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

/// Where a subtree stands.
#[derive(Clone, Copy)]
struct Place {
    /// The join of clusters that it is, if it is one.
    join: Option<NodeId>,
    /// The levels above it in its cluster.
    depth: u32,
    /// All levels above it.
    level: u32,
}

impl Place {
    fn below(self, join: Option<NodeId>) -> Self {
        let depth = if join.is_some() { 0 } else { self.depth + 1 };
        Self { join, depth, level: self.level + 1 }
    }
}

/// What a node knows of a child.
#[derive(Clone, Copy)]
struct Child {
    bounds: Box4,
    link: u32,
    /// The longest edge along an axis of the triangles of a leaf.
    edge: f32,
}

impl Child {
    const NONE: Self = Self { bounds: Box4::EMPTY, link: EMPTY, edge: 0.0 };
}

/// A part of a node while it is written: where its items begin, and how many rows it takes.
#[derive(Clone, Copy)]
struct Run {
    from: usize,
    rows: usize,
}

/// From so many items on, branches are offered to the executor.
const LARGE: usize = 4096;

struct Builder<'b, E> {
    triangles: &'b [Triangle],
    nodes: &'b [ClusterNode],
    /// The triangles below each of them.
    counts: &'b [u32],
    executor: &'b E,
}

impl<E: Executor> Builder<'_, E> {
    /// The node, if it is a join.
    fn join(&self, id: NodeId) -> Option<NodeId> {
        // Leaves come first, and there is one more of them than of joins.
        (id.0 as usize > self.nodes.len() / 2).then_some(id)
    }

    /// Does both, at once if they are large.
    fn both<A: Send, B: Send>(
        &self,
        count: usize,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        if count >= LARGE { self.executor.join(a, b) } else { (a(), b()) }
    }

    /// Sorts the items of a subtree into the order of its leaves, cuts them between its first and its last,
    /// and returns the rows that it takes. As deep a recursion as the tree.
    fn sort(&self, items: &mut [Item], cuts: &mut [Cut], place: Place) -> u32 {
        let inner = cuts.get_mut(1..).unwrap_or_default();
        if items.len() <= LANES {
            inner.fill(Cut { level: NO_LEVEL, rows: 0 });
            return LEAF_ROWS;
        }
        let parts = self.divide(items, place.join, place.depth);
        NODE_ROWS + self.sort_parts(items, cuts, &parts, place)
    }

    /// Sorts the neighbouring parts of a node, cuts between them, and returns the rows of all.
    fn sort_parts(
        &self,
        items: &mut [Item],
        cuts: &mut [Cut],
        parts: &[Part],
        place: Place,
    ) -> u32 {
        let (left, right) = parts.split_at_checked(parts.len() / 2).unwrap_or_default();
        let (Some(first), Some(middle)) = (left.first(), right.first()) else {
            let join = parts.first().and_then(|part| part.join);
            let rows = self.sort(items, cuts, place.below(join));
            // A node above that begins here too overwrites it.
            if let Some(cut) = cuts.first_mut() {
                *cut = Cut { level: place.level, rows };
            }
            return rows;
        };
        let (at, count) = (middle.from - first.from, items.len());
        let halves = (items.split_at_mut_checked(at), cuts.split_at_mut_checked(at));
        let (Some(items), Some(cuts)) = halves else { return 0 };
        let (left, right) = self.both(
            count,
            || self.sort_parts(items.0, cuts.0, left, place),
            || self.sort_parts(items.1, cuts.1, right, place),
        );
        left + right
    }

    /// Writes the subtree of sorted items into as many rows as it takes, of which the first is `row`.
    fn write(&self, items: &[Item], cuts: &[Cut], level: u32, row: u32, rows: &mut [Row]) -> Child {
        if items.len() <= LANES {
            return self.leaf(items, row, rows);
        }
        let Some((node, below)) = rows.split_at_mut_checked(NODE_ROWS as usize) else {
            return Child::NONE;
        };
        // The first part has no cut of its own, and takes what the others leave.
        let mut runs = [Run { from: 0, rows: below.len() }; LANES];
        let mut count = 1;
        let own = cuts.iter().enumerate().skip(1).filter(|(_, cut)| cut.level == level);
        for (from, cut) in own.take(LANES - 1) {
            let rows = cut.rows as usize;
            runs[0].rows = runs[0].rows.saturating_sub(rows);
            runs[count % LANES] = Run { from, rows };
            count += 1;
        }
        let runs = runs.get(..count).unwrap_or_default();
        let mut children = [Child::NONE; LANES];
        let place = (level + 1, row + NODE_ROWS);
        self.write_parts(items, cuts, runs, place, below, &mut children);
        let mut bounds = Box4::EMPTY;
        for (lane, child) in children.iter().enumerate() {
            let sides = child.bounds.lo.to_array().into_iter().zip(child.bounds.hi.to_array());
            let numbers = sides.take(3).flat_map(|(lo, hi)| [lo, hi]).map(f32::to_bits);
            let words = numbers.chain([child.link, child.edge.to_bits()]);
            for (row, word) in node.iter_mut().zip(words) {
                row[lane] = word;
            }
            bounds = bounds.union(child.bounds);
        }
        Child { bounds, link: row, edge: 0.0 }
    }

    /// Writes neighbouring parts of a node one after the other. `place` is their level and first row.
    fn write_parts(
        &self,
        items: &[Item],
        cuts: &[Cut],
        runs: &[Run],
        (level, row): (u32, u32),
        rows: &mut [Row],
        children: &mut [Child],
    ) {
        let half = runs.len() / 2;
        let (left, right) = runs.split_at_checked(half).unwrap_or_default();
        let (Some(first), Some(middle)) = (left.first(), right.first()) else {
            if let Some(child) = children.first_mut() {
                *child = self.write(items, cuts, level, row, rows);
            }
            return;
        };
        let at = middle.from - first.from;
        let rows_at = left.iter().map(|run| run.rows).sum();
        let halves = (items.split_at_checked(at), cuts.split_at_checked(at));
        let (Some(items_of), Some(cuts)) = halves else { return };
        let halves = (rows.split_at_mut_checked(rows_at), children.split_at_mut_checked(half));
        let (Some(rows), Some(children)) = halves else { return };
        let places = [(level, row), (level, row + rows_at as u32)];
        self.both(
            items.len(),
            || self.write_parts(items_of.0, cuts.0, left, places[0], rows.0, children.0),
            || self.write_parts(items_of.1, cuts.1, right, places[1], rows.1, children.1),
        );
    }

    /// Writes a leaf.
    fn leaf(&self, items: &[Item], row: u32, rows: &mut [Row]) -> Child {
        let mut edge = 0.0;
        for lane in 0..LANES {
            let item = items.get(lane);
            let triangle = item
                .and_then(|item| self.triangles.get(item.id() as usize))
                .copied()
                .unwrap_or_default();
            for side in [triangle.b - triangle.a, triangle.c - triangle.a] {
                edge = side.to_array().into_iter().fold(edge, |all, x| larger(all, x.abs()));
            }
            let corners = [triangle.a, triangle.b, triangle.c]
                .into_iter()
                .flat_map(|corner| corner.to_array());
            let words = corners.map(f32::to_bits).chain([item.map_or(NO_ID, Item::id)]);
            for (row, word) in rows.iter_mut().zip(words) {
                row[lane] = word;
            }
        }
        let bounds = items.iter().fold(Box4::EMPTY, |all, item| all.union(item.0));
        Child { bounds, link: leaf_link(row, items.len() as u32), edge }
    }

    /// Sorts the items into two to eight parts, one behind the other. Of two, the one that costs less comes
    /// first, hence in the lower lane: where a ray enters both at once, as one that begins in both, it is
    /// the cheaper to be asked first.
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
                let links = cheaper_first(node, self.nodes, self.counts);
                let length = self.counts.get(links[0] as usize).map_or(0, |&count| count as usize);
                (length, links.map(|link| self.join(NodeId(link))))
            } else if depth >= BALANCED_FROM {
                (run.len() / 2, [None; 2])
            } else {
                (Self::halve(run), [None; 2])
            };
            let middle = from + length;
            *part = Part::of(items, from, middle, joins[0]);
            // Behind its other half: `Vec::insert` could panic.
            let mut carried = Part::of(items, middle, to, joins[1]);
            for part in parts.iter_mut().filter(|part| part.from > from) {
                core::mem::swap(part, &mut carried);
            }
            if parts.push(carried).is_err() {
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
}
