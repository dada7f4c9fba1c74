//! Join of a tree of boxes with itself, which finds the components of "boxes at most delta apart".
//!
//! ```text
//! boxes:  a a a a b b b c c d d d d d ...     the caller's order; fragments, which are one component already, are runs
//!                                             if `is_by_fragment`
//! nodes:  complete binary tree over groups of eight, each node in front of its two subtrees
//! ```
//! 1. [`within`](Join::within) a node: join the boxes of each child, then those of one child with those of the other.
//! 2. [`between`](Join::between) two nodes that are at most delta apart: descend into all four pairs of children, down
//!    to pairs of groups, which are compared box by box.
//! 3. A node is marked once all boxes below it are known to be in one component. Two marked nodes of one component need
//!    no descent.
//!
//! Because of step 3, boxes in one place take few pairs of nodes, not all. The answer is that of comparing all pairs of
//! boxes, unless that takes more than [`MOST_PAIRS`] pairs of near nodes a box. Then some boxes stay apart.
//!
//! A subtree's nodes are a run, and so are its boxes. If fragments are runs too (`is_by_fragment`), each child needs
//! only its own slices of marks and components, so an executor may run both children of a node in parallel. Components
//! are sets, whatever the order in which they grow, so the answer is the same.
//!
//! # What lost
//! - Groups of four: twice as many pairs of nodes, half as many pairs of boxes, which cost less.
//! - Leaving it to the union-find to find that two boxes are in one component: in a district of 65,000 triangles, nine
//!   of ten pairs of boxes in near groups are, and seeing it by their parents took a seventh off finding clusters.
//!
//! # Source
//! A. Gray, A. Moore, *N-Body Problems in Statistical Learning*, 2000, for pairs of nodes.

use super::near::{BoxGroup, GROUP, Nearness, bits};
use super::union_find::{root_from, unite_from};
use crate::geometry::Box4;
use crate::input::{Executor, Sequential};
use crate::memory::put;

/// Number of boxes from which on subtrees are offered to the executor.
const LARGE: usize = 4096;
/// Most pairs of near nodes for each box of a node, in the join of its two children. So the work is at most a multiple
/// of n log n, wherever the boxes lie.
///
/// # Measured
/// - 0.7 in a district, 0.3 in a city, at most 0.15 in the paper's scenes. Long boxes that cross without touching, in
///   layers, need 160 where there are 40,000, and twice that of twice as many.
const MOST_PAIRS: usize = 16;
/// The mark of a node whose boxes are not known to be in one component.
const NO_MARK: u32 = u32::MAX;

/// The number of levels above the groups of `count` boxes.
const fn height_of(count: usize) -> u32 {
    count.div_ceil(GROUP).next_power_of_two().trailing_zeros()
}

/// The number of groups of `count` boxes.
pub(super) const fn group_count(count: usize) -> usize {
    count.div_ceil(GROUP)
}

/// The number of nodes over `count` boxes.
pub(super) const fn node_count(count: usize) -> usize {
    (2 << height_of(count)) - 1
}

/// Node of the tree over the boxes.
#[derive(Clone, Copy)]
pub(super) struct JoinNode {
    /// The index of the node. Its left subtree follows, then its right one.
    at: usize,
    /// The number of levels below; 0 for a group.
    height: u32,
    /// The index of the first box below.
    first: usize,
}

impl JoinNode {
    /// The root over `count` boxes.
    pub const fn root(count: usize) -> Self {
        Self { at: 0, height: height_of(count), first: 0 }
    }

    /// The two children; `None` for a group.
    fn children(self) -> Option<[Self; 2]> {
        let height = self.height.checked_sub(1)?;
        let left = Self { at: self.at + 1, height, first: self.first };
        // A subtree of `height` has 2^(height + 1) - 1 nodes.
        let right =
            Self { at: self.at + (2 << height), height, first: self.first + (GROUP << height) };
        Some([left, right])
    }

    /// The boxes below, of `count` in all.
    fn range(self, count: usize) -> core::ops::Range<usize> {
        let end = self.first + (GROUP << self.height);
        self.first.min(count)..end.min(count)
    }
}

