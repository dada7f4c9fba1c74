//! Memory of a wavefront: rays in flight, their stacks, and the queues of their next steps.

use bytemuck::{Pod, Zeroable};

use crate::geometry::LaneRay;
use crate::indices::wide::rows::{LANES, LEAF_BIT};
use crate::memory::ALIGNMENT;
use crate::query::Hit;
use crate::simd::{FAR, Quad};

/// Number of rays in flight: a power of two, so that a number of a slot is brought in bounds without a branch.
///
/// # What lost
/// 64 rays: 2 to 5% slower on Zen 4, whose first cache has 32 KiB. With the passes of the first wavefront, 64 were 5%
/// faster on Zen 5, whose first cache has 48 KiB.
pub(super) const SLOTS: usize = 32;

/// Number of entries of a ray's stack: a power of two, so that an index is brought in bounds without a branch. A ray
/// that needs more is traversed on its own.
pub(super) const STACK: usize = 16;

/// Link of a ray that has to take another child: its topmost waiting node lies behind its hit, or it meets no child of
/// its node. Also the link of an unused
/// lane in quantised nodes, which a ray meets where planes fall together.
pub(super) const STALE: u32 = u32::MAX;
/// Link of a ray whose walk is over. It leads past the end of every tree.
pub(super) const DONE: u32 = u32::MAX - 1;

/// Bit of a slot's index: the ray needs a longer stack, and is traversed on its own in the end.
pub(super) const GAVE_UP: u32 = 1 << 31;

/// Largest number of queries in a batch.
pub(crate) const MOST: usize = GAVE_UP as usize - 1;

/// Ray in flight: two cache lines, and its stack. Slots are 18 lines apart: a power of two would put the first lines of
/// all slots into few sets of the first cache.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Slot {
    pub ray: LaneRay,
    /// Link that the ray follows next: to a node, to a leaf, [`DONE`] or [`STALE`].
    pub link: u32,
    /// The node of which that is a child.
    pub node: u32,
    /// The child's lane in the node.
    pub lane: u32,
    /// The number of entries on the stack; the lowest is [`StackEntry::BOTTOM`].
    pub height: u32,
    /// The index of the ray's query in the batch; and [`GAVE_UP`], if the stack was too short.
    pub index: u32,
    /// The answer so far: [`Hit::NONE`] if there is none.
    pub hit: Hit,
    /// The `t` beyond which hits no longer matter; finite.
    pub last: f32,
    pub stack: [StackEntry; STACK],
}

impl Slot {
    /// Drops all entries but the lowest. A ray that takes its next child then ends its walk.
    pub fn clear_stack(&mut self) {
        self.height = 1;
    }

    /// Leaves the ray, which needs a longer stack, to a traversal on its own.
    pub fn give_up(&mut self) {
        self.index |= GAVE_UP;
        self.clear_stack();
    }
}

/// Node that waits: a cache line.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct StackEntry {
    /// The keys of the children that are not entered yet.
    pub keys: [u16; LANES],
    pub links: [u32; LANES],
    /// The link of the node.
    pub node: u32,
    unused: [u32; 3],
}

impl StackEntry {
    /// Entry below all others. Its nearest child is the end of the walk, which thus needs no branch.
    pub const BOTTOM: Self = Self {
        keys: [0, FAR, FAR, FAR, FAR, FAR, FAR, FAR],
        links: [DONE; LANES],
        node: DONE,
        unused: [0; 3],
    };
}

/// What a ray does next, and so the queue in which it waits.
#[derive(Clone, Copy)]
pub(super) enum Next {
    /// Enters a node.
    Node,
    /// Enters a leaf.
    Leaf,
    /// Gives its answer: its walk is over.
    Answer,
    /// Takes another child from its stack.
    TakeChild,
}

