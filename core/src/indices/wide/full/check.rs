//! Check that rows are a tree: each node and leaf begins where the one before ended, so no row is reached twice.

use core::ops::Range;

use arrayvec::ArrayVec;

use super::HEAD_ROWS;
use super::reader::WideTree;
use crate::indices::wide::build::MAX_DEPTH;
use crate::indices::wide::rows::{
    EDGES_ROW, EMPTY, IDS_ROW, LANES, LEAF_BIT, LEAF_ROWS, LINKS_ROW, LeafRows, NO_ID, NODE_ROWS,
    Node, Packing, ROW_MASK, Row, first_lane, leaf_at, leaf_count, node_at, triangle_at,
};
use crate::indices::wide::tree::{Step, Tree};
use crate::structure::{Sections, Statistics};

pub(crate) fn check(sections: &Sections<'_>) -> Option<Statistics> {
    let triangle_count = sections.triangle_count();
    if triangle_count == 0 {
        return sections.words().is_empty().then_some(Statistics::default());
    }
    let tree = WideTree::of(sections.words());
    let (root, rows) = (tree.root(), tree.rows);
    let below = HEAD_ROWS.checked_add(rows.first()?[UPPER_ROWS])?;
    if below as usize > rows.len() {
        return None;
    }
    let statistics = Statistics::default();
    let mut check = Check { rows, triangle_count, below, end: below, statistics };
    if root.link < below {
        check.upper_nodes(root.link)?;
    } else {
        check.below([root].into_iter(), 0)?;
        if below != HEAD_ROWS {
            return None;
        }
    }
    let all = check.statistics.references == u64::from(triangle_count);
    (check.end as usize == rows.len() && all).then_some(check.statistics)
}

/// Index of the word in the head that says how many rows the upper nodes take.
const UPPER_ROWS: usize = 3;

/// State of a check.
struct Check<'r> {
    rows: &'r [Row],
    triangle_count: u32,
    /// The row where the upper nodes end.
    below: u32,
    /// The row where the last subtree ended.
    end: u32,
    statistics: Statistics,
}

impl<'r> Check<'r> {
    /// Checks all upper nodes in their order, and what is below each.
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
            let node = self.node(row, depth)?;
            for upper in nodes(children(node)).filter(|&link| link < self.below) {
                if upper != named {
                    return None;
                }
                named += NODE_ROWS;
            }
            let below = self.below;
            self.below(children(node).filter(|child| child.link >= below), depth + 1)?;
            row += NODE_ROWS;
        }
        (named == self.below).then_some(())
    }

    /// Checks sibling subtrees: the leaves, then the nodes, each with what is below it.
    fn below(
        &mut self,
        children: impl DoubleEndedIterator<Item = Step> + Clone,
        depth: u32,
    ) -> Option<()> {
        let mut stack = ArrayVec::<(u32, u32), { MAX_DEPTH as usize * LANES }>::new();
        self.leaves(children.clone(), depth)?;
        for child in nodes(children).rev() {
            stack.try_push((child, depth)).ok()?;
        }
        while let Some((link, depth)) = stack.pop() {
            if link != self.end {
                return None;
            }
            let node = self.node(link, depth)?;
            self.end += NODE_ROWS;
            self.leaves(self::children(node), depth + 1)?;
            for child in nodes(self::children(node)).rev() {
                stack.try_push((child, depth + 1)).ok()?;
            }
        }
        Some(())
    }

    fn node(&mut self, link: u32, depth: u32) -> Option<&'r Node> {
        self.statistics.inner_nodes += 1;
        node_at(self.rows, link).filter(|_| depth + 1 < MAX_DEPTH)
    }

    /// Checks those of some children that are leaves, in the rows that they share.
    fn leaves(&mut self, children: impl Iterator<Item = Step>, depth: u32) -> Option<()> {
        let mut packing = Packing::default();
        for Step { link, edge } in children.filter(|child| child.link & LEAF_BIT != 0) {
            let (number, lanes) = packing.place(leaf_count(link) as usize);
            let in_place = link & ROW_MASK == self.end + number as u32 * LEAF_ROWS
                && first_lane(edge) as usize == lanes.start;
            let leaf = leaf_at(self.rows, link).filter(|_| in_place)?;
            self.triangles(leaf, lanes.clone())?;
            self.statistics.add_leaf(lanes.len() as u32, depth);
        }
        for (number, unused) in packing.unused().enumerate() {
            let leaf = leaf_at(self.rows, self.end + number as u32 * LEAF_ROWS)?;
            if leaf[IDS_ROW].get(unused)?.iter().any(|&id| id != NO_ID) {
                return None;
            }
        }
        self.end += packing.rows();
        Some(())
    }

    /// Checks that the triangles in some lanes are finite, and their ids are those of triangles.
    fn triangles(&self, leaf: &LeafRows, lanes: Range<usize>) -> Option<()> {
        let is_known = |&id: &u32| id < self.triangle_count;
        let known = leaf[IDS_ROW].get(lanes.clone())?.iter().all(is_known);
        let are_finite = lanes.into_iter().all(|lane| triangle_at(leaf, lane).is_finite());
        (known && are_finite).then_some(())
    }
}

fn children(node: &Node) -> impl DoubleEndedIterator<Item = Step> + Clone {
    let at = |row: usize, lane: usize| node[row][lane % LANES];
    let child = move |lane| Step { link: at(LINKS_ROW, lane), edge: at(EDGES_ROW, lane) };
    (0..LANES).map(child).filter(|child| child.link != EMPTY)
}

/// The links of those children that are nodes.
fn nodes(children: impl DoubleEndedIterator<Item = Step>) -> impl DoubleEndedIterator<Item = u32> {
    children.map(|child| child.link).filter(|link| link & LEAF_BIT == 0)
}
