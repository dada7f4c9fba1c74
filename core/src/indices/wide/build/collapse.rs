//! Which divisions in two become nodes of up to eight.
//!
//! A node costs what its box's half_area is: so often is it entered. For each part the least cost is found with
//! which it can be one subtree, or up to two, ... up to eight of them side by side, from what that costs for
//! both its halves. Filled from above instead, by dividing the costliest part until there were eight, nodes had
//! fewer children (4.2 instead of 6.1 on figure 4): 1 to 4 bytes a triangle more, and up to 7% more nodes for a
//! ray to enter.
//!
//! # Source
//! H. Ylitie, T. Karras, S. Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*,
//! 2017, section 3.

use arrayvec::ArrayVec;
use bytemuck::{Pod, Zeroable};

use super::primitive::Primitive;
use crate::indices::wide::rows::{LANES, LEAF_ROWS, NODE_ROWS, Packing};

/// A division in two, filed under the primitive where the second half begins.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct BinarySplit {
    /// Where the halves are divided in turn; 0 for a leaf.
    halves: [u32; 2],
    /// Of two to eight subtrees side by side, how many the first half gets, three bits each; 0 where one
    /// subtree less is as good. Then how many it gets of the eight children of a node.
    shares: u32,
    /// What it takes as a node, with all below.
    rows: u32,
}

const SHARE_BITS: usize = 3;
/// Where the share of a node's children lies: behind those of one (unused), two, ... eight subtrees.
const OF_CHILDREN: usize = LANES;

impl BinarySplit {
    /// Not the share itself: 0 stands for another thing.
    fn share(&self, of: usize) -> usize {
        (self.shares >> (SHARE_BITS * of) & 7) as usize
    }
}

/// What a part takes as up to one, two, ... eight subtrees side by side.
#[derive(Clone, Copy)]
pub(crate) struct Forest {
    /// The surfaces of all inner nodes.
    costs: [f32; LANES],
    /// The rows of all, but of those subtrees that are leaves: which of them share rows is known when they have a
    /// node.
    rows: [u32; LANES],
    leaves: [LeafCounts; LANES],
    /// Where it is divided; 0 for a leaf.
    at: u32,
    /// Looks at an primitive that dividing took.
    pub steps: u64,
}

impl Forest {
    /// Of a leaf of so many primitives.
    pub fn leaf(count: usize) -> Self {
        let leaves = [LeafCounts::one(count); LANES];
        Self { costs: [0.0; LANES], rows: [0; LANES], leaves, at: 0, steps: count as u64 }
    }

    /// Of a part that is divided at the primitive `at`, in a box with so large a half_area.
    pub fn join(left: &Self, right: &Self, at: u32, half_area: f32) -> (Self, BinarySplit) {
        // The least cost of so many subtrees if some of them are in each half; of equals, the first. More subtrees
        // never cost more: beside a leaf, the other half gets all but one.
        let divided = |count: usize| {
            if left.at == 0 {
                return (right.costs[(count - 2) % LANES], 1);
            }
            let mut best = (f32::INFINITY, 0);
            for share in 1..count {
                let cost = left.costs[share - 1] + right.costs[(count - share - 1) % LANES];
                if cost < best.0 || share == 1 {
                    best = (cost, share);
                }
            }
            best
        };
        let side_by_side = |count: usize, share: usize| {
            let (ours, rest) = ((share - 1) % LANES, (count - share - 1) % LANES);
            let rows = left.rows[ours].saturating_add(right.rows[rest]);
            (rows, left.leaves[ours].and(right.leaves[rest]))
        };
        let (cost, share) = divided(LANES);
        let mut shares = (share as u32) << (SHARE_BITS * OF_CHILDREN);
        let (rows, leaves) = side_by_side(LANES, share);
        let rows = rows.saturating_add(NODE_ROWS + leaves.rows());
        // As one subtree, or as many as cost less.
        let (mut least, mut rows_and_leaves) = (cost + half_area, (rows, LeafCounts::NONE));
        let mut forest = Self {
            costs: [least; LANES],
            rows: [rows; LANES],
            leaves: [LeafCounts::NONE; LANES],
            at,
            steps: left.steps + right.steps,
        };
        for more in 1..LANES {
            let (cost, share) = divided(more + 1);
            if cost < least {
                (least, rows_and_leaves) = (cost, side_by_side(more + 1, share));
                shares |= (share as u32) << (SHARE_BITS * more);
            }
            forest.costs[more] = least;
            (forest.rows[more], forest.leaves[more]) = rows_and_leaves;
        }
        (forest, BinarySplit { halves: [left.at, right.at], shares, rows })
    }
}

