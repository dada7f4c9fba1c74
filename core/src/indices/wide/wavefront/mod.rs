//! Wavefront: many rays of a batch in flight, each step done for all of them in a pass of its own.
//!
//! ```text
//! Next::Node       enter_nodes, or for any hit test_boxes and take_children  --> any queue
//! Next::Leaf       test_leaves and judge, take_children                      --> any queue
//! Next::TakeChild  take_children                                             --> any queue
//! Next::Answer     renew                                                     --> Next::Node, by the batch's next ray
//! ```
//! | pass | for each ray that it is about | file |
//! |---|---|---|
//! | `enter_nodes` | at a node: tests its eight boxes, takes the nearest child, puts the node on the ray's stack if others are left | `nodes` |
//! | `test_boxes` | at a node: tests its eight boxes, puts it on the ray's stack | `nodes` |
//! | `take_children` | takes the nearest child left of the topmost node on the stack, and prefetches it | `nodes` |
//! | `renew` | at its end: hands on its answer, and begins the next ray in its slot | `begin` |
//! | `test_leaves` | at a leaf: prefetches what it names, then tests its eight triangles in `f32` | `leaves` |
//! | `judge` | with a triangle left: decides four such pairs at once in `f64` | `leaves` |
//!
//! - A ray waits in one of four queues, by what it does [next](room::Next).
//! - Leaves are tested once eight rays are at leaves, or fewer than eight at nodes.
//! - A pass has no branch that is often mispredicted: even a ray's next queue is calculated. So the processor works on as
//!   many rays at once as its buffers hold.
//! - A ray's order of nodes is that of a single ray. What differs is when a hit shortens it, which changes no answer.
//! - Rays that lanes cannot take are answered when their turn comes to begin. A ray whose stack is too short is
//!   traversed on its own in the end.
//! - An any-hit ray is done at the leaf at which a triangle is surely hit. Only triangles that are in doubt are judged.
//! - A hit drops what lies behind it from the ray's stack, up to two entries. A closest-hit ray that finds another such
//!   entry later, or meets no child of a node, takes another child in the next round.
//! - `judge` leaves to the kernel whatever its bounds cannot decide, so hits are the same bits.
//!
//! # Memory
//! A [`Room`] of the caller. Its length does not depend on the batch.
//!
//! # Measured
//! Closest hits, Zen 4, 100,000 photon rays, speed over the first wavefront, of which the rest is:
//!
//! | | figure 3 | 4(b) | city | mesh | city, 1M |
//! |---|---|---|---|---|---|
//! | wide BVH, AVX-512 | 1.09 | 1.11 | 1.11 | 1.04 | 1.10 |
//! | wide BVH, AVX2 | 1.08 | 1.07 | 1.09 | 1.08 | 1.14 |
//! | lean BVH, AVX2 | 1.10 | 1.11 | 1.13 | 1.04 to 1.10 | 1.08 |
//! | compact BVH, AVX2 | 1.01 | 1.04 | 1.02 | 0.98 | 1.09 |
//!
//! - A child taken in the pass that tests the boxes, the next ray's boxes before it, queues that need no sorting, and no
//!   line too many prefetched of a node: 4 to 8%, on a million 11%. 32 rays in flight instead of 64: 2 to 5% more, and
//!   half the memory.
//!
//! The first wavefront, Zen 5, 100,000 photon rays, processor time, medians of pairs in turns with Embree's; "turns" are
//! four rays in turn:
//!
//! | | 4(b) | city | mesh | city, 1M |
//! |---|---|---|---|---|
//! | AVX2, speed over turns | 1.31 | 1.32 | 1.31 | 2.13 |
//! | AVX2, occluded | 1.32 | 1.31 | 1.26 | 2.08 |
//! | AVX-512, speed over turns | 1.33 | 1.56 | 1.44 | 2.17 |
//! | AVX-512, occluded | 1.36 | 1.42 | 1.41 | 2.01 |
//! | AVX2, compact BVH, speed over turns | 1.29 | 1.24 | 1.33 | 2.2 |
//! | AVX2, lean BVH, speed over turns | 1.34 | 1.39 | 1.36 | 2.66 |
//! | instructions a ray, AVX2 | 887 (turns 680) | 1164 (878) | 951 (698) | |
//!
//! - The wavefront has more instructions, at 3.9 a cycle instead of 2.7: of simulated branch mispredictions it has 1.5 a
//!   ray instead of 3.5.
//! - A prefetch of all five lines of a leaf, instead of the four of a node: 4 to 10%, on a million 20%. Of compact nodes
//!   and leaves: 17%, on a million 1.7 to 2.4 times.
//! - A prefetch of the triangles that the leaves of a lean BVH name, before any is tested: 1.25 to 1.4 times, on a million
//!   2.2 times.
//! - Links beside the keys on the stack, so that a child is taken without its node: 7% of the instructions.
//! - A ray prepared by [`prepare`](crate::simd::prepare): 4% of the instructions.
//! - A choice of the stale link without a branch, and a hit that is stored by field: 4%.
//! - Occluded: no branch on a sure hit, no candidate copied where all are sure, no way through the queues for a ray
//!   that is done, no comparison with its last `t`: 6 to 15%.
//! - Two stale entries dropped at a hit: 10% in figure 3, 5% in a city, elsewhere within the noise.
//!
//! # What lost
//! - One pass for boxes and children of any-hit rays too: 3 to 6% slower, because more of them meet no child, and those
//!   wait for another round. With the keys passed through the stack, so that none waits: 9 to 12% slower.
//! - The edge of a leaf written beside its link when the child is taken: 8 to 15% slower for any-hit rays, because it is
//!   in the node, which nothing else reads when a child is taken from the stack.
//! - A ray's id written to all four queues, and counted by one of them: 8% slower.
//! - The edges of all leaves looked up before the first is tested: 3 to 4% slower.
//! - `judge` compiled for AVX-512: within the noise.
//! - Candidates by lane and link, and their triangles gathered when they are judged: the compiler spills the 36 coordinates,
//!   twice the instructions of copying each triangle into its lane of a [`Quad`](crate::simd::Quad).
//! - The least key of each level beside the ray, from which one comparison finds the topmost entry that is not stale:
//!   as fast as dropping two entries in figure 3, 1 to 4% slower elsewhere.
//! - Dropping three stale entries at a hit: 1 to 3% slower than two; one: 3% slower in figure 3 and a city.
//! - A prefetch of four lines for nodes, and of five for leaves only, by `take_children`: any-hit rays 2 to 5% slower.
//!
//! # Source
//! The passes follow the wavefronts of path tracers on graphics processors: S. Laine, T. Karras, T. Aila, *Megakernels
//! Considered Harmful*, 2013.

