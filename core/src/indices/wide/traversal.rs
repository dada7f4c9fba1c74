//! Traversal: one ray, or several rays in turn, through any [`Tree`] of eight boxes a node. Knows no instruction set.
//!
//! 1. [`Lanes::prepare`] chooses the arithmetic of a ray: lanes of `f32`, or single boxes in `f64`.
//! 2. A [`Walk`] enters a node: all eight boxes are tested at once, which gives a key for each child that the ray
//!    meets.
//! 3. The child with the least key is entered next, the nearest first. The keys of the others wait on a stack, as one
//!    entry a node.
//! 4. At a leaf, all triangles are tested at once, and the query judges the candidates.
//! 5. A batch has four walks in turn, each a step at a time, so that memory and arithmetic latencies overlap. Larger
//!    batches have a `wavefront` instead, where there is one.
//!
//! # Measured
//! Zen 5, AVX-512, 100,000 photon rays, processor time, medians of 7 starts of the program in turns. Two starts of one
//! program differ by up to 5%; differences below 3% of which the ranges overlap are called noise here.
//! - A shorter way from the box test to the key, and from the key to the link: 4% in figure 3, 7% in a city, noise in
//!   4(b) and a mesh.
//! - A prefetch of the nearest child that waits: nothing in figure 3, 3% in 4(b), 6 to 7% in a city, a mesh and a
//!   district, 5% on a million triangles. Of the second too: 4% on a million, elsewhere noise.
//!
//! # What lost
//! - A ray that is returned from its preparation: 7 to 19% slower. It is copied in wider vectors than it was written
//!   in, and the processor waits until all of it is in its cache.
//! - An exit for nodes of which one child is met, from a mask and without the stack: 7% slower in figure 3, elsewhere
//!   noise. The number of children is another branch that may be mispredicted.
//! - Dropping up to two stale entries after a leaf without a branch, as the wavefront does: 0 to 5% slower.
//! - The ray apart from the walk, so that the height of the stack may stay in a register: 2% slower in figure 3,
//!   elsewhere noise.
//! - The prefetch of waiting children for rays that take turns: 9 to 11% slower.

use core::cell::Cell;
use core::ops::ControlFlow;

use arrayvec::ArrayVec;

use super::build::MAX_DEPTH;
use super::rows::LEAF_BIT;
use super::tree::{InLanes, Step, Tree};
use crate::Vec3;
use crate::geometry::{Aabb, LaneRay, Ray, RaySpan};
use crate::query::{BatchQuery, Hit, Query};
use crate::simd::{Arithmetic, Lanes, key, last_t};

#[inline(always)]
/// Traverses a tree for one query.
pub(crate) fn traverse<L: Lanes, T: InLanes<L>, Q: Query>(tree: T, query: &mut Q) {
    let may_hit = || !is_along_flat(tree, query.ray());
    let mut walk = Walk::<L>::new(tree.root());
    match L::prepare(query.ray(), tree.largest(), may_hit, &mut walk.ray) {
        Arithmetic::Lanes => {}
        Arithmetic::F64 => return walk_in_f64(tree, query),
        Arithmetic::Missed => return,
    }
    while walk.step::<T, Q, true>(tree, query).is_continue() {}
}

/// Length of the stack: each level leaves one entry.
const STACK: usize = MAX_DEPTH as usize;

/// Number of rays whose walks take turns: while one waits for a node or for the end of a chain of operations, the
/// processor works for the others. One ray on targets without vector registers: such a processor does not wait, and
/// each walk takes 2 KB of stack.
const IN_TURN: usize =
    if cfg!(any(target_feature = "sse2", target_feature = "neon", target_feature = "simd128")) {
        4
    } else {
        1
    };

