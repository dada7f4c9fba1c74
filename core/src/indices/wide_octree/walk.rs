//! The walk of one ray.

use core::ops::ControlFlow;

use super::lanes::{LaneRay, Lanes, Portable, key};
use super::{
    EDGES_ROW, EMPTY, Head, IDS_ROW, LANES, LEAF, LINKS_ROW, Leaf, Row, STACK, leaf_at, leaf_count,
    node_at, rows, triangle_at,
};
use crate::geometry::{Aabb, RaySpan, Span};
use crate::memory::Image;
use crate::query::{Query, TriangleId};
use crate::{Vec3, Vectors};

#[inline]
pub(super) fn walk<Q: Query>(image: &Image<'_>, vectors: Vectors, query: &mut Q) {
    let Some((rows, head)) = rows(image) else { return };
    #[cfg(target_arch = "x86_64")]
    if vectors.has_avx2() {
        return super::avx2::walk(rows, head, query);
    }
    let _ = vectors;
    walk_in_lanes::<Portable, Q>(rows, head, query);
}

/// See [`Structure::traverse_each`](crate::indices::Structure::traverse_each).
#[inline]
pub(super) fn walk_each<Q: Query>(
    image: &Image<'_>,
    vectors: Vectors,
    count: usize,
    start: impl Fn(usize) -> Option<Q>,
    finish: impl FnMut(usize, &Q),
) {
    // Without rows there is nothing to be hit.
    let (rows, head) = rows(image).unwrap_or((&[], Head { root: EMPTY, edge: 0.0, largest: 0.0 }));
    #[cfg(target_arch = "x86_64")]
    if vectors.has_avx2() {
        return super::avx2::walk_each(rows, head, count, start, finish);
    }
    let _ = vectors;
    walk_each_in_lanes::<Portable, Q>(rows, head, count, start, finish);
}

#[inline(always)]
pub(super) fn walk_in_lanes<L: Lanes, Q: Query>(rows: &[Row], head: Head, query: &mut Q) {
    let Some(ray) = LaneRay::new(query.ray(), head.largest) else {
        return walk_in_f64(rows, head.root, query);
    };
    let mut walk = Walk::<L>::new(ray, head, query);
    while walk.step(rows, query).is_continue() {}
}

/// Rays whose walks take turns: while one waits for a node or for the end of a chain of operations, the
/// processor works for the others.
const IN_TURN: usize = 4;

#[inline(always)]
pub(super) fn walk_each_in_lanes<L: Lanes, Q: Query>(
    rows: &[Row],
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
            walk_in_f64(rows, head.root, query);
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
            if turn.walk.step(rows, query).is_break() {
                finish(turn.place, query);
                next(turn, &mut finish);
            } else {
                L::prefetch(rows, turn.walk.link);
            }
        }
        if !any {
            return;
        }
    }
}

/// One of the rays that take turns, if there is one.
struct Turn<L: Lanes, Q> {
    walk: Walk<L>,
    query: Option<Q>,
    place: usize,
}

/// The walk of one ray: the nearest child first. What is left of a node waits as one entry: its row, and
/// the keys of the children that were not entered.
struct Walk<L: Lanes> {
    ray: LaneRay,
    /// The node to be entered.
    link: u32,
    edge: f32,
    last: f32,
    stack: heapless::Vec<(L::Keys, u32), STACK>,
}

impl<L: Lanes> Walk<L> {
    /// No walk yet.
    fn idle() -> Self {
        let stack = heapless::Vec::new();
        Self { ray: LaneRay::default(), link: EMPTY, edge: 0.0, last: 0.0, stack }
    }

    #[inline(always)]
    fn new<Q: Query>(ray: LaneRay, head: Head, query: &Q) -> Self {
        let (last, stack) = (finite(query.last_t()), heapless::Vec::new());
        Self { ray, link: head.root, edge: head.edge, last, stack }
    }