impl Next {
    /// What a ray does next that follows a link.
    // Forced: what calls it is compiled for the instructions of its lanes.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn of(link: u32) -> Self {
        const { assert!(DONE == u32::MAX - 1 && STALE == u32::MAX) };
        // Without a branch: 0 for a node, 1 for a leaf, 2 for `DONE`, 3 for `STALE`.
        match u32::from(link & LEAF_BIT != 0) + link.saturating_sub(DONE - 1) {
            0 => Self::Node,
            1 => Self::Leaf,
            2 => Self::Answer,
            _ => Self::TakeChild,
        }
    }
}

/// Queues of rays, as numbers of slots, by what the rays do next.
///
/// A ray waits in one queue at a time, so a queue has room for all.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Queues {
    ids: [[u8; SLOTS]; QUEUES],
    counts: [u32; QUEUES],
    unused: [u32; 12],
}

const QUEUES: usize = 4;

// Forced: what calls them is compiled for the instructions of its lanes.
#[allow(clippy::inline_always)]
impl Queues {
    /// Empties all.
    pub fn clear(&mut self) {
        self.counts = [0; QUEUES];
    }

    /// The number of rays in a queue.
    #[inline(always)]
    pub fn count(&self, queue: Next) -> usize {
        self.counts[queue as usize] as usize
    }

    /// Tells whether any ray waits.
    #[inline(always)]
    pub fn any(&self) -> bool {
        self.counts != [0; QUEUES]
    }

    /// Adds a ray to a queue.
    #[inline(always)]
    pub fn put(&mut self, queue: Next, id: usize) {
        let count = &mut self.counts[queue as usize];
        self.ids[queue as usize][*count as usize % SLOTS] = id as u8;
        *count += 1;
    }

    /// The rays in a queue.
    #[inline(always)]
    pub fn ids(&self, queue: Next) -> impl Iterator<Item = usize> {
        slots_of(&self.ids[queue as usize], self.count(queue))
    }

    /// Empties a queue, and returns what was in it.
    #[inline(always)]
    pub fn take(&mut self, queue: Next) -> Taken {
        let count = core::mem::take(&mut self.counts[queue as usize]);
        Taken { ids: self.ids[queue as usize], count: count as usize }
    }
}

/// Rays that were taken from a queue.
pub(super) struct Taken {
    ids: [u8; SLOTS],
    pub count: usize,
}

#[allow(clippy::inline_always)]
impl Taken {
    /// All rays.
    pub fn all() -> Self {
        Self { ids: core::array::from_fn(|id| id as u8), count: SLOTS }
    }

    /// The ray at a place. Past the last: any slot.
    #[inline(always)]
    pub fn id(&self, at: usize) -> usize {
        self.ids[at % SLOTS] as usize % SLOTS
    }

    /// The rays in their order.
    #[inline(always)]
    pub fn ids(&self) -> impl Iterator<Item = usize> {
        slots_of(&self.ids, self.count)
    }
}

/// The first `count` of some ids.
#[allow(clippy::inline_always)]
#[inline(always)]
fn slots_of(ids: &[u8; SLOTS], count: usize) -> impl Iterator<Item = usize> {
    ids.get(..count).unwrap_or(&[]).iter().map(|&id| id as usize % SLOTS)
}

/// Number of [quads](Quad) of candidates that wait to be judged.
pub(super) const QUADS: usize = 16;

/// All memory of a wavefront. Its contents before a batch do not matter.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Room {
    pub(super) slots: [Slot; SLOTS],
    /// Triangles that the filter of leaves did not reject.
    pub(super) quads: [Quad; QUADS],
    pub(super) queues: Queues,
}

/// Bytes of which any slice holds a [`Room`], wherever it begins.
pub(crate) const SCRATCH: usize = size_of::<Room>() + ALIGNMENT - 1;

impl Room {
    /// Finds room in a caller's bytes; `None` if there are too few.
    pub fn of(scratch: &mut [u8]) -> Option<&mut Self> {
        let skipped = scratch.as_ptr().addr().wrapping_neg() % ALIGNMENT;
        let bytes = scratch.get_mut(skipped..)?.get_mut(..size_of::<Self>())?;
        bytemuck::try_from_bytes_mut(bytes).ok()
    }
}
