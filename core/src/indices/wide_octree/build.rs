//! Building in two passes.
//!
//! First the triangles are sorted into the order of the leaves by dividing them in two again and again, and the
//! divisions are collapsed into nodes, which tells how much each subtree will take; then everything is written to
//! where it belongs. Both go down the tree in branches that know nothing of each other, so an executor may run
//! them at once, and the bytes are the same. Where nothing is to be written, the first pass says how much it
//! would be.
//!
//! Octrees that write the same tree in another way begin with the first pass too, and go down a [`Subtree`].

use super::collapse::{Forest, Split, Subtree};
use super::divide::{Box4, Divider, Item, Place, larger};
use super::{
    EDGES_ROW, EMPTY, HEAD_ROWS, IDS_ROW, LANES, LEAF_ROWS, LINKS_ROW, Leaf, NO_ID, NODE_ROWS,
    ROW_MASK, Row, leaf_link,
};
use crate::indices::Division;
use crate::memory::{Arena, Words, size_of_slice};
use crate::{BuildError, Executor, Mesh};

pub(super) const fn scratch_bytes(triangle_count: usize) -> usize {
    let counts = size_of_slice::<u32>(triangle_count.saturating_mul(2));
    size_of_slice::<Item>(triangle_count)
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
    let Sorted { root, largest } = sort(&division, scratch, executor)?;
    let rows = HEAD_ROWS.saturating_add(root.rows());
    if let Some(words) = words.append(rows as usize * LANES) {
        let rows: &mut [Row] = bytemuck::try_cast_slice_mut(words).unwrap_or_default();
        if let Some((head, rows)) = rows.split_at_mut_checked(HEAD_ROWS as usize) {
            let root = Writer { triangles, executor }.write(root, HEAD_ROWS, rows);
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
    /// The largest coordinate of any triangle.
    pub largest: f32,
}

/// The first pass, in `scratch_bytes` of scratch.
pub(in crate::indices) fn sort<'s>(
    division: &Division<'_>,
    scratch: &'s mut [u8],
    executor: &impl Executor,
) -> Result<Sorted<'s>, BuildError> {
    let Division { triangles, clusters, ref nodes, .. } = *division;
    let count = triangles.len();
    let full = BuildError::ScratchFull { needed: scratch_bytes(count), given: scratch.len() };
    let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
    let items = arena.take::<Item>(count).ok_or(full)?;
    let splits = arena.take::<Split>(count).ok_or(full)?;
    let counts = arena.take::<u32>(nodes.len()).ok_or(full)?;
    let divider = Divider::new(items, counts, triangles, clusters, nodes);

    let largest = items.iter().fold(0.0, |all, item| larger(all, item.largest_coordinate()));
    let place = divider.root(items);
    let forest = Sorter { divider, executor }.sort(items, splits, 0, &place);
    Ok(Sorted { root: Subtree::root(items, splits, &forest), largest })
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
    fn sort(&self, items: &mut [Item], splits: &mut [Split], from: u32, place: &Place) -> Forest {
        let count = items.len();
        if count <= LANES {
            return Forest::LEAF;
        }
        let surface = self.divider.surface(place);
        let (length, places) = self.divider.divide(items, place);
        let at = from + length as u32;
        let halves = (items.split_at_mut_checked(length), splits.split_at_mut_checked(length));
        let (Some(items), Some(halves)) = halves else { return Forest::LEAF };
        let (left, right) = both(
            self.executor,
            count,
            || self.sort(items.0, halves.0, from, &places[0]),
            || self.sort(items.1, halves.1, at, &places[1]),
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
    /// Writes a subtree into as many rows as it takes, of which the first is `row`.
    fn write(&self, subtree: Subtree<'_>, row: u32, rows: &mut [Row]) -> Child {
        let subtrees = subtree.children();
        if subtrees.is_empty() {
            return self.leaf(subtree.items, row, rows);
        }
        let Some((node, below)) = rows.split_at_mut_checked(NODE_ROWS as usize) else {
            return Child::NONE;
        };
        let mut children = [Child::NONE; LANES];
        self.write_all(&subtrees, row + NODE_ROWS, below, &mut children);
        let mut bounds = Box4::EMPTY;
        if let Some(node) = node.first_chunk_mut::<{ NODE_ROWS as usize }>() {
            for (lane, child) in children.iter().enumerate() {
                let ([x, y, z, _], [x_hi, y_hi, z_hi, _]) =
                    (child.bounds.lo.to_array(), child.bounds.hi.to_array());
                for (row, side) in [x, x_hi, y, y_hi, z, z_hi].into_iter().enumerate() {
                    node[row][lane] = side.to_bits();
                }
                node[LINKS_ROW][lane] = child.link;
                node[EDGES_ROW][lane] = child.edge.to_bits();
                bounds = bounds.union(child.bounds);
            }
        }
        Child { bounds, link: row, edge: 0.0 }
    }

    /// Writes neighbouring subtrees one after the other, from the row `row` on.
    fn write_all(
        &self,
        subtrees: &[Subtree<'_>],
        row: u32,
        rows: &mut [Row],
        children: &mut [Child],
    ) {
        let half = subtrees.len() / 2;
        let (left, right) = subtrees.split_at_checked(half).unwrap_or_default();
        if left.is_empty() {
            if let (Some(subtree), Some(child)) = (subtrees.first(), children.first_mut()) {
                *child = self.write(*subtree, row, rows);
            }
            return;
        }
        let rows_of_left: u32 = left.iter().map(Subtree::rows).sum();
        let halves =
            (rows.split_at_mut_checked(rows_of_left as usize), children.split_at_mut_checked(half));
        let (Some(rows), Some(children)) = halves else { return };
        both(
            self.executor,
            subtrees.iter().map(|subtree| subtree.items.len()).sum(),
            || self.write_all(left, row, rows.0, children.0),
            || self.write_all(right, row + rows_of_left, rows.1, children.1),
        );
    }

    /// Writes a leaf.
    fn leaf(&self, items: &[Item], row: u32, rows: &mut [Row]) -> Child {
        let mut edge = 0.0;
        if let Some(leaf) = rows.first_chunk_mut::<{ LEAF_ROWS as usize }>() {
            *leaf = [[0; LANES]; LEAF_ROWS as usize];
            leaf[IDS_ROW] = [NO_ID; LANES];
            for (lane, item) in (0..LANES).zip(items) {
                let triangle = self.triangles.get(item.id()).unwrap_or_default();
                let corners = [triangle.a, triangle.b, triangle.c].map(|corner| corner.to_array());
                for (row, number) in corners.into_iter().flatten().enumerate() {
                    leaf[row][lane] = number.to_bits();
                }
                leaf[IDS_ROW][lane] = item.id();
            }
            edge = longest_edge(leaf);
        }
        Child { bounds: Box4::around(items), link: leaf_link(row, items.len() as u32), edge }
    }
}

/// The largest component of the triangles' edges at corner a.
fn longest_edge(leaf: &Leaf) -> f32 {
    let mut longest = [0.0; LANES];
    for (a, other) in [(0, 3), (1, 4), (2, 5), (0, 6), (1, 7), (2, 8)] {
        for (lane, longest) in longest.iter_mut().enumerate() {
            let side = f32::from_bits(leaf[other][lane]) - f32::from_bits(leaf[a][lane]);
            *longest = larger(*longest, side.abs());
        }
    }
    longest.into_iter().fold(0.0, larger)
}
