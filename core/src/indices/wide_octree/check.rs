//! Whether rows are a tree: each node and leaf begins where the one before ended, so that none is named twice.

use super::tree::WideTree;
use super::walk::Tree;
use super::{
    EMPTY, HEAD_ROWS, IDS_ROW, LANES, LEAF, LEAF_ROWS, LINKS_ROW, MAX_DEPTH, NO_ID, NODE_ROWS,
    Node, ROW_MASK, Row, STACK, leaf_at, leaf_count, node_at, triangle_at,
};
use crate::indices::Statistics;
use crate::memory::Image;

pub(super) fn check(image: &Image<'_>) -> Option<Statistics> {
    let triangle_count = image.triangle_count();
    if triangle_count == 0 {
        return image.words().is_empty().then_some(Statistics::default());
    }
    let tree = WideTree::of(image.words());
    let (root, rows) = (tree.root().link, tree.rows);
    let below = HEAD_ROWS.checked_add(rows.first()?[UPPER_ROWS])?;
    if below as usize > rows.len() {
        return None;
    }
    let statistics = Statistics::default();
    let mut check = Check { rows, triangle_count, below, end: below, statistics };
    if root < below {
        check.upper_nodes(root)?;
    } else {
        check.subtree(root, 0)?;
        if below != HEAD_ROWS {
            return None;
        }
    }
    let all = check.statistics.references == u64::from(triangle_count);
    (check.end as usize == rows.len() && all).then_some(check.statistics)
}

/// Where the head says how many rows the upper nodes take.
const UPPER_ROWS: usize = 3;

struct Check<'r> {
    rows: &'r [Row],
    triangle_count: u32,
    /// Where the upper nodes end.
    below: u32,
    /// Where the last subtree ended.
    end: u32,
    statistics: Statistics,
}

impl<'r> Check<'r> {
    /// All upper nodes in their order, and what is below each.
    fn upper_nodes(&mut self, root: u32) -> Option<()> {
        if root != HEAD_ROWS {
            return None;
        }
        let mut named = HEAD_ROWS + NODE_ROWS;
        let (mut row, mut depth, mut level_end) = (HEAD_ROWS, 0, named);
        while row < named {
            if row == level_end {
                (depth, level_end) = (depth + 1, named);
            }
            for child in children(self.node(row, depth)?) {
                if child >= self.below {
                    self.subtree(child, depth + 1)?;
                } else if child == named {
                    named += NODE_ROWS;
                } else {
                    return None;
                }
            }
            row += NODE_ROWS;
        }
        (named == self.below).then_some(())
    }

    /// Nodes and leaves depth first.
    fn subtree(&mut self, link: u32, depth: u32) -> Option<()> {
        let mut stack = heapless::Vec::<(u32, u32), { STACK * LANES }>::new();
        let mut next = Some((link, depth));
        while let Some((link, depth)) = next.or_else(|| stack.pop()) {
            next = None;
            if link & ROW_MASK != self.end {
                return None;
            }
            if link & LEAF != 0 {
                self.leaf(link, depth)?;
                self.end += LEAF_ROWS;
            } else {
                let node = self.node(link, depth)?;
                self.end += NODE_ROWS;
                for child in children(node).rev() {
                    stack.push((child, depth + 1)).ok()?;
                }
            }
        }
        Some(())
    }

    fn node(&mut self, link: u32, depth: u32) -> Option<&'r Node> {
        self.statistics.inner_nodes += 1;
        node_at(self.rows, link).filter(|_| depth + 1 < MAX_DEPTH)
    }

    fn leaf(&mut self, link: u32, depth: u32) -> Option<()> {
        let leaf = leaf_at(self.rows, link)?;
        let count = leaf_count(link) as usize;
        let (used, unused) = leaf[IDS_ROW].split_at_checked(count)?;
        let known = used.iter().all(|&id| id < self.triangle_count);
        let is_padded = unused.iter().all(|&id| id == NO_ID);
        let are_finite = (0..count).all(|lane| triangle_at(leaf, lane).is_finite());
        self.statistics.add_leaf(count as u32, depth);
        (known && is_padded && are_finite).then_some(())
    }
}

fn children(node: &Node) -> impl DoubleEndedIterator<Item = u32> {
    node[LINKS_ROW].into_iter().filter(|&child| child != EMPTY)
}
