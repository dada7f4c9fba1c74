//! Collapse of binary splits into nodes of up to eight children (BVH8), by dynamic programming.
//!
//! The cost of a node is the half area of its box, because that is how often it is entered. A *forest* of a subset is a
//! way to represent it as several subtrees side by side, whose roots become children of one node above.
//!
//! 1. Bottom-up, [`Forest::join`] fills a table for each binary split: the least cost of the subset as a forest of at
//!    most 1, 2, ... 8 subtrees. It follows from the tables of both halves: for each number of subtrees, the best share
//!    of them for the left half. As one subtree, the subset is a node whose children are the best forest of eight.
//! 2. Each [`BinarySplit`] stores the shares that won, and the rows that the node takes.
//! 3. Top-down, [`Subtree::children`] reads the shares: it hands eight to the split, its share to each half, and so on,
//!    until a share is one.
//!
//! # What lost
//! - Filling nodes from above, by dividing the costliest part until there are eight: nodes have fewer children (4.2
//!   instead of 6.1 on figure 4), 1 to 4 bytes a triangle more, and a ray enters up to 7% more nodes.
//! - Reinsertion of the leaves before the collapse, three passes over all nodes (D. Meister, J. Bittner, *Parallel
//!   Reinsertion for Bounding Volume Hierarchy Optimization*, 2018): four to ten times the build. Rays that leave the
//!   surfaces evenly enter 3% fewer nodes in a district, and as many to 3% more in figures 3 and 4(b), a city and a mesh.
//! - Costs by the number of 1,024 sampled rays that meet a box, in addition: within 1% of that.
//!
//! # Source
//! H. Ylitie, T. Karras, S. Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*,
//! 2017, section 3.

use arrayvec::ArrayVec;
use bytemuck::{Pod, Zeroable};

use super::primitive::Primitive;
use crate::indices::wide::rows::{LANES, LEAF_ROWS, NODE_ROWS, Packing};

/// Binary split, stored at the index of the primitive where its second half begins.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct BinarySplit {
    /// The indices at which the halves are split in turn; 0 for a leaf.
    halves: [u32; 2],
    /// For forests of two to eight subtrees, the share of the first half, three bits each; 0 if one subtree less costs
    /// as little. Behind them, the first half's share of the eight children of a node.
    shares: u32,
    /// The number of rows as a node, with all below.
    rows: u32,
}

const SHARE_BITS: usize = 3;
/// Index of the share of a node's children: behind those of forests of one (unused), two, ... eight subtrees.
const OF_CHILDREN: usize = LANES;

impl BinarySplit {
    /// The first half's share of `of` subtrees; 0 if one subtree less costs as little.
    fn share(&self, of: usize) -> usize {
        (self.shares >> (SHARE_BITS * of) & 7) as usize
    }
}

/// Table of the dynamic programme: the cheapest way to represent a subset as a forest of at most one, two, ... eight
/// subtrees (Ylitie et al. 2017, section 3).
#[derive(Clone, Copy)]
pub(crate) struct Forest {
    /// The least cost: the sum of the half areas of all inner nodes.
    costs: [f32; LANES],
    /// The rows of the cheapest forest, without those of roots that are leaves: which of them share rows is known only
    /// when they have a node.
    rows: [u32; LANES],
    /// The roots of the cheapest forest that are leaves.
    leaves: [LeafCounts; LANES],
    /// The index at which the subset is split; 0 for a leaf.
    at: u32,
    /// The number of looks at a primitive that the splits took.
    pub steps: u64,
}

impl Forest {
    /// The table of a leaf of `count` primitives.
    pub fn leaf(count: usize) -> Self {
        let leaves = [LeafCounts::one(count); LANES];
        Self { costs: [0.0; LANES], rows: [0; LANES], leaves, at: 0, steps: count as u64 }
    }

