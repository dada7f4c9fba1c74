//! Connected components of "boxes closer than delta".
//!
//! A tree of boxes is joined with itself: first the boxes below each node, then those below two nodes
//! that are within delta of each other; a union-find keeps the components. Two nodes all of whose boxes
//! are known to be in one component are not looked at: many boxes in one place therefore cost no more
//! than few. Same answer as comparing all pairs.
//!
//! # Source
//! A. Gray, A. Moore, *N-Body Problems in Statistical Learning*, 2000, for pairs of nodes.

use super::box_tree::{BoxTree, NodeRef, Scratch};
use crate::geometry::Aabb;

/// The representative of an element's component: its lowest member.
pub(super) fn root(component: &mut [u32], mut element: u32) -> u32 {
    // Path halving.
    while let Some(&parent) = component.get(element as usize) {
        let grandparent = component.get(parent as usize).copied().unwrap_or(parent);
        if let Some(slot) = component.get_mut(element as usize) {
            *slot = grandparent;
        }
        if parent == grandparent {
            return parent;
        }
        element = grandparent;
    }
    element
}

/// Joins two components, and tells whether they were two.
fn unite(component: &mut [u32], a: u32, b: u32) -> bool {
    let (a, b) = (root(component, a), root(component, b));
    // Towards the lower: the parent of an element is never higher, so no cycle can form.
    if let Some(slot) = component.get_mut(a.max(b) as usize) {
        *slot = a.min(b);
    }
    a != b
}

/// Joins the components of all `members` whose boxes are at most `delta` apart.
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
    // Neighbours on the curve: most nodes are one component then, before any two are looked at.
    for (&one, &next) in tree.members().iter().zip(tree.members().iter().skip(1)) {
        components.join_near(&tree, one, next);
    }
    DualTreeJoin { tree, components }.within(NodeRef::ROOT);
    Some(())
}

/// The mark of a node names a component that all boxes below it belong to, once that is known.
struct DualTreeJoin<'t, 'c> {
    tree: BoxTree<'t>,
    components: Components<'c>,
}

impl DualTreeJoin<'_, '_> {
    /// Joins near boxes below a node. The recursion is as deep as the tree, at most 30 levels.
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

    /// Joins boxes below one node with near ones below another of the same level, and tells whether there
    /// were any of different components. The recursion is as deep as the tree.
    fn between(&mut self, a: NodeRef, b: NodeRef) -> bool {
        let (Some(node_a), Some(node_b)) = (self.tree.node(a), self.tree.node(b)) else {
            return false;
        };
        if node_a.bounds.is_empty()
            || node_b.bounds.is_empty()
            || node_a.bounds.gap_squared(&node_b.bounds) > self.components.delta_squared
        {
            return false;
        }
        // Boxes below the one that is not marked may have been joined by way of others; where neither is, they seldom
        // have.
        let is_marked = node_a.mark != BoxTree::NO_MARK || node_b.mark != BoxTree::NO_MARK;
        if is_marked && self.are_one(a, b) {
            return false;
        }
        let joined = if let (Some(of_a), Some(of_b)) =
            (self.tree.children(a), self.tree.children(b))
        {
            // Neighbours on the curve first: once they are joined, the others need not be looked at.
            let pairs = [(of_a.1, of_b.0), (of_a.0, of_b.0), (of_a.1, of_b.1), (of_a.0, of_b.1)];
            pairs.into_iter().fold(false, |joined, (a, b)| self.between(a, b) | joined)
        } else {
            self.members_between(a, b)
        };
        if joined {
            self.renew_mark(a);
            self.renew_mark(b);
        }
        joined
    }

    /// Joins near members of one group.
    fn members_within(&mut self, node: NodeRef) {
        let members = self.tree.group(node);
        for (at, &one) in members.iter().enumerate() {
            for &other in members.iter().skip(at + 1) {
                self.components.join_near(&self.tree, one, other);
            }
        }
    }

    /// Joins near members of two groups, and tells whether any were of different components.
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

    /// Tells whether all boxes below two nodes are known to be in one component.
    fn are_one(&mut self, a: NodeRef, b: NodeRef) -> bool {
        let mark = self.renew_mark(a);
        if mark == BoxTree::NO_MARK {
            return false;
        }
        let other = self.renew_mark(b);
        self.components.common(mark, other) != BoxTree::NO_MARK
    }

    /// Marks a node whose boxes have become one component, and returns its mark.
    fn renew_mark(&mut self, node: NodeRef) -> u32 {
        let known = self.mark(node);
        if known != BoxTree::NO_MARK {
            return known;
        }
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
            let first = members.first().copied().unwrap_or(BoxTree::NO_MARK);
            members.iter().fold(first, |mark, &member| self.components.common(mark, member))
        };
        self.tree.set_mark(node, mark);
        mark
    }
}

struct Components<'c> {
    parents: &'c mut [u32],
    delta_squared: f64,
}

impl Components<'_> {
    /// Joins the components of two boxes that are near, and tells whether they were two.
    fn join_near(&mut self, tree: &BoxTree<'_>, a: u32, b: u32) -> bool {
        self.parents.get(a as usize) != self.parents.get(b as usize)
            && tree.box_of(a).gap_squared(tree.box_of(b)) <= self.delta_squared
            && unite(self.parents, a, b)
    }

    /// A member of the component that both belong to, if they do.
    fn common(&mut self, a: u32, b: u32) -> u32 {
        let known = a != BoxTree::NO_MARK && b != BoxTree::NO_MARK;
        if known && root(self.parents, a) == root(self.parents, b) { a } else { BoxTree::NO_MARK }
    }
}