/// Computes the boxes of all nodes below a node, and returns its own. The recursion is as deep as the tree, at most 27
/// levels.
pub(super) fn fill(nodes: &mut [Box4], groups: &[BoxGroup], node: JoinNode) -> Box4 {
    let bounds = if let Some(children) = node.children() {
        let [left, right] = children.map(|child| fill(nodes, groups, child));
        left.union(right)
    } else {
        groups.get(node.first / GROUP).map_or(Box4::EMPTY, BoxGroup::bounds)
    };
    put(nodes, node.at, bounds);
    bounds
}

/// Join of a tree with itself.
pub(super) struct Join<'j> {
    /// The number of boxes.
    pub count: usize,
    pub groups: &'j [BoxGroup],
    pub nodes: &'j [Box4],
    pub near: Nearness,
    /// For each group the boxes, as bits, that continue the fragment of the box before: fragments are runs. `None` if
    /// they are not; then subtrees share them.
    pub continues: Option<&'j [u8]>,
}

/// Marks and components of a subtree: all that its join changes.
pub(super) struct Part<'p> {
    /// For each node a box in the component that all boxes below it belong to, once that is known.
    marks: &'p mut [u32],
    /// Union-find over the boxes.
    parents: &'p mut [u32],
    /// Index of the node that `marks` begins with.
    at: usize,
    /// Index of the box that `parents` begins with.
    first: usize,
    /// Pairs of near nodes that the join of two children may still take.
    pairs_left: usize,
    /// True if a join ended because it would have taken more.
    pub is_cut_short: bool,
}

impl<'p> Part<'p> {
    /// The part of the whole tree: nothing is marked, and `parents` are those of the fragments.
    pub fn whole(marks: &'p mut [u32], parents: &'p mut [u32]) -> Self {
        marks.fill(NO_MARK);
        Self { marks, parents, at: 0, first: 0, pairs_left: 0, is_cut_short: false }
    }

    /// The lowest box of an element's component.
    pub fn root(&mut self, element: u32) -> u32 {
        root_from(self.parents, self.first, element)
    }

    fn unite(&mut self, a: usize, b: usize) -> bool {
        unite_from(self.parents, self.first, a as u32, b as u32)
    }

    fn parent(&self, element: usize) -> Option<&u32> {
        self.parents.get(element.wrapping_sub(self.first))
    }

    /// The parents of a group's boxes; those of lanes without a box are any.
    fn parents_of(&self, group: JoinNode) -> [u32; GROUP] {
        let rest = self.parents.get(group.first.wrapping_sub(self.first)..).unwrap_or_default();
        rest.first_chunk().copied().unwrap_or_else(|| {
            let mut parents = [0; GROUP];
            for (to, from) in parents.iter_mut().zip(rest) {
                *to = *from;
            }
            parents
        })
    }

    /// Joins the components of two boxes, and tells whether they were different.
    fn join_parts(&mut self, a: usize, b: usize) -> bool {
        self.parent(a) != self.parent(b) && self.unite(a, b)
    }

    fn mark(&self, node: JoinNode) -> u32 {
        self.marks.get(node.at.wrapping_sub(self.at)).copied().unwrap_or(NO_MARK)
    }

    fn set_mark(&mut self, node: JoinNode, mark: u32) {
        put(self.marks, node.at.wrapping_sub(self.at), mark);
    }

    /// Returns a box of the component that `a` and `b` have in common, else [`NO_MARK`].
    fn common(&mut self, a: u32, b: u32) -> u32 {
        let known = a != NO_MARK && b != NO_MARK;
        if known && (a == b || self.root(a) == self.root(b)) { a } else { NO_MARK }
    }

