//! The two passes of rays at leaves.

use core::hint::select_unpredictable;

use super::begin::Batch;
use super::nodes::drop_stale;
use super::room::{Next, QUADS, Room, SLOTS, Slot};
use crate::geometry::kernel::clamped;
use crate::indices::wide::tree::InLanes;
use crate::query::{BatchQuery, Hit, TriangleId};
use crate::simd::{Avx2, Quad, decide_each, judge_four, last_t};

/// Filters the triangles of each ray's leaf, and judges those that are left. Any-hit rays that are surely hit are done.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn test_leaves<T: InLanes<Avx2>, Q: BatchQuery, S: Fn(usize) -> Option<Q>, F>(
    tree: T,
    room: &mut Room,
    batch: &Batch<S, F>,
) {
    let rays = room.queues.take(Next::Leaf);
    let first_bundle = |slot: &Slot| {
        tree.child(slot.node, slot.lane as usize).and_then(|leaf| tree.first_bundle(leaf))
    };
    for id in rays.ids() {
        if let Some(bundle) = first_bundle(&room.slots[id]) {
            tree.prefetch_triangles(bundle);
        }
    }
    let mut count = 0;
    for id in rays.ids() {
        let mut next = first_bundle(&room.slots[id]);
        let mut is_hit = false;
        while let Some(bundle) = next {
            let slot = &mut room.slots[id];
            let found = tree.filter::<Q>(bundle, &slot.ray, slot.last).within(tree.lanes(bundle));
            let mut left = found.any;
            if Q::ANY {
                // Without a branch, which would often be mispredicted.
                is_hit = found.sure != 0;
                slot.hit.triangle = select_unpredictable(is_hit, FOUND.triangle, slot.hit.triangle);
                left = select_unpredictable(is_hit, 0, left);
            }
            // The first is always written, and kept if there is one. More are rare; for an any-hit query, so is one.
            while !Q::ANY || left != 0 {
                let triangle = tree.triangle(bundle, left.trailing_zeros() as usize);
                room.quads[count / 4 % QUADS].put(count % 4, triangle, id as u32);
                count += usize::from(left != 0);
                left &= left.wrapping_sub(1);
                if left == 0 {
                    break;
                }
            }
            if count > 4 * QUADS - 9 {
                judge(room, count, batch);
                count = 0;
            }
            next = if is_hit { None } else { tree.next_bundle(bundle) };
        }
        // A ray that is hit needs no other child.
        room.queues.put(select_unpredictable(is_hit, Next::Answer, Next::Leaf), id);
    }
    judge(room, count, batch);
}

/// Answer of an any-hit query for which some triangle is hit.
const FOUND: Hit = Hit { triangle: TriangleId(0), ..Hit::NONE };

/// Judges the first `count` candidates, four at once, and keeps the closest hit of each ray.
#[inline]
#[target_feature(enable = "avx2")]
fn judge<Q: BatchQuery, S: Fn(usize) -> Option<Q>, F>(
    room: &mut Room,
    count: usize,
    batch: &Batch<S, F>,
) {
    let Room { slots, quads, .. } = room;
    for (number, quad) in quads.iter().enumerate().take(count.div_ceil(4)) {
        let of = quad.rays.map(|slot| slot as usize % SLOTS);
        let rays = of.map(|slot| &slots[slot].ray);
        let judged = judge_four(quad, rays, of.map(|slot| slots[slot % SLOTS].last));
        // Lanes behind the last candidate have old contents.
        let used = (1 << (count - 4 * number).min(4)) - 1;
        for lane in lanes_of(judged.hits & used) {
            let slot = &mut slots[of[lane] % SLOTS];
            let (t, u, v) = (judged.t[lane], judged.u[lane], judged.v[lane]);
            let id = quad.ids[lane];
            if Q::ANY {
                slot.hit = FOUND;
                slot.clear_stack();
            } else if t < slot.last || t == slot.last && id < slot.hit.triangle {
                slot.hit = Hit { triangle: id, t, u, v: clamped(u, v) };
                slot.last = t;
                drop_stale(slot);
            }
        }
        for lane in lanes_of(judged.doubtful & used) {
            decide(&mut slots[of[lane] % SLOTS], quad, lane, batch);
        }
    }
}

/// Iterates over the lanes, of four, whose bits are set.
fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 4).then_some(lane)
    })
}

/// Decides one candidate that is left in doubt.
#[cold]
#[inline(never)]
#[target_feature(enable = "avx2")]
fn decide<Q: BatchQuery, S: Fn(usize) -> Option<Q>, F>(
    slot: &mut Slot,
    quad: &Quad,
    lane: usize,
    batch: &Batch<S, F>,
) {
    if Q::ANY && !slot.hit.is_none() {
        return;
    }
    let Some(mut query) = (batch.start)(slot.index as usize) else { return };
    query.resume(slot.hit);
    let triangle = |_| quad.triangle(lane);
    let decided = decide_each::<Avx2, Q>(1, &slot.ray, &mut query, triangle);
    slot.hit = query.answer();
    slot.last = last_t(&query);
    if decided.is_break() {
        slot.clear_stack();
    }
}
