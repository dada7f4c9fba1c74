//! The second pass of the wide BVH: sorted primitives are written as rows.
//!
//! ```text
//! 1. plan        upper nodes, breadth first      where their children will lie
//! 2. below       what is below them              subtrees, depth first, in branches that may run in parallel
//! 3. join_boxes  upper nodes, from the last on   the boxes of upper nodes below
//! ```
//! A node is *upper* if its subtree is longer than a page of memory. A ray passes several upper nodes: together they
//! take few pages. Any other node lies on one page with what it leads to.
//!
//! # Measured
//! - With a million triangles, where the processor's TLB does not hold all pages: single rays took 3 to 7% less time
//!   than with all nodes depth first, rays of a batch 2 to 4%, and both about a tenth less on a busy machine.
//! - With 70,000 triangles: no difference.
//!
//! # What lost
//! - All nodes before all leaves: 9% less to 3% more time.
//! - The children of each node side by side: 5% less to 1% more.

use core::ops::Range;

use glam::Vec4;

use super::HEAD_ROWS;
use super::plan::{Plan, Planner, is_upper, shared_rows};
use crate::error::BuildError;
use crate::geometry::Box4;
use crate::indices::wide::build::collapse::Subtree;
use crate::indices::wide::build::primitive::Primitive;
use crate::indices::wide::build::{Sorted, both, sort};
use crate::indices::wide::rows::{
    EDGES_ROW, EMPTY, EMPTY_LEAF, IDS_ROW, LANES, LEAF_BIT, LEAF_ROWS, LINKS_ROW, LeafRows,
    NODE_ROWS, Node, Packing, ROW_MASK, Row, leaf_link, set_triangle,
};
use crate::input::{Executor, Mesh};
use crate::memory::Words;
use crate::structure::DividedScene;

/// Entry of a child in its node.
#[derive(Clone, Copy)]
struct Child {
    bounds: Box4,
    link: u32,
    /// The edge of a leaf, see [`leaf_link`]; 0 for a node.
    edge: u32,
}

impl Child {
    const NONE: Self = Self { bounds: Box4::EMPTY, link: EMPTY, edge: 0 };
}

/// Builds a wide BVH: both passes.
pub(crate) fn build(
    mut division: DividedScene<'_>,
    words: &mut Words<'_>,
    scratch: &mut [u8],
    executor: &impl Executor,
) -> Result<(), BuildError> {
    let triangles = division.triangles;
    check_count(triangles.len())?;
    if triangles.is_empty() {
        return Ok(());
    }
    let Sorted { root, largest } = sort(&division, words, scratch, executor)?;
    if let Some(words) = words.append(word_count(&root)) {
        let rows = bytemuck::try_cast_slice_mut(words).unwrap_or_default();
        if let Some((head, rows)) = rows.split_first_chunk_mut() {
            let mut planner = Planner::default();
            planner.go_on(rows, root, usize::MAX);
            Writer::new(triangles, root, &planner, executor).write(largest, head, rows);
        }
    }
    division.first_owns(words.len());
    Ok(())
}

/// Checks that links reach all rows, whatever the tree.
pub(super) fn check_count(triangle_count: usize) -> Result<(), BuildError> {
    // At worst each triangle is a leaf with rows of its own, and there is a node for every two children.
    let rows = triangle_count.saturating_mul((LEAF_ROWS + NODE_ROWS) as usize);
    if rows >= ROW_MASK as usize { Err(BuildError::TooLarge) } else { Ok(()) }
}

/// The number of words of an index.
pub(super) fn word_count(root: &Subtree<'_>) -> usize {
    HEAD_ROWS.saturating_add(root.rows()) as usize * LANES
}

/// The head of the words.
pub(super) type Head = [Row; HEAD_ROWS as usize];

/// Second pass, after the plan.
pub(super) struct Writer<'s, E> {
    triangles: Mesh<'s>,
    /// The subtree of all primitives.
    root: Subtree<'s>,
    upper_rows: u32,
    executor: &'s E,
}

impl<'s, E: Executor> Writer<'s, E> {
    pub fn new(triangles: Mesh<'s>, root: Subtree<'s>, planner: &Planner, executor: &'s E) -> Self {
        Self { triangles, root, upper_rows: planner.upper_rows(), executor }
    }

    /// Writes the head, and the tree behind it.
    pub fn write(&self, largest: f32, head: &mut Head, rows: &mut [Row]) {
        let Some((nodes, below)) = self.split(rows) else { return };
        if !nodes.is_empty() {
            self.below(nodes, 0, below);
            let count = nodes.len();
            join_boxes(nodes, 0..count);
        }
        self.finish(largest, head, rows);
    }

