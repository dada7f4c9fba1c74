//! Connected components of "boxes at most delta apart", by joining a tree of boxes with itself.
//!
//! 1. A union-find keeps the components.
//! 2. Neighbours on the Morton curve are joined first.
//! 3. [`within`](DualTreeJoin::within) a node: join the boxes of either child, then those of one child with those of
//!    the other.
//! 4. [`between`](DualTreeJoin::between) two nodes that are at most delta apart: descend into all four pairs of
//!    children, down to pairs of groups, which are compared box by box.
//! 5. A node is marked once all boxes below it are known to be in one component. Two marked nodes of one component need
//!    no descent.
//!
//! Because of step 5, many boxes in one place cost no more than few. The answer is that of comparing all pairs.
//!
//! # Source
//! A. Gray, A. Moore, *N-Body Problems in Statistical Learning*, 2000, for pairs of nodes.

use super::box_tree::{BoxTree, NodeRef, Scratch};
use crate::geometry::Aabb;
use crate::memory::put;

/// Finds the representative of an element's component: its lowest member.
pub(super) fn root(component: &mut [u32], mut element: u32) -> u32 {
    // Path halving.
    while let Some(&parent) = component.get(element as usize) {
        let grandparent = component.get(parent as usize).copied().unwrap_or(parent);
        put(component, element as usize, grandparent);
        if parent == grandparent {
            return parent;
        }
        element = grandparent;
    }
    element
}

/// Joins the components of `a` and `b`, and tells whether they were different.
fn unite(component: &mut [u32], a: u32, b: u32) -> bool {
    let (a, b) = (root(component, a), root(component, b));
    // The higher root becomes a child of the lower: no element has a higher parent, so no cycle can form.
    put(component, a.max(b) as usize, a.min(b));
    a != b
}

/// Joins the components of all `members` whose boxes are at most delta apart.
///
/// `None` if the scratch is too small.
pub(super) fn connect(
    boxes: &[Aabb],
    members: &mut [u32],
    delta_squared: f64,
    component: &mut [u32],
    scratch: &mut Scratch<'_>,
) -> Option<()> {
    let tree = BoxTree::build(boxes, members, scratch)?;
    let mut components = Components { parents: component, delta_squared };
    // Join neighbours on the curve. After that, most nodes are one component before any two nodes are compared.
    for (&one, &next) in tree.members().iter().zip(tree.members().iter().skip(1)) {
        components.join_near(&tree, one, next);
    }
    DualTreeJoin { tree, components }.within(NodeRef::ROOT);
    Some(())
}

/// Join of a tree with itself. The mark of a node names a component that all boxes below it belong to, once that is
/// known.
struct DualTreeJoin<'t, 'c> {
    tree: BoxTree<'t>,
    components: Components<'c>,
}

impl DualTreeJoin<'_, '_> {
    /// Joins the near boxes below a node. The recursion is as deep as the tree, at most 30 levels.
    fn within(&mut self, node: NodeRef) {
        if self.is_empty(node) {
            return;
        }
        if let Some((left, right)) = self.tree.children(node) {
            self.within(left);
            self.within(right);
            self.between(left, right);
        } else {
            self.members_within(node);
        }
        self.renew_mark(node);
    }

    /// Joins the boxes below `a` with the near boxes below `b`, a node of the same level. Tells whether any of them had
    /// been in different components. The recursion is as deep as the tree.
    fn between(&mut self, a: NodeRef, b: NodeRef) -> bool {
        let (Some(node_a), Some(node_b)) = (self.tree.node(a), self.tree.node(b)) else {
            return false;
        };
        // 1. Prune: one node is empty, or the nodes are too far apart.
        if node_a.bounds.is_empty()
            || node_b.bounds.is_empty()
            || node_a.bounds.gap_squared(&node_b.bounds) > self.components.delta_squared
        {
            return false;
        }
        // 2. Prune: all boxes below both nodes are in one component. That is looked up if at least one node is marked:
        // the boxes below the other may have been joined by way of other nodes. Where neither is marked, they seldom
        // are.
        let is_marked = node_a.mark != BoxTree::NO_MARK || node_b.mark != BoxTree::NO_MARK;
        if is_marked && self.are_one(a, b) {
            return false;
        }
        // 3. Descend into the four pairs of children, or compare the boxes of two groups.
        let joined = if let (Some(of_a), Some(of_b)) =
            (self.tree.children(a), self.tree.children(b))
        {
            // The pair of neighbours on the curve comes first: once it is joined, the others are often pruned.
            let pairs = [(of_a.1, of_b.0), (of_a.0, of_b.0), (of_a.1, of_b.1), (of_a.0, of_b.1)];
            pairs.into_iter().fold(false, |joined, (a, b)| self.between(a, b) | joined)
        } else {
            self.members_between(a, b)
        };
        // 4. Mark the nodes, if they have become one component each.
        if joined {
            self.renew_mark(a);
            self.renew_mark(b);
        }
        joined
    }