    /// Divides the part of a node into those of its children.
    fn split(&mut self, node: JoinNode, [left, right]: [JoinNode; 2]) -> Option<[Part<'_>; 2]> {
        let marks = self.marks.get_mut(node.at.wrapping_sub(self.at)..)?;
        let (_, marks) = marks.split_at_mut_checked(left.at - node.at)?;
        let (of_left, of_right) = marks.split_at_mut_checked(right.at - left.at)?;
        let parents = self.parents.get_mut(node.first.wrapping_sub(self.first)..)?;
        let (below_left, below_right) = parents.split_at_mut_checked(right.first - left.first)?;
        let part = |marks, parents, JoinNode { at, first, .. }| Part {
            marks,
            parents,
            at,
            first,
            pairs_left: 0,
            is_cut_short: false,
        };
        Some([part(of_left, below_left, left), part(of_right, below_right, right)])
    }
}

/// Joins all near boxes, with the caller's executor.
pub(super) type JoinAll<'e> = dyn Fn(&Join<'_>, &mut Part<'_>) + 'e;

impl Join<'_> {
    /// Joins all near boxes.
    pub fn all(&self, part: &mut Part<'_>, executor: &impl Executor) {
        self.within(part, JoinNode::root(self.count), executor);
    }

    /// Joins the near boxes below a node. The recursion is as deep as the tree.
    fn within(&self, part: &mut Part<'_>, node: JoinNode, executor: &impl Executor) {
        let range = node.range(self.count);
        if range.is_empty() {
            return;
        }
        if let Some([left, right]) = node.children() {
            // 1. Join the boxes below each child; those of many in parallel.
            if self.continues.is_some()
                && range.len() >= LARGE
                && let Some([mut below_left, mut below_right]) = part.split(node, [left, right])
            {
                executor.join(
                    || self.within(&mut below_left, left, executor),
                    || self.within(&mut below_right, right, executor),
                );
                let is_cut_short = below_left.is_cut_short | below_right.is_cut_short;
                part.is_cut_short |= is_cut_short;
            } else {
                self.within_in_turn(part, left);
                self.within_in_turn(part, right);
            }
            // 2. A fragment may lie across the middle.
            self.continue_fragment(part, right.first);
            part.pairs_left = MOST_PAIRS * range.len();
            self.between(part, left, right);
        } else {
            for one in range.clone().skip(1) {
                self.continue_fragment(part, one);
            }
            // Most groups are of one fragment.
            if self.renew_mark(part, node) != NO_MARK {
                return;
            }
            let group = self.group(node);
            for one in range.clone() {
                let lane = one - range.start;
                let after = self.near.lanes(&group.get(lane), group) & u32::MAX << lane << 1;
                for other in bits(after) {
                    part.join_parts(one, range.start + other);
                }
            }
        }
        self.renew_mark(part, node);
    }

    /// [`within`](Self::within) without an executor, so that it is compiled once.
    fn within_in_turn(&self, part: &mut Part<'_>, node: JoinNode) {
        self.within(part, node, &Sequential);
    }

    /// Joins a box with the one before, if both are of one fragment.
    fn continue_fragment(&self, part: &mut Part<'_>, at: usize) {
        let of_group = self.continues.and_then(|groups| groups.get(at / GROUP));
        if of_group.is_some_and(|&boxes| boxes >> (at % GROUP) & 1 == 1) {
            part.unite(at.saturating_sub(1), at);
        }
    }

    /// Joins the boxes below `a` with the near boxes below `b`, a node of the same level. Tells whether any of them had
    /// been in different components. The recursion is as deep as the tree.
    #[inline]
    fn between(&self, part: &mut Part<'_>, a: JoinNode, b: JoinNode) -> bool {
        // 1. Prune: the nodes are too far apart. The box of a node without boxes is far from all.
        let (Some(box_a), Some(box_b)) = (self.nodes.get(a.at), self.nodes.get(b.at)) else {
            return false;
        };
        self.near.holds(box_a, box_b) && self.between_near(part, a, b)
    }

    /// Joins as [`between`](Self::between) does, where the nodes are near.
    // Apart: most pairs of nodes are too far apart, and need no frame.
    #[inline(never)]
    fn between_near(&self, part: &mut Part<'_>, a: JoinNode, b: JoinNode) -> bool {
        let Some(pairs_left) = part.pairs_left.checked_sub(1) else {
            part.is_cut_short = true;
            return false;
        };
        part.pairs_left = pairs_left;
        // 2. Prune: all boxes below both nodes are in one component. That is looked up if at least one node is marked:
        // the boxes below the other may have been joined by way of other nodes. Where neither is marked, they seldom
        // are.
        let is_marked = part.mark(a) != NO_MARK || part.mark(b) != NO_MARK;
        if is_marked && self.are_one(part, a, b) {
            return false;
        }
        // 3. Descend into the four pairs of children, or compare the boxes of two groups.
        let joined = if let (Some([a0, a1]), Some([b0, b1])) = (a.children(), b.children()) {
            // The pair of neighbours on the curve comes first: once it is joined, the others are often pruned.
            let mut joined = self.between(part, a1, b0);
            joined |= self.between(part, a0, b0);
            joined |= self.between(part, a1, b1);
            joined | self.between(part, a0, b1)
        } else {
            self.members_between(part, a, b)
        };
        // 4. Mark the nodes, if they have become one component each.
        if joined {
            self.renew_mark(part, a);
            self.renew_mark(part, b);
        }
        joined
    }

    /// Joins the near boxes of two groups, and tells whether any had been in different components.
    fn members_between(&self, part: &mut Part<'_>, a: JoinNode, b: JoinNode) -> bool {
        let box_of = |node: JoinNode| self.nodes.get(node.at).unwrap_or(&Box4::EMPTY);
        let (all_of_a, all_of_b) = (box_of(a), box_of(b));
        let (of_a, of_b) = (self.group(a), self.group(b));
        // Only boxes that are near to the whole other group are compared with its boxes.
        let near_to_a = self.near.lanes(all_of_a, of_b);
        let mut joined = false;
        if near_to_a == 0 {
            return joined;
        }
        let parents = part.parents_of(b);
        for one in bits(self.near.lanes(all_of_b, of_a)) {
            // Most are in one component already, and need no comparison.
            let parent = part.parent(a.first + one).copied().unwrap_or(0);
            let other_component = (0_u32..)
                .zip(parents)
                .fold(0, |set, (lane, of_b)| set | u32::from(of_b != parent) << lane);
            let candidates = near_to_a & other_component;
            if candidates == 0 {
                continue;
            }
            for other in bits(candidates & self.near.lanes(&of_a.get(one), of_b)) {
                joined |= part.join_parts(a.first + one, b.first + other);
            }
        }
        joined
    }

    /// The boxes of a group.
    fn group(&self, node: JoinNode) -> &BoxGroup {
        self.groups.get(node.first / GROUP).unwrap_or(&BoxGroup::EMPTY)
    }

    /// Tells whether all boxes below both nodes are known to be in one component.
    fn are_one(&self, part: &mut Part<'_>, a: JoinNode, b: JoinNode) -> bool {
        let mark = self.renew_mark(part, a);
        if mark == NO_MARK {
            return false;
        }
        let other = self.renew_mark(part, b);
        part.common(mark, other) != NO_MARK
    }

    /// Marks a node if its boxes are known to be in one component, and returns its mark.
    fn renew_mark(&self, part: &mut Part<'_>, node: JoinNode) -> u32 {
        // 1. A mark stays: components only grow.
        let known = part.mark(node);
        if known != NO_MARK {
            return known;
        }
        let mark = if let Some([left, right]) = node.children() {
            // 2. An inner node takes the component that its children have in common. The boxes fill it from the left.
            let mark = part.mark(left);
            if right.first < self.count { part.common(mark, part.mark(right)) } else { mark }
        } else {
            // 3. A group takes the component that its boxes have in common.
            let range = node.range(self.count);
            let first = range.start as u32;
            let root = part.root(first);
            // Those of the same component are often neighbours, so the last differs first.
            let are_one = range.skip(1).rev().all(|member| part.root(member as u32) == root);
            if are_one { first } else { NO_MARK }
        };
        part.set_mark(node, mark);
        mark
    }
}