    /// Divides the rows behind the head into upper nodes and what is below them.
    fn split<'r>(&self, rows: &'r mut [Row]) -> Option<(&'r mut [Node], &'r mut [Row])> {
        let (nodes, below) = rows.split_at_mut_checked(self.upper_rows as usize)?;
        Some((nodes.as_chunks_mut().0, below))
    }

    /// Writes the head; and the tree, if no node is an upper one.
    pub fn finish(&self, largest: f32, head: &mut Head, rows: &mut [Row]) {
        let (link, edge) = if self.upper_rows > 0 {
            (HEAD_ROWS, 0)
        } else {
            let [root, ..] = self.children(&[self.root], EMPTY, HEAD_ROWS, rows);
            (root.link, root.edge)
        };
        *head = Default::default();
        head[0] = [link, edge, largest.to_bits(), self.upper_rows, 0, 0, 0, 0];
    }

    /// Phase 2: writes what is below some planned nodes, from `row` of the rows below all on, and these nodes, without
    /// the boxes of upper children.
    fn below(&self, nodes: &mut [Node], row: u32, rows: &mut [Row]) {
        let (left, right) = nodes.split_at_mut(nodes.len() / 2);
        let Some(middle) = right.first() else { return };
        if left.is_empty() {
            if let Some(node) = right.first_mut() {
                self.upper_node(node, row, rows);
            }
            return;
        }
        let middle = Plan::of(middle, self.root).row;
        let count = rows.len();
        let Some((rows_left, rows_right)) = rows.split_at_mut_checked((middle - row) as usize)
        else {
            return;
        };
        both(
            self.executor,
            count,
            || self.below(left, row, rows_left),
            || self.below(right, middle, rows_right),
        );
    }

    /// Writes what is below one planned node, and the node.
    fn upper_node(&self, node: &mut Node, row: u32, rows: &mut [Row]) {
        let Plan { subtree, link, .. } = Plan::of(node, self.root);
        let row = HEAD_ROWS + self.upper_rows + row;
        write_node(node, &self.children(&subtree.children(), link, row, rows));
    }

    /// Phase 2 for one upper node alone. Returns the number of rows written below it; `None` if there is no such node.
    pub fn below_one(&self, rows: &mut [Row], at: usize) -> Option<usize> {
        let (nodes, below) = self.split(rows)?;
        let row_of = |node: &Node| Plan::of(node, self.root).row as usize;
        let end = nodes.get(at + 1).map_or(below.len(), row_of);
        let node = nodes.get_mut(at)?;
        let row = row_of(node);
        let rows = below.get_mut(row..end)?;
        self.upper_node(node, row as u32, rows);
        Some(rows.len())
    }

    /// Phase 3 for up to `count` upper nodes before the node `end`. Returns the first of them.
    pub fn join_some(&self, rows: &mut [Row], end: usize, count: usize) -> usize {
        let start = end.saturating_sub(count);
        if let Some((nodes, _)) = self.split(rows) {
            join_boxes(nodes, start..end);
        }
        start
    }

    /// Writes a node, whose first row is `row`, and what is below it. The recursion is as deep as the tree.
    fn subtree(&self, subtree: Subtree<'_>, row: u32, rows: &mut [Row]) -> Child {
        let Some((node, below)) = rows.split_first_chunk_mut() else { return Child::NONE };
        // No child is an upper node: those are below upper nodes only.
        let children = self.children(&subtree.children(), EMPTY, row + NODE_ROWS, below);
        Child { bounds: write_node(node, &children), link: row, edge: 0 }
    }

    /// Writes sibling subtrees from `row` on, the leaves first. Upper nodes among them are not written and have no box
    /// yet; the first is at `link`.
    fn children(
        &self,
        subtrees: &[Subtree<'_>],
        mut link: u32,
        mut row: u32,
        rows: &mut [Row],
    ) -> [Child; LANES] {
        let mut children = [Child::NONE; LANES];
        let first_leaf = row;
        row += shared_rows(subtrees);
        let Some((leaves, mut rows)) = rows.split_at_mut_checked((row - first_leaf) as usize)
        else {
            return children;
        };
        let (leaves, _) = leaves.as_chunks_mut();
        leaves.fill(EMPTY_LEAF);
        let mut packing = Packing::default();
        for (slot, subtree) in children.iter_mut().zip(subtrees) {
            if subtree.is_leaf() {
                let (number, lanes) = packing.place(subtree.primitives.len());
                let Some(leaf) = leaves.get_mut(number) else { break };
                *slot = self.leaf(
                    subtree.primitives,
                    leaf,
                    lanes,
                    first_leaf + number as u32 * LEAF_ROWS,
                );
            } else if is_upper(subtree) {
                slot.link = link;
                link += NODE_ROWS;
            } else if let Some((own, others)) = rows.split_at_mut_checked(subtree.rows() as usize) {
                *slot = self.subtree(*subtree, row, own);
                row += subtree.rows();
                rows = others;
            } else {
                break;
            }
        }
        children
    }

    /// Writes a leaf into some lanes.
    fn leaf(
        &self,
        primitives: &[Primitive],
        leaf: &mut LeafRows,
        lanes: Range<usize>,
        row: u32,
    ) -> Child {
        for (lane, primitive) in lanes.clone().zip(primitives) {
            let triangle = self.triangles.get(primitive.id()).unwrap_or_default();
            set_triangle(leaf, lane, &triangle);
            leaf[IDS_ROW][lane % LANES] = primitive.id();
        }
        let edges = longest_edges(leaf);
        let own = edges.get(lanes.clone()).unwrap_or_default();
        let longest = own.iter().fold(0.0, |longest, &edge| larger(longest, edge));
        let [link, edge] = leaf_link(row, lanes, longest);
        Child { bounds: Primitive::bounds_of(primitives), link, edge }
    }
}