    /// Computes the table of a subset that is split at the primitive `at`, in a box of this half area.
    pub fn join(left: &Self, right: &Self, at: u32, half_area: f32) -> (Self, BinarySplit) {
        // 1. The least cost of `count` subtrees with at least one in each half, and the share of the left half; of
        // equals, the first. More subtrees never cost more. Beside a leaf, the right half gets all but one.
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
        // 2. As a node: the best forest of eight, and the node itself.
        let (cost, share) = divided(LANES);
        let mut shares = (share as u32) << (SHARE_BITS * OF_CHILDREN);
        let (rows, leaves) = side_by_side(LANES, share);
        let rows = rows.saturating_add(NODE_ROWS + leaves.rows());
        // 3. As a forest of at most `more + 1` subtrees: one more only if that costs less.
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

/// Numbers of primitives of up to eight leaves, four bits each.
#[derive(Clone, Copy)]
struct LeafCounts(u32);

impl LeafCounts {
    const NONE: Self = Self(0);

    fn one(count: usize) -> Self {
        Self(count as u32)
    }

    /// Appends others.
    fn and(self, others: Self) -> Self {
        let bits = u32::BITS - (self.0.leading_zeros() & !3);
        Self(self.0 | others.0.checked_shl(bits).unwrap_or(0))
    }

    /// The rows that the leaves share.
    fn rows(self) -> u32 {
        let counts = (0..LANES).map(|leaf| (self.0 >> (4 * leaf) & 15) as usize);
        Packing::of(counts.take_while(|&count| count > 0)).rows()
    }
}

/// Subtree: a run of sorted primitives. Up to eight are a leaf, more are a node.
#[derive(Clone, Copy)]
pub(crate) struct Subtree<'s> {
    pub primitives: &'s [Primitive],
    /// The splits of all primitives.
    splits: &'s [BinarySplit],
    /// The index of the first primitive.
    from: u32,
    /// The index at which the subtree is split; 0 for a leaf.
    at: u32,
}

impl<'s> Subtree<'s> {
    /// The subtree of all primitives.
    pub(crate) fn root(
        primitives: &'s [Primitive],
        splits: &'s [BinarySplit],
        forest: &Forest,
    ) -> Self {
        Self { primitives, splits, from: 0, at: forest.at }
    }

    /// The key by which [`find`](Self::find) finds the subtree.
    pub(crate) fn key(&self) -> [u32; 3] {
        [self.from, self.primitives.len() as u32, self.at]
    }

    /// Finds a subtree by its key, in the subtree of all primitives.
    pub(crate) fn find(self, [from, count, at]: [u32; 3]) -> Self {
        let primitives = self
            .primitives
            .get(from as usize..)
            .and_then(|primitives| primitives.get(..count as usize));
        Self { primitives: primitives.unwrap_or_default(), from, at, ..self }
    }

    /// The number of rows that a wide BVH takes for the subtree, if it is not a leaf that shares rows.
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

    /// Appends the subtree as a forest of at most `count` subtrees.
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

    /// The split of the subtree; `None` for a leaf.
    fn split(&self) -> Option<&'s BinarySplit> {
        self.splits.get(self.at as usize).filter(|_| self.at > 0)
    }

    /// The split and both halves; `None` for a leaf.
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

    /// The number of subtrees of a forest in which the inner nodes with a bit in `nodes` (counted from `next` in
    /// preorder) are nodes, and their cost; `None` if one of them has more than eight children.
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

    /// The least cost of at most `count` subtrees, by trying all choices of nodes.
    fn least(tree: &TestTree, leaves: usize, count: usize) -> f32 {
        let all = (0..1_u32 << (leaves - 1)).filter_map(|nodes| cost(tree, nodes, &mut 0));
        all.filter(|(subtrees, _)| *subtrees <= count)
            .map(|(_, cost)| cost)
            .fold(f32::INFINITY, f32::min)
    }

    enum TestTree {
        LeafRows,
        Divided(f32, Box<TestTree>, Box<TestTree>),
    }

    /// A tree of leaves of one primitive each, with small integers for surfaces, so that sums are exact.
    fn tree(leaves: usize, random: &mut u32) -> TestTree {
        *random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if leaves == 1 {
            return TestTree::LeafRows;
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

    /// Visits all subtrees, notes where leaves begin, and returns the rows of all.
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
