//! Memory of a wavefront: rays in flight, their stacks, and the queues of their next steps.

use bytemuck::{Pod, Zeroable};

use crate::geometry::LaneRay;
use crate::indices::wide::rows::LANES;
use crate::memory::ALIGNMENT;
use crate::query::Hit;
use crate::simd::{FAR, Quad};

/// Number of rays in flight: a power of two, so that a number of a slot is brought in bounds without a branch.
///
/// # What lost
/// 32 rays: 5% slower in batches of 100,000 rays on Zen 5, whose first cache has 48 KiB; as fast in batches of 1,024.
pub(super) const SLOTS: usize = 64;

/// Number of entries of a ray's stack: a power of two, so that an index is brought in bounds without a branch. A ray
/// that needs more is traversed on its own.
pub(super) const STACK: usize = 16;

/// Link of a ray that has to take another child: its topmost waiting node lies behind its hit. Also the link of an unused
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

/// Length of a queue: twice the number of slots, so that an id may be written behind the last.
const QUEUE: usize = 2 * SLOTS;

/// Numbers of slots.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Queue {
    ids: [u8; QUEUE],
    pub count: u32,
}

impl Queue {
    pub const EMPTY: Self = Self { ids: [0; QUEUE], count: 0 };

    /// The queue of all slots.
    pub fn all() -> Self {
        Self { ids: core::array::from_fn(|id| id as u8), count: SLOTS as u32 }
    }

    /// Writes an id, without counting it.
    // Forced: what calls it is compiled for the instructions of its lanes.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn put(&mut self, at: u32, id: usize) {
        self.ids[at as usize % QUEUE] = id as u8;
    }

    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn ids(&self) -> impl Iterator<Item = usize> {
        let ids = self.ids.get(..self.count as usize).unwrap_or(&[]);
        ids.iter().map(|&id| id as usize % SLOTS)
    }

    /// Empties the queue, and returns what it was.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn take(&mut self) -> Self {
        let taken = *self;
        self.count = 0;
        taken
    }
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
    /// Rays that enter a node.
    pub(super) nodes: Queue,
    /// Rays that do anything else, not sorted yet.
    pub(super) others: Queue,
    /// Rays that enter a leaf.
    pub(super) leaves: Queue,
    /// Rays that take their next child.
    pub(super) stale: Queue,
    /// Rays whose walks are over.
    pub(super) done: Queue,
    unused: [u32; 11],
}

/// Bytes of which any slice holds a [`Room`], wherever it begins.
pub(crate) const SCRATCH: usize = size_of::<Room>() + ALIGNMENT - 1;

impl Room {
    /// Tells whether any ray waits for a pass.
    #[inline]
    pub(super) fn is_busy(&self) -> bool {
        let Self { nodes, others, leaves, stale, done, .. } = self;
        nodes.count + others.count + leaves.count + stale.count + done.count > 0
    }

    /// Finds room in a caller's bytes; `None` if there are too few.
    pub fn of(scratch: &mut [u8]) -> Option<&mut Self> {
        let skipped = scratch.as_ptr().addr().wrapping_neg() % ALIGNMENT;
        let bytes = scratch.get_mut(skipped..)?.get_mut(..size_of::<Self>())?;
        bytemuck::try_from_bytes_mut(bytes).ok()
    }
}