/// How many primitives some leaves have, four bits each; at most eight leaves.
#[derive(Clone, Copy)]
struct LeafCounts(u32);

impl LeafCounts {
    const NONE: Self = Self(0);

    fn one(count: usize) -> Self {
        Self(count as u32)
    }

    /// These, and then others.
    fn and(self, others: Self) -> Self {
        let bits = u32::BITS - (self.0.leading_zeros() & !3);
        Self(self.0 | others.0.checked_shl(bits).unwrap_or(0))
    }

    /// The rows that they share.
    fn rows(self) -> u32 {
        let counts = (0..LANES).map(|leaf| (self.0 >> (4 * leaf) & 15) as usize);
        Packing::of(counts.take_while(|&count| count > 0)).rows()
    }
}

/// A run of sorted primitives: up to eight are a leaf, more are a node.
#[derive(Clone, Copy)]
pub(crate) struct Subtree<'s> {
    pub primitives: &'s [Primitive],
    /// Those of all primitives.
    splits: &'s [BinarySplit],
    /// The number of its first primitive.
    from: u32,
    /// Where it is divided; 0 for a leaf.
    at: u32,
}

impl<'s> Subtree<'s> {
    /// All primitives.
    pub(crate) fn root(
        primitives: &'s [Primitive],
        splits: &'s [BinarySplit],
        forest: &Forest,
    ) -> Self {
        Self { primitives, splits, from: 0, at: forest.at }
    }

    /// What [`find`](Self::find) finds it by.
    pub(crate) fn key(&self) -> [u32; 3] {
        [self.from, self.primitives.len() as u32, self.at]
    }

    /// One of those in all primitives, which this is.
    pub(crate) fn find(self, [from, count, at]: [u32; 3]) -> Self {
        let primitives = self
            .primitives
            .get(from as usize..)
            .and_then(|primitives| primitives.get(..count as usize));
        Self { primitives: primitives.unwrap_or_default(), from, at, ..self }
    }

    /// The rows that a wide BVH takes for it, if it is not a leaf among others.
    pub fn rows(&self) -> u32 {
        self.split().map_or(LEAF_ROWS, |split| split.rows)
    }

    pub fn is_leaf(&self) -> bool {
        self.split().is_none()
    }

    /// The children of a node, in the order of the primitives; a leaf has none.
    pub fn children(&self) -> ArrayVec<Self, LANES> {
        let mut children = ArrayVec::new();
        if let Some((split, [left, right])) = self.halves() {
            let share = split.share(OF_CHILDREN);
            left.gather(share, &mut children);
            right.gather(LANES - share, &mut children);
        }
        children
    }

    /// Appends a part as up to so many subtrees.
    fn gather(self, mut count: usize, subtrees: &mut ArrayVec<Self, LANES>) {
        if let Some((split, [left, right])) = self.halves() {
            while count > 1 && split.share(count - 1) == 0 {
                count -= 1;
            }
            if count > 1 {
                let share = split.share(count - 1);
                left.gather(share, subtrees);
                return right.gather(count - share, subtrees);
            }
        }
        let pushed = subtrees.try_push(self).is_ok();
        debug_assert!(pushed, "a node has at most eight");
    }