    /// Joins the near members of one group.
    fn members_within(&mut self, node: NodeRef) {
        let members = self.tree.group(node);
        for (at, &one) in members.iter().enumerate() {
            for &other in members.iter().skip(at + 1) {
                self.components.join_near(&self.tree, one, other);
            }
        }
    }

    /// Joins the near members of two groups, and tells whether any had been in different components.
    fn members_between(&mut self, a: NodeRef, b: NodeRef) -> bool {
        let all_of_b = self.tree.node(b).map_or(Aabb::EMPTY, |node| node.bounds);
        let mut joined = false;
        for &one in self.tree.group(a) {
            if self.tree.box_of(one).gap_squared(&all_of_b) <= self.components.delta_squared {
                for &other in self.tree.group(b) {
                    joined |= self.components.join_near(&self.tree, one, other);
                }
            }
        }
        joined
    }

    fn is_empty(&self, node: NodeRef) -> bool {
        self.tree.node(node).is_none_or(|node| node.bounds.is_empty())
    }

    fn mark(&self, node: NodeRef) -> u32 {
        self.tree.node(node).map_or(BoxTree::NO_MARK, |node| node.mark)
    }

    /// Tells whether all boxes below both nodes are known to be in one component.
    fn are_one(&mut self, a: NodeRef, b: NodeRef) -> bool {
        let mark = self.renew_mark(a);
        if mark == BoxTree::NO_MARK {
            return false;
        }
        let other = self.renew_mark(b);
        self.components.common(mark, other) != BoxTree::NO_MARK
    }

    /// Marks a node if its boxes are known to be in one component, and returns its mark.
    fn renew_mark(&mut self, node: NodeRef) -> u32 {
        // 1. A mark stays: components only grow.
        let known = self.mark(node);
        if known != BoxTree::NO_MARK {
            return known;
        }
        // 2. An inner node takes the component that its non-empty children have in common.
        let mark = if let Some((left, right)) = self.tree.children(node) {
            match (self.is_empty(left), self.is_empty(right)) {
                (false, false) => {
                    let (left, right) = (self.mark(left), self.mark(right));
                    self.components.common(left, right)
                }
                (_, true) => self.mark(left),
                (true, _) => self.mark(right),
            }
        } else {
            let members = self.tree.group(node);
            // 3. A group takes the component that its members have in common.
            let first = members.first().copied().unwrap_or(BoxTree::NO_MARK);
            members.iter().fold(first, |mark, &member| self.components.common(mark, member))
        };
        self.tree.set_mark(node, mark);
        mark
    }
}

/// Union-find over boxes, and the largest gap that joins two.
struct Components<'c> {
    parents: &'c mut [u32],
    delta_squared: f64,
}

impl Components<'_> {
    /// Joins the components of two boxes if the boxes are near, and tells whether the components were different.
    fn join_near(&mut self, tree: &BoxTree<'_>, a: u32, b: u32) -> bool {
        self.parents.get(a as usize) != self.parents.get(b as usize)
            && tree.box_of(a).gap_squared(tree.box_of(b)) <= self.delta_squared
            && unite(self.parents, a, b)
    }

    /// Returns a member of the component that `a` and `b` have in common, else [`BoxTree::NO_MARK`].
    fn common(&mut self, a: u32, b: u32) -> u32 {
        let known = a != BoxTree::NO_MARK && b != BoxTree::NO_MARK;
        if known && root(self.parents, a) == root(self.parents, b) { a } else { BoxTree::NO_MARK }
    }
}
