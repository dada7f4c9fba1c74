//! The ends of a ray's way through the wavefront: it gives its answer, and the next ray gets its slot.

use super::room::{GAVE_UP, Next, Room, SLOTS, Slot, StackEntry, Taken};
use crate::geometry::MOST_COORDINATE;
use crate::indices::wide::traversal::{is_along_flat, walk_in_f64};
use crate::indices::wide::tree::Tree;
use crate::query::{BatchQuery, Hit};
use crate::simd::{Arithmetic, last_t, prepare};

/// Batch of queries, of which some are begun.
pub(super) struct Batch<S, F> {
    pub next: usize,
    pub count: usize,
    pub start: S,
    pub finish: F,
}

/// Answers the queries of some slots. `alone` traverses the tree for one query, whose stack was too short.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn answer<Q: BatchQuery, S: Fn(usize) -> Option<Q>, F: FnMut(usize, Hit)>(
    slots: &[Slot; SLOTS],
    rays: &Taken,
    batch: &mut Batch<S, F>,
    alone: impl Fn(&mut Q),
) {
    for id in rays.ids() {
        let slot = &slots[id];
        if slot.index & GAVE_UP == 0 {
            (batch.finish)(slot.index as usize, slot.hit);
            continue;
        }
        let index = (slot.index & !GAVE_UP) as usize;
        if let Some(mut query) = (batch.start)(index) {
            alone(&mut query);
            (batch.finish)(index, query.answer());
        }
    }
}

/// Begins the next rays of a batch in some slots, while there are any.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn begin<T: Tree, Q: BatchQuery, S: Fn(usize) -> Option<Q>, F: FnMut(usize, Hit)>(
    tree: T,
    room: &mut Room,
    rays: &Taken,
    batch: &mut Batch<S, F>,
) {
    let Room { slots, queues, .. } = room;
    let is_ordinary_scene = tree.largest() <= MOST_COORDINATE;
    let root = tree.root().link;
    for id in rays.ids() {
        if batch.next >= batch.count {
            break;
        }
        let index = batch.next;
        let Some(query) = (batch.start)(index) else { break };
        let slot = &mut slots[id];
        if is_ordinary_scene && prepare(query.ray(), &mut slot.ray) {
            slot.index = index as u32;
            slot.last = last_t(&query);
            batch.next += 1;
        } else if !find_ray(tree, slot, batch) {
            break;
        }
        slot.hit = Hit::NONE;
        slot.link = root;
        slot.clear_stack();
        slot.stack[0].keys = StackEntry::BOTTOM.keys;
        queues.put(Next::Node, id);
    }
}

/// Finds the next ray that lanes can trace, and prepares it in a slot; false if there is none. Rays that lanes cannot
/// trace are answered at once.
#[cold]
#[inline(never)]
fn find_ray<T: Tree, Q: BatchQuery, S: Fn(usize) -> Option<Q>, F: FnMut(usize, Hit)>(
    tree: T,
    slot: &mut Slot,
    batch: &mut Batch<S, F>,
) -> bool {
    while batch.next < batch.count {
        let index = batch.next;
        batch.next += 1;
        let Some(mut query) = (batch.start)(index) else { return false };
        let may_hit = || !is_along_flat(tree, query.ray());
        match Arithmetic::of(query.ray(), tree.largest(), may_hit, &mut slot.ray) {
            Arithmetic::Lanes => {
                slot.index = index as u32;
                slot.last = last_t(&query);
                return true;
            }
            Arithmetic::F64 => walk_in_f64(tree, &mut query),
            Arithmetic::Missed => {}
        }
        (batch.finish)(index, query.answer());
    }
    false
}
