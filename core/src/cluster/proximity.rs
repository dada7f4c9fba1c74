//! Connected components of "boxes closer than delta".
//!
//! Every box asks a tree of boxes for those within delta, and a union-find joins them. A subtree all
//! of whose boxes are known to be in the asker's component already is not entered: many boxes in one
//! place therefore cost no more than few. Same answer as comparing all pairs.

use crate::geometry::Aabb;

use super::box_tree::{BoxTree, NodeRef, Scratch};

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

fn unite(component: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(component, a), root(component, b));
    // Towards the lower: the parent of an element is never higher, so no cycle can form.
    if let Some(slot) = component.get_mut(a.max(b) as usize) {
        *slot = a.min(b);
    }
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
    let mut tree = BoxTree::build(boxes, members, scratch)?;
    for place in 0..tree.members().len() {
        let member = *tree.members().get(place)?;
        let bounds = tree.box_of(member);
        Search { component, member, bounds, delta_squared }.visit(&mut tree, NodeRef::ROOT);
    }
    Some(())
}

struct Search<'c> {
    component: &'c mut [u32],
    member: u32,
    bounds: &'c Aabb,
    delta_squared: f64,
}

impl Search<'_> {
    /// Joins the asker with all near boxes below `node`. The recursion is as deep as the tree, at
    /// most 30 levels. The mark of a node names a component that all boxes below it belong to.
    fn visit(&mut self, tree: &mut BoxTree<'_>, node: NodeRef) {
        let Some(found) = tree.node(node) else {
            return;
        };
        let (bounds, mark) = (found.bounds, found.mark);
        if bounds.is_empty() || bounds.gap_squared(self.bounds) > self.delta_squared {
            return;
        }
        if mark != BoxTree::NO_MARK
            && root(self.component, mark) == root(self.component, self.member)
        {
            return;
        }
        let mark = if let Some((left, right)) = tree.children(node) {
            self.visit(tree, left);
            self.visit(tree, right);
            let mark_of = |tree: &BoxTree<'_>, child| {
                tree.node(child).filter(|n| !n.bounds.is_empty()).map(|n| n.mark)
            };
            match (mark_of(tree, left), mark_of(tree, right)) {
                (Some(left), Some(right)) => self.common(left, right),
                (Some(only), None) | (None, Some(only)) => only,
                (None, None) => BoxTree::NO_MARK,
            }
        } else {
            let mut mark = None;
            for &other in tree.group(node) {
                if tree.box_of(other).gap_squared(self.bounds) <= self.delta_squared {
                    unite(self.component, self.member, other);
                }
                mark = Some(mark.map_or(other, |mark| self.common(mark, other)));
            }
            mark.unwrap_or(BoxTree::NO_MARK)
        };
        tree.set_mark(node, mark);
    }

    /// A member of the component that both belong to, if they do.
    fn common(&mut self, a: u32, b: u32) -> u32 {
        let known = a != BoxTree::NO_MARK && b != BoxTree::NO_MARK;
        if known && root(self.component, a) == root(self.component, b) {
            a
        } else {
            BoxTree::NO_MARK
        }
    }
}
