//! Union-find: components of elements, each named by its lowest member.
//!
//! The parents of a run of elements may be a slice of their own, which counts from the run's first element.

use crate::memory::put;

/// Finds the representative of an element's component: its lowest member. Parents count from `first`.
pub(super) fn root_from(parents: &mut [u32], first: usize, mut element: u32) -> u32 {
    let at = |element: u32| (element as usize).wrapping_sub(first);
    // Path halving.
    while let Some(&parent) = parents.get(at(element)) {
        let grandparent = parents.get(at(parent)).copied().unwrap_or(parent);
        put(parents, at(element), grandparent);
        if parent == grandparent {
            return parent;
        }
        element = grandparent;
    }
    element
}

/// Joins the components of `a` and `b`, and tells whether they were different.
pub(super) fn unite_from(parents: &mut [u32], first: usize, a: u32, b: u32) -> bool {
    let (a, b) = (root_from(parents, first, a), root_from(parents, first, b));
    // The higher root becomes a child of the lower: no element has a higher parent, so no cycle can form.
    put(parents, (a.max(b) as usize).wrapping_sub(first), a.min(b));
    a != b
}

/// Joins the components of `a` and `b`.
pub(super) fn unite(component: &mut [u32], a: u32, b: u32) {
    unite_from(component, 0, a, b);
}

/// Makes each element's parent its representative, until components are joined.
pub(super) fn flatten(component: &mut [u32]) {
    for at in 0..component.len() {
        // No element has a higher parent, so the parent's parent is its representative by now.
        let parent = component.get(at).copied().unwrap_or(0);
        let root = component.get(parent as usize).copied().unwrap_or(parent);
        put(component, at, root);
    }
}
