//! The walk of one ray.

use core::ops::ControlFlow;

use super::lanes::{LaneRay, Portable};
use super::{
    EMPTY, IDS_ROW, LANES, LEAF, LINKS_ROW, Row, STACK, leaf_at, leaf_count, node_at, rows,
};
use crate::Vec3;
use crate::geometry::{Aabb, RaySpan, Span, Triangle};
use crate::indices::Local;
use crate::query::{Query, TriangleId};

/// Eight boxes, or eight triangles, at once.
pub(super) trait Lanes {
    /// The boxes that the ray may meet up to `last`, one bit each, and where it enters them at the
    /// earliest.
    fn meet_boxes(node: &[Row; 7], ray: &LaneRay, last: f32) -> (u32, [f32; LANES]);

    /// The triangles that the ray may hit at `t_min..=last`, one bit each; of unused lanes, anything.
    fn meet_triangles(leaf: &[Row; 10], ray: &LaneRay, last: f32) -> u32;
}

/// A child to be entered, and where the ray enters it at the earliest.
type Entry = (u32, f32);

#[inline]
pub(super) fn walk<Q: Query>(
    local: &Local<'_>,
    ray: &RaySpan,
    span: Span,
    query: &mut Q,
) -> ControlFlow<()> {
    let rows = rows(local);
    let Some(root) = rows.first().map(|row| row[0]) else {
        return ControlFlow::Continue(());
    };
    let bounds = local.bounds;
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let largest = [bounds.lo, bounds.hi]
        .into_iter()
        .flat_map(|corner| corner.to_array())
        .fold(0.0, |all, x| larger(all, x.abs()));
    let Some(lane_ray) = LaneRay::new(query.ray(), largest) else {
        return walk_in_f64(rows, root, ray, span, query);
    };
    #[cfg(target_arch = "x86_64")]
    if ray.vectors().has_avx2() {
        return super::avx2::walk(rows, root, &lane_ray, query);
    }
    walk_in_lanes::<Portable, Q>(rows, root, &lane_ray, query)
}

/// The nearest child first; the others wait, the nearest on top.
#[inline(always)]
pub(super) fn walk_in_lanes<L: Lanes, Q: Query>(
    rows: &[Row],
    root: u32,
    ray: &LaneRay,
    query: &mut Q,
) -> ControlFlow<()> {
    let mut stack = heapless::Vec::<Entry, STACK>::new();
    let mut next = Some((root, ray.t_min));
    while let Some((link, entry)) = next.or_else(|| stack.pop()) {
        next = None;
        let last = query.last_t();
        if entry > last {
            continue;
        }
        query.enter();
        if link & LEAF != 0 {
            let Some(leaf) = leaf_at(rows, link) else { continue };
            let count = leaf_count(link);
            query.count_tests(count);
            let mut candidates = L::meet_triangles(leaf, ray, last) & ((1 << count) - 1);
            while candidates != 0 {
                let lane = candidates.trailing_zeros() as usize % LANES;
                candidates &= candidates - 1;
                query.decide(TriangleId(leaf[IDS_ROW][lane]), &triangle_at(leaf, lane))?;
            }
            continue;
        }
        let Some(node) = node_at(rows, link) else { continue };
        let (mut met, entries) = L::meet_boxes(node, ray, last);
        if met == 0 {
            continue;
        }
        let lane = met.trailing_zeros() as usize % LANES;
        met &= met - 1;
        let mut nearest = (node[LINKS_ROW][lane], entries[lane]);
        let bottom = stack.len();
        while met != 0 {
            let lane = met.trailing_zeros() as usize % LANES;
            met &= met - 1;
            let mut child = (node[LINKS_ROW][lane], entries[lane]);
            if child.1 < nearest.1 {
                core::mem::swap(&mut child, &mut nearest);
            }
            push_sorted(&mut stack, bottom, child);
        }
        next = Some(nearest);
    }
    ControlFlow::Continue(())
}

/// Pushes a child below those from `bottom` on that are nearer.
#[inline(always)]
fn push_sorted(stack: &mut heapless::Vec<Entry, STACK>, bottom: usize, child: Entry) {
    let pushed = stack.push(child).is_ok();
    debug_assert!(pushed, "validation bounds the depth");
    let Some(new) = stack.get_mut(bottom..) else { return };
    let mut carried = child;
    let mut place = new.len().saturating_sub(1);
    while place > 0 {
        let Some(&below) = new.get(place - 1) else { return };
        if below.1 >= carried.1 {
            break;
        }
        if let Some(slot) = new.get_mut(place) {
            *slot = below;
        }
        place -= 1;
    }
    if let Some(slot) = new.get_mut(place) {
        core::mem::swap(slot, &mut carried);
    }
}

#[inline(always)]
fn triangle_at(leaf: &[Row; 10], lane: usize) -> Triangle {
    let number = |row: usize| f32::from_bits(leaf[row][lane]);
    let corner = |row: usize| Vec3::new(number(row), number(row + 1), number(row + 2));
    Triangle::new(corner(0), corner(3), corner(6))
}

/// For rays beyond what `lanes` can bound: box by box, triangle by triangle.
fn walk_in_f64<Q: Query>(
    rows: &[Row],
    root: u32,
    ray: &RaySpan,
    span: Span,
    query: &mut Q,
) -> ControlFlow<()> {
    let mut stack = heapless::Vec::<(u32, Span), STACK>::new();
    let mut next = Some((root, span));
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
                Vec3::new(number(0), number(1), number(2)),
                Vec3::new(number(3), number(4), number(5)),
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
