//! The passes of rays at nodes.

use core::hint::select_unpredictable;

use super::room::{DONE, GAVE_UP, Queue, Room, SLOTS, STACK, STALE, Slot};
use crate::indices::wide::tree::InLanes;
use crate::query::Query;
use crate::simd::{Avx2, Lanes, key};

/// Tests the boxes of each ray's node, and puts the node on the ray's stack.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn test_boxes<T: InLanes<Avx2>>(tree: T, room: &mut Room) {
    let Room { slots, nodes, .. } = room;
    for id in nodes.ids() {
        let slot = &mut slots[id];
        let (keys, links) =
            (tree.meet_node(slot.link, &slot.ray, slot.last), tree.links(slot.link));
        let (Some(keys), Some(links)) = (keys, links) else {
            slot.clear_stack();
            continue;
        };
        if slot.height >= STACK as u32 {
            slot.index |= GAVE_UP;
            slot.clear_stack();
            continue;
        }
        // The entry is always written, and kept if a child is met.
        let entry = &mut slot.stack[slot.height as usize % STACK];
        entry.keys = bytemuck::must_cast(keys);
        entry.links = links;
        entry.node = slot.link;
        slot.height += u32::from(Avx2::any(keys));
    }
}

/// Takes each ray's nearest child that was not entered yet, of its topmost node that waits, and queues the ray by it.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn take_children<T: InLanes<Avx2>, Q: Query>(tree: T, room: &mut Room, queue: &Queue) {
    let Room { slots, nodes, others, .. } = room;
    let mut node_count = nodes.count;
    let mut count = nodes.count + others.count;
    for id in queue.ids() {
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
        // Both queues get the id, and one counts it.
        nodes.put(node_count, id);
        others.put(count - node_count, id);
        count += 1;
        node_count += (link >> 31) ^ 1;
    }
    nodes.count = node_count;
    others.count = count - node_count;
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

/// Sorts the rays that do not enter a node.
#[inline]
pub(super) fn sort(room: &mut Room) {
    let Room { slots, others, leaves, stale, done, .. } = room;
    let mut counts = [leaves.count, stale.count, done.count];
    for id in others.ids() {
        let link = slots[id % SLOTS].link;
        leaves.put(counts[0], id);
        counts[0] += u32::from(link < DONE);
        stale.put(counts[1], id);
        counts[1] += u32::from(link == STALE);
        done.put(counts[2], id);
        counts[2] += u32::from(link == DONE);
    }
    others.count = 0;
    [leaves.count, stale.count, done.count] = counts;
}
