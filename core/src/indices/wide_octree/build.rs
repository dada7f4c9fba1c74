//! Building in two passes.
//!
//! First the triangles are sorted into the order of the leaves by dividing them in two again and again, the
//! divisions are collapsed into nodes, and a [`Cut`] is made wherever a node divides them, which tells how much
//! its parts will take; then everything is written to where it belongs. Both go down the tree in branches that
//! know nothing of each other, so an executor may run them at once, and the bytes are the same. Where nothing is
//! to be written, the first pass says how much it would be.
//!
//! Octrees that write the same tree in another way begin with the first pass too, and go down a [`Subtree`].

use bytemuck::{Pod, Zeroable};

use super::collapse::{Forest, Split};
use super::divide::{Box4, Divider, Item, Place, larger};
use super::{EMPTY, HEAD_ROWS, LANES, LEAF_ROWS, NO_ID, NODE_ROWS, ROW_MASK, Row, leaf_link};
use crate::indices::Division;
use crate::memory::{Arena, Words, size_of_slice};
use crate::{BuildError, Executor, Mesh};

/// Between two items: which node divides them.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::indices) struct Cut {
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
        .saturating_add(size_of_slice::<Split>(triangle_count))
        .saturating_add(counts)
}

pub(super) fn build(
    mut division: Division<'_>,
    words: &mut Words<'_>,
    scratch: &mut [u8],
    executor: &impl Executor,
) -> Result<(), BuildError> {
    let triangles = division.triangles;
    let count = triangles.len();
    // Every triangle a leaf, and a node for every two children.
    if count.saturating_mul((LEAF_ROWS + NODE_ROWS) as usize) >= ROW_MASK as usize {
        return Err(BuildError::TooLarge);
    }
    if count == 0 {
        return Ok(());
    }
    let Sorted { root: Subtree { items, cuts, level }, rows, largest } =
        sort(&division, scratch, executor)?;
    let rows = HEAD_ROWS + rows;
    if let Some(words) = words.append(rows as usize * LANES) {
        let rows: &mut [Row] = bytemuck::try_cast_slice_mut(words).unwrap_or_default();
        if let Some((head, rows)) = rows.split_at_mut_checked(HEAD_ROWS as usize) {
            let root = Writer { triangles, executor }.write(items, cuts, level, HEAD_ROWS, rows);
            head.fill([0; LANES]);
            if let Some(head) = head.first_mut() {
                *head = [root.link, root.edge.to_bits(), largest.to_bits(), 0, 0, 0, 0, 0];
            }
        }
    }
    division.first_owns(words.len());
    Ok(())
}

/// The triangles in the order of the leaves, one at least.
pub(in crate::indices) struct Sorted<'s> {
    pub root: Subtree<'s>,
    /// The rows that a wide octree takes, without its head.
    rows: u32,
    /// The largest coordinate of any triangle.
    pub largest: f32,
}

/// A run of sorted items: up to eight are a leaf, more are a node.
#[derive(Clone, Copy)]
pub(in crate::indices) struct Subtree<'s> {
    pub items: &'s [Item],
    cuts: &'s [Cut],
    level: u32,
}

impl Subtree<'_> {
    /// The children of a node.
    pub fn children(self) -> impl Iterator<Item = Self> {
        let starts = node_cuts(self.cuts, self.level).map(|(from, _)| from);
        let ends = starts.clone().chain([self.items.len()]);
        [0].into_iter().chain(starts).zip(ends).filter_map(move |(from, to)| {
            let (items, cuts) = (self.items.get(from..to)?, self.cuts.get(from..to)?);
            Some(Self { items, cuts, level: self.level + 1 })
        })
    }
}

/// Where the children of a node begin, but the first.
fn node_cuts(cuts: &[Cut], level: u32) -> impl Iterator<Item = (usize, &Cut)> + Clone {
    cuts.iter().enumerate().skip(1).filter(move |(_, cut)| cut.level == level).take(LANES - 1)
}

/// The first pass, in `scratch_bytes` of scratch.
pub(in crate::indices) fn sort<'s>(
    division: &Division<'_>,
    scratch: &'s mut [u8],
    executor: &impl Executor,
) -> Result<Sorted<'s>, BuildError> {
    let Division { triangles, clusters, ref nodes } = *division;
    let count = triangles.len();
    let full = BuildError::ScratchFull { needed: scratch_bytes(count), given: scratch.len() };
    let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
    let items = arena.take::<Item>(count).ok_or(full)?;
    let cuts = arena.take::<Cut>(count).ok_or(full)?;
    let splits = arena.take::<Split>(count).ok_or(full)?;
    let counts = arena.take::<u32>(nodes.len()).ok_or(full)?;
    let divider = Divider::new(items, counts, triangles, clusters, nodes);

    let largest = items.iter().fold(0.0, |all, item| larger(all, item.largest_coordinate()));
    let place = divider.root();
    let root = Sorter { divider, executor }.sort(items, splits, 0, place);
    cuts.fill(Cut { level: NO_LEVEL, rows: 0 });
    root.for_each_child(splits, &mut |at, level, rows| {
        if let Some(cut) = cuts.get_mut(at as usize) {
            *cut = Cut { level, rows };
        }
    });
    Ok(Sorted { root: Subtree { items, cuts, level: 0 }, rows: root.rows(), largest })
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

/// Does both, at once if they are large.
fn both<A: Send, B: Send>(
    executor: &impl Executor,
    count: usize,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if count >= LARGE { executor.join(a, b) } else { (a(), b()) }
}

/// The first pass.
struct Sorter<'b, E> {
    divider: Divider<'b>,
    executor: &'b E,
}

impl<E: Executor> Sorter<'_, E> {
    /// Sorts the items of a part, of which the first has the number `from`, into the order of its leaves, and
    /// files how they are divided. As deep a recursion as they are divided.
    fn sort(&self, items: &mut [Item], splits: &mut [Split], from: u32, place: Place) -> Forest {
        let count = items.len();
        if count <= LANES {
            return Forest::LEAF;
        }
        let surface = Box4::around(items).surface();
        let (length, places) = self.divider.divide(items, place);
        let at = from + length as u32;
        let halves = (items.split_at_mut_checked(length), splits.split_at_mut_checked(length));
        let (Some(items), Some(halves)) = halves else { return Forest::LEAF };
        let (left, right) = both(
            self.executor,
            count,
            || self.sort(items.0, halves.0, from, places[0]),
            || self.sort(items.1, halves.1, at, places[1]),
        );
        let (forest, split) = Forest::join(&left, &right, at, surface);
        if let Some(slot) = splits.get_mut(length) {
            *slot = split;
        }
        forest
    }
}

/// The second pass.
struct Writer<'b, E> {
    triangles: Mesh<'b>,
    executor: &'b E,
}

impl<E: Executor> Writer<'_, E> {
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
        for (from, cut) in node_cuts(cuts, level) {
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
        both(
            self.executor,
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
            let triangle = item.and_then(|item| self.triangles.get(item.id())).unwrap_or_default();
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
        Child { bounds: Box4::around(items), link: leaf_link(row, items.len() as u32), edge }
    }
}