    /// How it is divided, unless it is a leaf.
    fn split(&self) -> Option<&'s BinarySplit> {
        self.splits.get(self.at as usize).filter(|_| self.at > 0)
    }

    fn halves(self) -> Option<(&'s BinarySplit, [Self; 2])> {
        let split = self.split()?;
        let (left, right) = self.primitives.split_at_checked((self.at - self.from) as usize)?;
        let [at_left, at_right] = split.halves;
        let left = Self { primitives: left, at: at_left, ..self };
        let right = Self { primitives: right, from: self.at, at: at_right, ..self };
        Some((split, [left, right]))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::boxed::Box;
    use std::vec::Vec;

    use super::*;

    /// How many subtrees side by side a part is, if the inner nodes with a bit in `nodes`, counted from `next`
    /// in preorder, are nodes, and what those cost; `None` where one has more than eight children.
    fn cost(tree: &TestTree, nodes: u32, next: &mut u32) -> Option<(usize, f32)> {
        let TestTree::Divided(half_area, left, right) = tree else { return Some((1, 0.0)) };
        let is_node = nodes >> *next & 1 == 1;
        *next += 1;
        let (a, b) = (cost(left, nodes, next)?, cost(right, nodes, next)?);
        let (children, below) = (a.0 + b.0, a.1 + b.1);
        if is_node {
            (children <= LANES).then_some((1, below + half_area))
        } else {
            Some((children, below))
        }
    }

    /// The least cost of at most so many subtrees, of all choices of nodes.
    fn least(tree: &TestTree, leaves: usize, count: usize) -> f32 {
        let all = (0..1_u32 << (leaves - 1)).filter_map(|nodes| cost(tree, nodes, &mut 0));
        all.filter(|(subtrees, _)| *subtrees <= count)
            .map(|(_, cost)| cost)
            .fold(f32::INFINITY, f32::min)
    }

    enum TestTree {
        Leaf,
        Divided(f32, Box<TestTree>, Box<TestTree>),
    }

    /// A tree of leaves of one primitive each, with small integers for surfaces, so that sums are exact.
    fn tree(leaves: usize, random: &mut u32) -> TestTree {
        *random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if leaves == 1 {
            return TestTree::Leaf;
        }
        let (half_area, first) =
            ((*random >> 24) as f32, 1 + (*random >> 8) as usize % (leaves - 1));
        let halves = [first, leaves - first].map(|leaves| Box::new(tree(leaves, random)));
        let [left, right] = halves;
        TestTree::Divided(half_area, left, right)
    }

    fn forest(tree: &TestTree, from: u32, splits: &mut [BinarySplit]) -> (Forest, u32) {
        let TestTree::Divided(half_area, left, right) = tree else {
            return (Forest::leaf(1), from + 1);
        };
        let (left, at) = forest(left, from, splits);
        let (right, end) = forest(right, at, splits);
        let (forest, split) = Forest::join(&left, &right, at, *half_area);
        splits[at as usize] = split;
        (forest, end)
    }

    /// Goes through all subtrees, notes where leaves begin, and returns the rows of all.
    fn walk(subtree: Subtree<'_>, begins: &mut Vec<u32>) -> u32 {
        let children = subtree.children();
        if children.is_empty() {
            assert_eq!(subtree.primitives.len(), 1);
            begins.push(subtree.from);
            return 0;
        }
        assert!((2..=LANES).contains(&children.len()));
        // Eight leaves of one primitive share their rows.
        let shared = if children.iter().any(Subtree::is_leaf) { LEAF_ROWS } else { 0 };
        let rows: u32 = children.into_iter().map(|child| walk(child, begins)).sum();
        assert_eq!(NODE_ROWS + shared + rows, subtree.rows());
        subtree.rows()
    }

    #[test]
    fn the_least_cost_is_found_and_its_nodes_are_shown() {
        let mut random = 1;
        for leaves in (2..15).cycle().take(130) {
            let tree = tree(leaves, &mut random);
            let mut splits = [BinarySplit::zeroed(); 15];
            let (forest, end) = forest(&tree, 0, &mut splits);
            assert_eq!(end as usize, leaves);
            for count in 1..=LANES {
                assert_eq!(
                    forest.costs[count - 1],
                    least(&tree, leaves, count),
                    "{count} of {leaves}"
                );
            }
            // The subtrees have as many rows as are told, no node has more than eight children or fewer than two,
            // and each leaf comes once, in order.
            let primitives = [Primitive::zeroed(); 15];
            let root = Subtree::root(&primitives[..leaves], &splits, &forest);
            let mut begins = Vec::new();
            let rows = walk(root, &mut begins);
            assert_eq!(rows, root.rows());
            assert_eq!(rows, forest.rows[0]);
            assert!(begins.iter().copied().eq(0..leaves as u32));
        }
    }
}