#[inline(always)]
/// Traverses a tree for each of `count` queries, `IN_TURN` at a time.
pub(crate) fn traverse_each<L: Lanes, T: InLanes<L>, Q: BatchQuery>(
    tree: T,
    count: usize,
    start: impl Fn(usize) -> Option<Q>,
    mut finish: impl FnMut(usize, Hit),
) {
    let (root, largest) = (tree.root(), tree.largest());
    let mut indices = 0..count;
    let walking = Cell::new(IN_TURN);
    // Takes the next ray that lanes can trace. Rays that lanes cannot trace are answered at once.
    let mut next = |turn: &mut Turn<L, Q>, finish: &mut dyn FnMut(usize, Hit)| {
        for index in indices.by_ref() {
            turn.index = index;
            turn.query = start(index);
            let Some(query) = &mut turn.query else { break };
            let may_hit = || !is_along_flat(tree, query.ray());
            match L::prepare(query.ray(), largest, may_hit, &mut turn.walk.ray) {
                Arithmetic::Lanes => {
                    turn.walk.begin(root);
                    return;
                }
                Arithmetic::F64 => walk_in_f64(tree, query),
                Arithmetic::Missed => {}
            }
            finish(index, query.answer());
        }
        turn.query = None;
        walking.set(walking.get() - 1);
    };
    // As constants: turns made by a function would be copied, with the memory of their stacks.
    let mut turns: [Turn<L, Q>; IN_TURN] =
        [const { Turn { walk: Walk::IDLE, query: None, index: 0 } }; IN_TURN];
    for turn in &mut turns {
        next(turn, &mut finish);
    }
    while walking.get() > 0 {
        for turn in &mut turns {
            let Some(query) = &mut turn.query else { continue };
            if turn.walk.step::<T, Q, false>(tree, query).is_continue() {
                tree.prefetch(turn.walk.next.link);
            } else {
                finish(turn.index, query.answer());
                next(turn, &mut finish);
            }
        }
    }
}

/// Turn of a ray, if there is one.
struct Turn<L: Lanes, Q> {
    walk: Walk<L>,
    query: Option<Q>,
    index: usize,
}

/// Walk of one ray, the nearest child first. What is left of a node waits as one entry of the stack: its link, and the
/// keys of the children that were not entered.
struct Walk<L: Lanes> {
    ray: LaneRay,
    next: Step,
    /// The nodes that wait, up to `height`. Entries above are stale.
    stack: ArrayVec<(L::Keys, u32), STACK>,
    height: usize,
}

impl<L: Lanes> Walk<L> {
    /// The walk of no ray.
    const IDLE: Self =
        Self { ray: LaneRay::IDLE, next: Step::NOWHERE, stack: ArrayVec::new_const(), height: 0 };

    #[inline(always)]
    fn new(root: Step) -> Self {
        Self { ray: LaneRay::IDLE, next: root, stack: ArrayVec::new(), height: 0 }
    }

    /// Starts the walk of the prepared ray in place, because most of a walk is memory of its stack.
    #[inline(always)]
    fn begin(&mut self, root: Step) {
        self.next = root;
        self.height = 0;
    }

    /// Pops the topmost node that waits.
    #[inline(always)]
    fn pop(&mut self) -> Option<(L::Keys, u32)> {
        self.height = self.height.checked_sub(1)?;
        self.stack.get(self.height).copied()
    }

    /// Enters one node or leaf. Returns `Break` when the walk is over. `IS_ALONE`: no other ray takes turns.
    #[inline(always)]
    fn step<T: InLanes<L>, Q: Query, const IS_ALONE: bool>(
        &mut self,
        tree: T,
        query: &mut Q,
    ) -> ControlFlow<()> {
        const DONE: ControlFlow<()> = ControlFlow::Break(());
        query.enter();
        // 1. Enter a leaf and take the topmost node that waits, or enter a node.
        let (mut keys, mut above);
        if self.next.link & LEAF_BIT != 0 {
            tree.test_leaf(self.next, &self.ray, query)?;
            let Some(top) = self.pop() else { return DONE };
            (keys, above) = top;
        } else {
            let link = self.next.link;
            let Some(met) = tree.meet_node(link, &self.ray, last_t(query)) else { return DONE };
            (keys, above) = (met, link);
        }
        // 2. Find the nearest child that was not entered yet, of the lowest node that has one.
        let lane = loop {
            let (nearest, lane) = L::nearest(keys);
            if nearest <= key(last_t(query)) {
                break lane;
            }
            let Some(top) = self.pop() else { return DONE };
            (keys, above) = top;
        };
        // 3. Make it the next, and keep the rest of its node.
        let Some(child) = tree.child(above, lane) else { return DONE };
        self.next = child;
        let rest = L::without(keys, lane);
        // The entry is always written, and kept if a child is left, because a branch on that would often be
        // mispredicted. The branch on whether the stack grows is rarely taken.
        let entry = (rest, above);
        if let Some(slot) = self.stack.get_mut(self.height) {
            *slot = entry;
        } else {
            let pushed = self.stack.try_push(entry).is_ok();
            debug_assert!(pushed, "validation bounds the depth");
        }
        self.height += usize::from(L::any(rest));
        if IS_ALONE {
            prefetch_two(tree, above, rest);
        }
        ControlFlow::Continue(())
    }
}

