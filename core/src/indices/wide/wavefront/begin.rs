//! The ends of a ray's way through the wavefront: it gets a slot, and gives its answer.

use super::room::{Entry, GAVE_UP, Room, SLOTS, Slot};
use crate::indices::wide::traversal::{is_along_flat, walk_in_f64};
use crate::indices::wide::tree::Tree;
use crate::query::{BatchQuery, Hit};
use crate::simd::{PreparedRay, last_t};

/// Batch of queries, of which some are begun.
pub(super) struct Batch<S, F> {
    pub next: usize,
    pub count: usize,
    pub start: S,
    pub finish: F,
}

impl<S, F> Batch<S, F> {
    /// Gives the next ray that lanes can trace to a slot, and queues it. Rays that lanes cannot trace are answered at
    /// once.
    #[allow(clippy::inline_always)] // as the passes, which are compiled for the instructions of their lanes
    #[inline(always)]
    pub fn begin<T: Tree, Q: BatchQuery>(&mut self, tree: T, id: usize, room: &mut Room)
    where
        S: Fn(usize) -> Option<Q>,
        F: FnMut(usize, Hit),
    {
        while self.next < self.count {
            let index = self.next;
            self.next += 1;
            let Some(mut query) = (self.start)(index) else { return };
            let may_hit = || !is_along_flat(tree, query.ray());
            match PreparedRay::of(query.ray(), tree.largest(), may_hit) {
                PreparedRay::Lanes(ray) => {
                    let slot = &mut room.slots[id % SLOTS];
                    slot.ray = ray;
                    slot.link = tree.root().link;
                    slot.index = index as u32;
                    slot.hit = Hit::NONE;
                    slot.last = last_t(&query);
                    slot.height = 1;
                    slot.stack[0].keys = Entry::BOTTOM.keys;
                    room.nodes.push_if(id, true);
                    return;
                }
                PreparedRay::F64 => walk_in_f64(tree, &mut query),
                PreparedRay::Missed => {}
            }
            (self.finish)(index, query.answer());
        }
    }

    /// Answers the query of a slot.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn end<Q: BatchQuery>(&mut self, slot: &Slot, alone: impl Fn(&mut Q))
    where
        S: Fn(usize) -> Option<Q>,
        F: FnMut(usize, Hit),
    {
        let (index, mut hit) = ((slot.index & !GAVE_UP) as usize, slot.hit);
        if slot.index & GAVE_UP != 0
            && let Some(mut query) = (self.start)(index)
        {
            alone(&mut query);
            hit = query.answer();
        }
        (self.finish)(index, hit);
    }
}
