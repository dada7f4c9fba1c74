//! The passes of rays at nodes.

use core::hint::select_unpredictable;

use super::room::{Next, Room, STACK, STALE, Slot};
use crate::indices::wide::tree::InLanes;
use crate::query::Query;
use crate::simd::{Avx2, FAR, LANES, Lanes, key};

/// For closest hits: tests the boxes of each ray's node, takes the nearest child, and puts the node on the ray's stack
/// if others are left.
///
/// The boxes of the next ray are tested before the child of a ray is taken: two chains of operations that do not wait
/// for each other.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn enter_nodes<T: InLanes<Avx2>>(tree: T, room: &mut Room) {
    let Room { slots, queues, .. } = room;
    let rays = queues.take(Next::Node);
    // A link that leads nowhere meets no child, so its links are not used.
    let test = |slot: &Slot| match (
        tree.meet_node(slot.link, &slot.ray, slot.last),
        tree.links(slot.link),
    ) {
        (Some(keys), Some(links)) => (keys, links),
        _ => (bytemuck::must_cast([FAR; LANES]), &[STALE; LANES]),
    };
    let mut tested = test(&slots[rays.id(0)]);
    for at in 0..rays.count {
        let (keys, links) = tested;
        // Behind the last is an old id. Its test is not used.
        tested = test(&slots[rays.id(at + 1)]);
        let id = rays.id(at);
        let slot = &mut slots[id];
        if slot.height >= STACK as u32 {
            slot.give_up();
            queues.put(Next::TakeChild, id);
            continue;
        }
        // The keys are new, so none lies behind the last `t`.
        let (nearest, lane) = Avx2::nearest(keys);
        let rest = Avx2::without(keys, lane);
        // Without a branch, which would often be mispredicted.
        let link = select_unpredictable(nearest == FAR, STALE, links[lane]);
        // The entry is always written, and kept if a child is left.
        let entry = &mut slot.stack[slot.height as usize % STACK];
        entry.keys = bytemuck::must_cast(rest);
        entry.links = *links;
        entry.node = slot.link;
        slot.height += u32::from(Avx2::any(rest));
        slot.node = slot.link;
        slot.lane = lane as u32;
        slot.link = link;
        tree.prefetch_exactly(link);
        queues.put(Next::of(link), id);
    }
}

/// For any hit: tests the boxes of each ray's node, and puts the node on the ray's stack. The child is taken by
/// [`take_children`].
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn test_boxes<T: InLanes<Avx2>>(tree: T, room: &mut Room) {
    let Room { slots, queues, .. } = room;
    for id in queues.ids(Next::Node) {
        let slot = &mut slots[id];
        let (keys, links) =
            (tree.meet_node(slot.link, &slot.ray, slot.last), tree.links(slot.link));
        // A ray whose link leads nowhere takes another child.
        let (Some(keys), Some(links)) = (keys, links) else { continue };
        if slot.height >= STACK as u32 {
            slot.give_up();
            continue;
        }
        // The entry is always written, and kept if a child is met.
        let entry = &mut slot.stack[slot.height as usize % STACK];
        entry.keys = bytemuck::must_cast(keys);
        entry.links = *links;
        entry.node = slot.link;
        slot.height += u32::from(Avx2::any(keys));
    }
}

/// Takes the nearest child that was not entered yet, of the topmost node that waits, for each ray of a queue.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn take_children<T: InLanes<Avx2>, Q: Query>(tree: T, room: &mut Room, queue: Next) {
    let Room { slots, queues, .. } = room;
    let rays = queues.take(queue);
    for id in rays.ids() {
        let slot = &mut slots[id];
        let entry = &mut slot.stack[slot.height.wrapping_sub(1) as usize % STACK];
        let keys = bytemuck::must_cast(entry.keys);
        let (nearest, lane) = Avx2::nearest(keys);
        let rest = Avx2::without(keys, lane);
        entry.keys = bytemuck::must_cast(rest);
        // Nothing is ever behind the last `t` of an any-hit query.
        let is_stale = !Q::ANY && nearest > key(slot.last);
        slot.height -= u32::from(is_stale | !Avx2::any(rest));
        slot.node = entry.node;
        slot.lane = lane as u32;
        // Without a branch, which would often be mispredicted.
        let link = select_unpredictable(is_stale, STALE, entry.links[lane]);
        slot.link = link;
        tree.prefetch(link);
        queues.put(Next::of(link), id);
    }
}

/// Drops the topmost entries from the stack of a ray that was just hit, up to two, if all their children lie behind the
/// hit. Without a branch, which would often be mispredicted.
///
/// A third is found when a child is taken from it; the ray then takes another child in the next round.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn drop_stale(slot: &mut Slot) {
    let last = key(slot.last);
    let is_stale = |below: u32| {
        // `StackEntry::BOTTOM` never is.
        let level = slot.height.saturating_sub(1 + below) as usize % STACK;
        let (nearest, _) = Avx2::nearest(bytemuck::must_cast(slot.stack[level].keys));
        u32::from(nearest > last)
    };
    let first = is_stale(0);
    let second = first & is_stale(1);
    slot.height -= first + second;
}