/// Writes a node, and returns the box around its children.
fn write_node(node: &mut Node, children: &[Child; LANES]) -> Box4 {
    let mut bounds = Box4::EMPTY;
    for (lane, child) in children.iter().enumerate() {
        set_box(node, lane, child.bounds);
        node[LINKS_ROW][lane % LANES] = child.link;
        node[EDGES_ROW][lane % LANES] = child.edge;
        bounds = bounds.union(child.bounds);
    }
    bounds
}

/// Writes the box of a lane.
fn set_box(node: &mut Node, lane: usize, bounds: Box4) {
    let ([x, y, z, _], [x_hi, y_hi, z_hi, _]) = (bounds.lo.to_array(), bounds.hi.to_array());
    for (row, side) in node.iter_mut().zip([x, x_hi, y, y_hi, z, z_hi]) {
        row[lane % LANES] = side.to_bits();
    }
}

/// The box around the children of a node.
fn bounds_of(node: &Node) -> Box4 {
    let numbers = |row: usize| node[row].map(f32::from_bits).into_iter();
    let least =
        |row| numbers(row).fold(f32::INFINITY, |least, x| if x < least { x } else { least });
    let largest = |row| numbers(row).fold(f32::NEG_INFINITY, larger);
    Box4 {
        lo: Vec4::new(least(0), least(2), least(4), 0.0),
        hi: Vec4::new(largest(1), largest(3), largest(5), 0.0),
    }
}

/// Phase 3: writes the boxes of upper nodes into their parents, those of the range. Children come later than parents,
/// so the last node is first.
fn join_boxes(nodes: &mut [Node], parents: Range<usize>) {
    for at in parents.rev() {
        for lane in 0..LANES {
            let child = nodes.get(at).map_or(EMPTY, |node| node[LINKS_ROW][lane]);
            if child == EMPTY || child & LEAF_BIT != 0 {
                continue;
            }
            // The box of a child that is not an upper node is there already.
            let bounds = nodes.get(((child - HEAD_ROWS) / NODE_ROWS) as usize).map(bounds_of);
            if let (Some(bounds), Some(node)) = (bounds, nodes.get_mut(at)) {
                set_box(node, lane, bounds);
            }
        }
    }
}

/// The largest component of each triangle's edges at corner a.
fn longest_edges(leaf: &LeafRows) -> [f32; LANES] {
    let [a_x, a_y, a_z, b_x, b_y, b_z, c_x, c_y, c_z, _] = leaf;
    let mut longest = [0.0; LANES];
    for (a, other) in [(a_x, b_x), (a_y, b_y), (a_z, b_z), (a_x, c_x), (a_y, c_y), (a_z, c_z)] {
        for ((longest, &a), &other) in longest.iter_mut().zip(a).zip(other) {
            *longest = larger(*longest, (f32::from_bits(other) - f32::from_bits(a)).abs());
        }
    }
    longest
}

fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