    /// As `new`, in place: most of a walk is room for its stack.
    #[inline(always)]
    fn begin<Q: Query>(&mut self, ray: LaneRay, head: Head, query: &Q) {
        self.ray = ray;
        (self.link, self.edge) = (head.root, head.edge);
        self.last = finite(query.last_t());
        self.stack.clear();
    }

    /// Enters one node; `Break` when the walk is over.
    #[inline(always)]
    fn step<Q: Query>(&mut self, rows: &[Row], query: &mut Q) -> ControlFlow<()> {
        const DONE: ControlFlow<()> = ControlFlow::Break(());
        query.enter();
        let link = self.link;
        let (mut keys, mut row);
        if link & LEAF != 0 {
            if let Some(leaf) = leaf_at(rows, link) {
                let count = leaf_count(link);
                test_leaf::<L, Q>(leaf, count, self.edge, &self.ray, self.last, query)?;
                self.last = finite(query.last_t());
            }
            let Some(top) = self.stack.pop() else { return DONE };
            (keys, row) = top;
        } else {
            let Some(node) = node_at(rows, link) else { return DONE };
            (keys, row) = (L::meet_boxes(node, &self.ray, self.last), link);
        }
        // The nearest child that is not entered yet, of the lowest node that has one.
        let lane = loop {
            let (nearest, lane) = L::nearest(keys);
            if nearest <= key(self.last) {
                break lane;
            }
            let Some(top) = self.stack.pop() else { return DONE };
            (keys, row) = top;
        };
        let Some(node) = node_at(rows, row) else { return DONE };
        self.link = node[LINKS_ROW][lane];
        self.edge = f32::from_bits(node[EDGES_ROW][lane]);
        let pushed = self.stack.push((L::without(keys, lane), row)).is_ok();
        debug_assert!(pushed, "validation bounds the depth");
        ControlFlow::Continue(())
    }
}

#[inline(always)]
fn finite(t: f32) -> f32 {
    if t < f32::MAX { t } else { f32::MAX }
}

#[inline(always)]
fn test_leaf<L: Lanes, Q: Query>(
    leaf: &Leaf,
    count: u32,
    edge: f32,
    ray: &LaneRay,
    last: f32,
    query: &mut Q,
) -> ControlFlow<()> {
    query.count_tests(count);
    let mut candidates = L::meet_triangles(leaf, ray, edge, last) & ((1 << count) - 1);
    while candidates != 0 {
        let lane = candidates.trailing_zeros() as usize % LANES;
        candidates &= candidates - 1;
        query.decide(TriangleId(leaf[IDS_ROW][lane]), &triangle_at(leaf, lane))?;
    }
    ControlFlow::Continue(())
}

/// For rays beyond what `lanes` can bound: box by box, triangle by triangle.
#[cold]
#[inline(never)]
fn walk_in_f64<Q: Query>(rows: &[Row], root: u32, query: &mut Q) {
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
            let Some(leaf) = leaf_at(rows, link) else { continue };
            query.count_tests(leaf_count(link));
            for (lane, &id) in leaf[IDS_ROW].iter().enumerate().take(leaf_count(link) as usize) {
                if query.decide(TriangleId(id), &triangle_at(leaf, lane)).is_break() {
                    return;
                }
            }
            continue;
        }
        let Some(node) = node_at(rows, link) else { continue };
        for (lane, &child) in node[LINKS_ROW].iter().enumerate() {
            let number = |row: usize| f32::from_bits(node[row][lane]);
            let bounds = Aabb::new(
                Vec3::new(number(0), number(2), number(4)),
                Vec3::new(number(1), number(3), number(5)),
            );
            let span = ray.clip(&bounds, span);
            if child != EMPTY && !span.is_empty() {
                let pushed = stack.push((child, span)).is_ok();
                debug_assert!(pushed, "validation bounds the depth");
            }
        }
    }
}
