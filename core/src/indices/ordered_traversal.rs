//! Traversal of a binary tree, the nearer child first: shared by cluster tree, BVH, kd-tree and BSP tree.

use core::ops::ControlFlow;

use arrayvec::ArrayVec;

use crate::geometry::{RaySpan, Span};
use crate::query::Query;

/// Node to be entered, and the part of the ray in it.
pub(super) type Entry<N> = (N, Span);

/// What a node leads to: the child to be entered next, and the child to be entered after all of its subtree.
pub(super) type Children<N> = (Option<Entry<N>>, Option<Entry<N>>);

/// Orders two children by where the ray enters them; of two at the same distance, the left first.
#[inline]
pub(super) fn near_first<N>(left: Option<Entry<N>>, right: Option<Entry<N>>) -> Children<N> {
    match (left, right) {
        (Some(l), Some(r)) if r.1.from < l.1.from => (Some(r), Some(l)),
        (None, right) => (right, None),
        (left, right) => (left, right),
    }
}

/// Traverses a tree from `root`: of each node the nearer child at once, and the other one later unless it begins beyond
/// [`RaySpan::last`].
///
/// `visit` tests the triangles of a leaf, which has no children, or finds those that the ray meets. Each level leaves
/// one child waiting, so `DEPTH` is that of the deepest level.
#[inline]
pub(super) fn walk_near_first<const DEPTH: usize, N: Copy, Q: Query>(
    root: Entry<N>,
    ray: &RaySpan,
    query: &mut Q,
    mut visit: impl FnMut(N, Span, &mut Q) -> ControlFlow<(), Children<N>>,
) -> ControlFlow<()> {
    let mut later = ArrayVec::<Entry<N>, DEPTH>::new();
    let (mut node, mut span) = root;
    loop {
        query.enter();
        let (near, far) = visit(node, span, query)?;
        if let Some(far) = far {
            let pushed = later.try_push(far).is_ok();
            debug_assert!(pushed, "validation bounds the depth");
        }
        (node, span) = match near {
            Some(near) if near.1.from <= ray.last(query.last_t()) => near,
            _ => loop {
                let Some(next) = later.pop() else { return ControlFlow::Continue(()) };
                if next.1.from <= ray.last(query.last_t()) {
                    break next;
                }
            },
        };
    }
}
