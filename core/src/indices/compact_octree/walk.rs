//! The walk of one ray, as that of the wide octree.

use core::ops::ControlFlow;

use super::lanes::Unpack;
use super::{
    EDGE, EMPTY, Head, LEAF, MORE_BLOCKS, NOTHING, block_at, block_length, head, id_at, node_at,
    triangle_at, triangle_count,
};
use crate::Vectors;
use crate::geometry::{RaySpan, Span};
use crate::indices::wide_octree::lanes::{LaneRay, Portable, key};
use crate::indices::wide_octree::{LANES, STACK};
use crate::query::{Query, TriangleId};

#[inline]
pub(super) fn walk<Q: Query>(words: &[u32], vectors: Vectors, query: &mut Q) {
    #[cfg(target_arch = "x86_64")]
    if vectors.has_avx2() {
        return super::avx2::walk(words, head(words), query);
    }
    let _ = vectors;
    walk_in_lanes::<Portable, Q>(words, head(words), query);
}

/// See [`Structure::traverse_each`](crate::indices::Structure::traverse_each).
#[inline]
pub(super) fn walk_each<Q: Query>(
    words: &[u32],
    vectors: Vectors,
    count: usize,
    start: impl Fn(usize) -> Option<Q>,
    finish: impl FnMut(usize, &Q),
) {
    #[cfg(target_arch = "x86_64")]
    if vectors.has_avx2() {
        return super::avx2::walk_each(words, head(words), count, start, finish);
    }
    let _ = vectors;
    walk_each_in_lanes::<Portable, Q>(words, head(words), count, start, finish);
}

#[inline(always)]
pub(super) fn walk_in_lanes<L: Unpack, Q: Query>(words: &[u32], head: Head, query: &mut Q) {
    let Some(ray) = LaneRay::new(query.ray(), head.largest) else {
        return walk_in_f64(words, head.root, query);
    };
    let mut walk = Walk::<L>::idle();
    walk.begin(ray, head, query);
    while walk.step(words, query).is_continue() {}
}

/// As in the wide octree.
const IN_TURN: usize = 4;

#[inline(always)]
pub(super) fn walk_each_in_lanes<L: Unpack, Q: Query>(
    words: &[u32],
    head: Head,
    count: usize,
    start: impl Fn(usize) -> Option<Q>,
    mut finish: impl FnMut(usize, &Q),
) {
    let mut places = 0..count;
    // Takes the next ray that lanes can take; the others are answered at once.
    let mut next = |turn: &mut Turn<L, Q>, finish: &mut dyn FnMut(usize, &Q)| {
        for place in places.by_ref() {
            turn.place = place;
            turn.query = start(place);
            let Some(query) = &mut turn.query else { return };
            if let Some(ray) = LaneRay::new(query.ray(), head.largest) {
                turn.walk.begin(ray, head, query);
                return;
            }
            walk_in_f64(words, head.root, query);
            finish(place, query);
        }
        turn.query = None;
    };
    let mut turns: [Turn<L, Q>; IN_TURN] =
        core::array::from_fn(|_| Turn { walk: Walk::idle(), query: None, place: 0 });
    for turn in &mut turns {
        next(turn, &mut finish);
    }
    loop {
        let mut any = false;
        for turn in &mut turns {
            let Some(query) = &mut turn.query else { continue };
            any = true;
            if turn.walk.step(words, query).is_break() {
                finish(turn.place, query);
                next(turn, &mut finish);
            }
        }
        if !any {
            return;
        }
    }
}

/// One of the rays that take turns, if there is one.
struct Turn<L: Unpack, Q> {
    walk: Walk<L>,
    query: Option<Q>,
    place: usize,
}

/// The walk of one ray: the nearest child first. What is left of a node waits as one entry: its link, and
/// the keys of the children that were not entered.
struct Walk<L: Unpack> {
    ray: LaneRay,
    /// The node to be entered.
    link: u32,
    last: f32,
    stack: heapless::Vec<(L::Keys, u32), STACK>,
}

impl<L: Unpack> Walk<L> {
    /// No walk yet.
    fn idle() -> Self {
        let (ray, stack) = (LaneRay::default(), heapless::Vec::new());
        Self { ray, link: NOTHING.root, last: 0.0, stack }
    }

