//! Phase 1 of the second pass: where the upper nodes lie, and what is below them.

use super::HEAD_ROWS;
use crate::indices::wide::build::collapse::Subtree;
use crate::indices::wide::rows::{NODE_ROWS, Node, Packing, Row};

/// Number of rows of a page of 4 KiB.
const PAGE_ROWS: u32 = 128;

/// Tells whether a subtree's root is an upper node.
pub(super) fn is_upper(subtree: &Subtree<'_>) -> bool {
    subtree.rows() > PAGE_ROWS
}

/// The rows that those subtrees share which are leaves.
pub(super) fn shared_rows(subtrees: &[Subtree<'_>]) -> u32 {
    let leaves = subtrees.iter().filter(|subtree| subtree.is_leaf());
    Packing::of(leaves.map(|leaf| leaf.primitives.len())).rows()
}

/// Plan of an upper node. Until the node is written, its plan lies in the node's rows.
pub(super) struct Plan<'s> {
    pub subtree: Subtree<'s>,
    /// The row at which its leaves and lower subtrees begin, of those below the upper nodes.
    pub row: u32,
    /// The link to the first of its children that are upper nodes.
    pub link: u32,
}

impl<'s> Plan<'s> {
    fn put(self, node: &mut Node) {
        let [from, count, at] = self.subtree.key();
        node[0] = [from, count, at, self.row, self.link, 0, 0, 0];
    }

    pub fn of(node: &Node, root: Subtree<'s>) -> Self {
        let [from, count, at, row, link, ..] = node[0];
        Self { subtree: root.find([from, count, at]), row, link }
    }
}

/// Phase 1: plans the upper nodes, breadth first. It can pause.
#[derive(Default)]
pub(super) struct Planner {
    /// The number of upper nodes that are planned.
    planned: usize,
    /// The number of upper nodes found so far.
    found: usize,
    /// The rows below the planned nodes.
    row: u32,
}

impl Planner {
    /// Plans up to `count` more upper nodes; the rows behind the head take the plans. Tells whether all are planned.
    pub fn go_on(&mut self, rows: &mut [Row], root: Subtree<'_>, count: usize) -> bool {
        let (nodes, _) = rows.as_chunks_mut();
        if self.found == 0 && is_upper(&root) {
            let Some(node) = nodes.first_mut() else { return true };
            Plan { subtree: root, row: 0, link: 0 }.put(node);
            self.found = 1;
        }
        for _ in 0..count {
            if self.planned == self.found {
                break;
            }
            let Some(node) = nodes.get_mut(self.planned) else { return true };
            let Plan { subtree, .. } = Plan::of(node, root);
            let link = HEAD_ROWS + self.found as u32 * NODE_ROWS;
            Plan { subtree, row: self.row, link }.put(node);
            self.planned += 1;
            let children = subtree.children();
            self.row += shared_rows(&children);
            for child in children.iter().filter(|child| !child.is_leaf()) {
                if !is_upper(child) {
                    self.row += child.rows();
                } else if let Some(node) = nodes.get_mut(self.found) {
                    Plan { subtree: *child, row: 0, link: 0 }.put(node);
                    self.found += 1;
                }
            }
        }
        self.planned == self.found
    }

    /// The number of upper nodes that are planned.
    pub fn planned(&self) -> usize {
        self.planned
    }

    /// The rows of the upper nodes.
    pub fn upper_rows(&self) -> u32 {
        self.found as u32 * NODE_ROWS
    }
}
