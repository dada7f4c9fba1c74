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
pub(super) fn walk<Q: Query>(
    image: &Image<'_>,
    vectors: Vectors,
    query: &mut Q,
) -> ControlFlow<()> {
    let Some((rows, head)) = rows(image) else {
        return ControlFlow::Continue(());
    };
    let Some(ray) = LaneRay::new(query.ray(), head.largest) else {
        return walk_in_f64(rows, head.root, query);
    };
    #[cfg(target_arch = "x86_64")]
    if vectors.has_avx2() {
        return super::avx2::walk(rows, head, &ray, query);
    }
    let _ = vectors;
    walk_in_lanes::<Portable, Q>(rows, head, &ray, query)
}

/// The nearest child first. What is left of a node waits as one entry: its row, and the keys of the
/// children that were not entered.
#[inline(always)]
pub(super) fn walk_in_lanes<L: Lanes, Q: Query>(
    rows: &[Row],
    head: Head,
    ray: &LaneRay,
    query: &mut Q,
) -> ControlFlow<()> {
    let mut stack = heapless::Vec::<(L::Keys, u32), STACK>::new();
    let (mut link, mut edge) = (head.root, head.edge);
    // Beyond the largest number nothing is hit; an entry at infinity is none.
    let mut last = finite(query.last_t());
    loop {
        query.enter();
        let mut keys;
        let mut row;
        if link & LEAF != 0 {
            if let Some(leaf) = leaf_at(rows, link) {
                test_leaf::<L, Q>(leaf, leaf_count(link), edge, ray, last, query)?;
                last = finite(query.last_t());
            }
            let Some(top) = stack.pop() else { break };
            (keys, row) = top;
        } else {
            let Some(node) = node_at(rows, link) else { break };
            keys = L::meet_boxes(node, ray, last);
            row = link;
        }
        // The nearest child that is not entered yet, of the lowest node that has one.
        let lane = loop {
            let (nearest, lane) = L::nearest(keys);
            if nearest <= key(last) {
                break lane;
            }
            let Some(top) = stack.pop() else { return ControlFlow::Continue(()) };
            (keys, row) = top;
        };
        let Some(node) = node_at(rows, row) else { break };
        (link, edge) = (node[LINKS_ROW][lane], f32::from_bits(node[EDGES_ROW][lane]));
        let pushed = stack.push((L::without(keys, lane), row)).is_ok();
        debug_assert!(pushed, "validation bounds the depth");
    }
    ControlFlow::Continue(())
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
fn walk_in_f64<Q: Query>(rows: &[Row], root: u32, query: &mut Q) -> ControlFlow<()> {
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
                query.decide(TriangleId(id), &triangle_at(leaf, lane))?;
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
    ControlFlow::Continue(())
}