    /// In place: most of a walk is room for its stack.
    #[inline(always)]
    fn begin<Q: Query>(&mut self, ray: LaneRay, head: Head, query: &Q) {
        self.ray = ray;
        self.link = head.root;
        self.last = finite(query.last_t());
        self.stack.clear();
    }

    /// Enters one node; `Break` when the walk is over.
    #[inline(always)]
    fn step<Q: Query>(&mut self, words: &[u32], query: &mut Q) -> ControlFlow<()> {
        const DONE: ControlFlow<()> = ControlFlow::Break(());
        query.enter();
        let (mut keys, mut above);
        if self.link & LEAF != 0 {
            self.test_leaf(words, query)?;
            self.last = finite(query.last_t());
            let Some(top) = self.stack.pop() else { return DONE };
            (keys, above) = top;
        } else {
            let Some(node) = node_at(words, self.link) else { return DONE };
            (keys, above) = (L::meet_node(node, &self.ray, self.last), self.link);
        }
        // The nearest child that is not entered yet, of the lowest node that has one.
        let lane = loop {
            let (nearest, lane) = L::nearest(keys);
            if nearest <= key(self.last) {
                break lane;
            }
            let Some(top) = self.stack.pop() else { return DONE };
            (keys, above) = top;
        };
        let Some(node) = node_at(words, above) else { return DONE };
        self.link = node.links[lane % LANES];
        let pushed = self.stack.push((L::without(keys, lane), above)).is_ok();
        debug_assert!(pushed, "validation bounds the depth");
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn test_leaf<Q: Query>(&self, words: &[u32], query: &mut Q) -> ControlFlow<()> {
        let mut place = (self.link & !LEAF) as usize;
        // An unused lane has a link past the end.
        while let Some(block) = block_at(words, place) {
            let count = triangle_count(block);
            query.count_tests(count as u32);
            let edge = f32::from_bits(block[0] & EDGE);
            let mut candidates =
                L::meet_triangles(&L::unpack(block), &self.ray, edge, finite(query.last_t()));
            candidates &= (1 << count) - 1;
            while candidates != 0 {
                let lane = candidates.trailing_zeros() as usize % LANES;
                candidates &= candidates - 1;
                query.decide(TriangleId(id_at(block, lane)), &triangle_at(block, lane))?;
            }
            if block[0] & MORE_BLOCKS == 0 {
                break;
            }
            place += block_length(block);
        }
        ControlFlow::Continue(())
    }
}

#[inline(always)]
fn finite(t: f32) -> f32 {
    if t < f32::MAX { t } else { f32::MAX }
}

/// For rays beyond what lanes can bound: box by box, triangle by triangle.
#[cold]
#[inline(never)]
fn walk_in_f64<Q: Query>(words: &[u32], root: u32, query: &mut Q) {
    let ray = RaySpan::new(query.ray());
    let mut stack = heapless::Vec::<(u32, Span), { STACK * LANES }>::new();
    let mut next = Some((root, ray.whole()));
    while let Some((link, span)) = next.or_else(|| stack.pop()) {
        next = None;
        if span.from > query.last() {
            continue;
        }
        query.enter();
        if link & LEAF != 0 {
            let mut place = (link & !LEAF) as usize;
            while let Some(block) = block_at(words, place) {
                let count = triangle_count(block);
                query.count_tests(count as u32);
                for lane in 0..count {
                    let id = TriangleId(id_at(block, lane));
                    if query.decide(id, &triangle_at(block, lane)).is_break() {
                        return;
                    }
                }
                if block[0] & MORE_BLOCKS == 0 {
                    break;
                }
                place += block_length(block);
            }
            continue;
        }
        let Some(node) = node_at(words, link) else { continue };
        for (lane, &child) in node.links.iter().enumerate() {
            let span = ray.clip(&node.bounds(lane), span);
            if child != EMPTY && !span.is_empty() {
                let pushed = stack.push((child, span)).is_ok();
                debug_assert!(pushed, "validation bounds the depth");
            }
        }
    }
}
