//! Traversal of a binary tree, the nearer child first: shared by cluster tree, BVH, kd-tree and BSP tree.

use core::ops::ControlFlow;

use arrayvec::ArrayVec;

use crate::geometry::Span;
use crate::query::Query;

/// Node to be entered, and the part of the ray in it.
pub(super) type Entry<N> = (N, Span);

/// Stack of nodes still to be entered. Each level leaves one child waiting, so `DEPTH` is that of the deepest level.
pub(super) struct Waiting<N, const DEPTH: usize> {
    next: Option<Entry<N>>,
    later: ArrayVec<Entry<N>, DEPTH>,
}

impl<N, const DEPTH: usize> Waiting<N, DEPTH> {
    /// Schedules `near`, if there is one, as the next node, and `far` after all of its subtree.
    #[inline]
    pub fn enter(&mut self, near: Option<Entry<N>>, far: Option<Entry<N>>) {
        if let Some(far) = far {
            let pushed = self.later.try_push(far).is_ok();
            debug_assert!(pushed, "validation bounds the depth");
        }
        self.next = near;
    }

    /// Schedules both children by where the ray enters them; of two at the same distance, the left first.
    #[inline]
    pub fn enter_sorted(&mut self, left: Option<Entry<N>>, right: Option<Entry<N>>) {
        match (left, right) {
            (Some(l), Some(r)) if r.1.from < l.1.from => self.enter(Some(r), Some(l)),
            (None, right) => self.enter(right, None),
            (left, right) => self.enter(left, right),
        }
    }
}

/// Traverses a tree from `root`: of each node the nearer child at once, and the other one later unless it begins beyond
/// [`Query::last`].
///
/// `visit` tests the triangles of a leaf, or schedules the children that the ray meets.
#[inline]
pub(super) fn walk_near_first<const DEPTH: usize, N, Q: Query>(
    root: Entry<N>,
    query: &mut Q,
    mut visit: impl FnMut(N, Span, &mut Q, &mut Waiting<N, DEPTH>) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut waiting = Waiting { next: Some(root), later: ArrayVec::new() };
    while let Some((node, span)) = waiting.next.take().or_else(|| waiting.later.pop()) {
        if span.from <= query.last() {
            query.enter();
            visit(node, span, query, &mut waiting)?;
        }
    }
    ControlFlow::Continue(())
}