mod begin;
mod leaves;
mod nodes;
mod room;

pub(crate) use room::{MOST, Room, SCRATCH};

use begin::Batch;
use room::{Next, StackEntry, Taken};

/// Number of rays at leaves, from which on leaves are tested; and of rays at nodes, below which leaves are tested.
///
/// # What lost
/// 6 and 12: 0 to 4% slower.
const ENOUGH: usize = 8;

/// Compiles the passes for some instructions, each as a function of its own, and the rounds.
macro_rules! compiled_for {
    ($module:ident, $features:literal) => {
        pub(crate) mod $module {
            use super::*;
            use crate::indices::wide::traversal;
            use crate::indices::wide::tree::InLanes;
            use crate::query::{BatchQuery, Hit};
            use crate::simd::Avx2;

            #[inline(never)]
            #[target_feature(enable = $features)]
            fn test_boxes<T: InLanes<Avx2>>(tree: T, room: &mut Room) {
                nodes::test_boxes(tree, room);
            }

            #[inline(never)]
            #[target_feature(enable = $features)]
            fn enter_nodes<T: InLanes<Avx2>>(tree: T, room: &mut Room) {
                nodes::enter_nodes(tree, room);
            }

            #[inline(never)]
            #[target_feature(enable = $features)]
            fn take_children<T: InLanes<Avx2>, Q: BatchQuery>(
                tree: T,
                room: &mut Room,
                queue: Next,
            ) {
                nodes::take_children::<T, Q>(tree, room, queue);
            }

            #[inline(never)]
            #[target_feature(enable = $features)]
            fn test_leaves<T: InLanes<Avx2>, Q: BatchQuery, S: Fn(usize) -> Option<Q>, F>(
                tree: T,
                room: &mut Room,
                batch: &Batch<S, F>,
            ) {
                leaves::test_leaves(tree, room, batch);
            }

            /// Traverses the tree for one query, whose stack was too short.
            #[cold]
            #[inline(never)]
            #[target_feature(enable = $features)]
            fn alone<T: InLanes<Avx2>, Q: BatchQuery>(tree: T, query: &mut Q) {
                traversal::traverse::<Avx2, T, Q>(tree, query);
            }

            #[inline(never)]
            #[target_feature(enable = $features)]
            fn renew<
                T: InLanes<Avx2>,
                Q: BatchQuery,
                S: Fn(usize) -> Option<Q>,
                F: FnMut(usize, Hit),
            >(
                tree: T,
                room: &mut Room,
                batch: &mut Batch<S, F>,
            ) {
                let rays = room.queues.take(Next::Answer);
                begin::answer(&room.slots, &rays, batch, |query| alone(tree, query));
                begin::begin(tree, room, &rays, batch);
            }

            /// Traverses a tree for each of `count` queries.
            #[inline(never)]
            #[target_feature(enable = $features)]
            pub(crate) fn traverse_each<T: InLanes<Avx2>, Q: BatchQuery>(
                tree: T,
                room: &mut Room,
                count: usize,
                start: impl Fn(usize) -> Option<Q>,
                finish: impl FnMut(usize, Hit),
            ) {
                let mut batch = Batch { next: 0, count, start, finish };
                room.queues.clear();
                for slot in &mut room.slots {
                    slot.stack[0] = StackEntry::BOTTOM;
                }
                begin::begin(tree, room, &Taken::all(), &mut batch);
                while room.queues.any() {
                    if Q::ANY {
                        test_boxes(tree, room);
                        take_children::<T, Q>(tree, room, Next::Node);
                    } else {
                        enter_nodes(tree, room);
                    }
                    renew(tree, room, &mut batch);
                    if room.queues.count(Next::Leaf) >= ENOUGH
                        || room.queues.count(Next::Node) < ENOUGH
                    {
                        test_leaves(tree, room, &batch);
                        take_children::<T, Q>(tree, room, Next::Leaf);
                        take_children::<T, Q>(tree, room, Next::TakeChild);
                    }
                }
            }
        }
    };
}

compiled_for!(avx2, "avx2");
compiled_for!(avx512, "avx512f,avx512vl,avx512dq,avx512bw");