/// Prefetches the two nearest of a node's children that wait.
///
/// A ray whose walk takes turns does not need this: it prefetches the child that it enters.
#[inline(always)]
fn prefetch_two<L: Lanes, T: InLanes<L>>(tree: T, node: u32, mut waiting: L::Keys) {
    for _ in 0..2 {
        let (_, lane) = L::nearest(waiting);
        if let Some(child) = tree.child(node, lane) {
            tree.prefetch(child.link);
        }
        waiting = L::without(waiting, lane);
    }
}

/// Tells whether each box of the root has no extent on an axis on which the direction is 0. The ray hits nothing in
/// such boxes; see [`Aabb::is_along`]. Lanes do not test this at other nodes, because every ray would pay for it.
#[cold]
#[inline(never)]
pub(super) fn is_along_flat<T: Tree>(tree: T, ray: &Ray) -> bool {
    let Step { link, .. } = tree.root();
    let flat = |_, _, bounds: Aabb| {
        if bounds.is_along(ray) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    link & LEAF_BIT == 0 && tree.for_each_child(link, flat).is_continue()
}

/// Traverses a tree in `f64`, for a ray that the bounds of lanes do not hold for: box by box, triangle by triangle, the
/// child in the last lane first.
///
/// A waiting node is its link, and a bit for each child that the ray meets and that was not entered. The span in a
/// child's box is computed again when the child is entered: kept with each child, spans would make the stack 17 KB.
#[cold]
#[inline(never)]
pub(super) fn walk_in_f64<T: Tree, Q: Query>(tree: T, query: &mut Q) {
    let largest = Vec3::splat(tree.largest());
    let ray = RaySpan::new(query.ray(), &Aabb::new(-largest, largest));
    let mut stack = ArrayVec::<(u32, u32), STACK>::new();
    let mut step = tree.root();
    loop {
        query.enter();
        if step.link & LEAF_BIT != 0 {
            if tree.decide_leaf(step, query).is_break() {
                return;
            }
        } else {
            let mut met = 0;
            let (ControlFlow::Continue(()) | ControlFlow::Break(())) =
                tree.for_each_child(step.link, |lane, _, bounds| {
                    met |= u32::from(!ray.clip(&bounds, ray.whole()).is_empty()) << lane;
                    ControlFlow::Continue(())
                });
            let pushed = stack.try_push((step.link, met)).is_ok();
            debug_assert!(pushed, "validation bounds the depth");
        }
        step = loop {
            let Some((link, waiting)) = stack.last_mut() else { return };
            let Some(lane) = waiting.checked_ilog2() else {
                stack.pop();
                continue;
            };
            *waiting ^= 1 << lane;
            if let Some((child, bounds)) = child_of(tree, *link, lane as usize)
                && ray.clip(&bounds, ray.whole()).from <= ray.last(query.last_t())
            {
                break child;
            }
        };
    }
}

/// The child in one lane of a node, and its box.
fn child_of<T: Tree>(tree: T, link: u32, lane: usize) -> Option<(Step, Aabb)> {
    let mut found = None;
    let search = tree.for_each_child(link, |at, child, bounds| {
        found = Some((child, bounds));
        if at == lane { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    found.filter(|_| search.is_break())
}
