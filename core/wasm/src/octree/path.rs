//! The way of a ray through the cluster tree and the octrees.

use arboleda::custom::{RaySpan, Span};
use arboleda::{Aabb, Hit, Ray, Triangle, TriangleId, intersect};
use arboleda_ffi::parts::{Caller, Failure, Input, Output, apart, borrowed, reported};
use arboleda_ffi::{arb_error, arb_hit, arb_index, arb_ray, arb_status};
use arrayvec::ArrayVec;

use super::{Cell, Inner, LEAF, Node, Octree, Octrees, WAITING};
use crate::records::{Records, bits_of};

/// Words of a step: what, id, level, first test, tests, lower corner, upper corner.
const STEP_WORDS: usize = 11;
/// Nodes of the cluster tree that wait while one is visited: one on each level, and two of the last.
const JOINS_WAITING: usize = 34;

/// What a step enters.
#[derive(Clone, Copy)]
enum What {
    Join = 0,
    Cluster = 1,
    Inner = 2,
    Leaf = 3,
}

/// Finds the closest hit of a ray as `arb_closest` does, and writes which nodes it enters and which triangles it tests,
/// in their order.
///
/// - `steps`: room for `step_capacity` records of 11 words:
///   0. what is entered: 0 a join of the cluster tree, 1 a cluster, 2 a cell that is divided, 3 a leaf;
///   1. its id: in the cluster tree for 0 and 1, the offset in the words of the cluster for 2 and 3;
///   2. its level: below the root of the cluster tree for 0 and 1, below the root of the octree for 2 and 3;
///   3. the number of triangles that were tested before;
///   4. the number of triangles that are tested in it;
///   5. its box, six words, the lower corner first.
/// - `tests`: room for `test_capacity` ids of triangles.
/// - `counts`: receives the number of steps, then that of tests, also if there are more than found room.
/// - `hit`: receives the hit.
///
/// The number of steps is `nodes_visited` of `arb_closest_counted`, that of tests is `triangle_tests`.
///
/// Errors: those of `arb_closest`, `ARB_OVERLAP`; `ARB_INVALID_OPTION` if the index is neither an octree nor an
/// octree-R, alone or in a hierarchy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_path(
    index: *const arb_index,
    ray: *const arb_ray,
    steps: *mut u32,
    step_capacity: usize,
    tests: *mut u32,
    test_capacity: usize,
    counts: *mut usize,
    hit: *mut arb_hit,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let index = caller.index(index)?;
        let octrees = Octrees::of(index)?;
        let ray = one(caller, ray)?;
        let steps = Output::check(steps, step_capacity.saturating_mul(STEP_WORDS), "steps")?;
        let tests = Output::check(tests, test_capacity, "tests")?;
        let to_counts = Output::check(counts.cast::<[usize; 2]>(), 1, "counts")?;
        let to_hit = Output::one(hit, "hit")?;
        let outputs = [steps.region(), tests.region(), to_counts.region(), to_hit.region()];
        apart(&outputs, &borrowed(index))?;
        let root = octrees.sections.nodes().last().map(|node| node.bounds);
        let mut walk = Walk {
            octrees,
            ray: &ray,
            spans: RaySpan::new(&ray, &root.unwrap_or(Aabb::EMPTY)),
            steps: Records::new(caller.borrow_mut(steps)),
            tests: Records::new(caller.borrow_mut(tests)),
            hit: Hit { t: ray.t_max(), ..Hit::NONE },
        };
        walk.run();
        let found = if walk.hit.is_none() { Hit::NONE } else { walk.hit };
        let Hit { triangle: TriangleId(triangle), t, u, v } = found;
        caller.write(to_counts, [walk.steps.count(), walk.tests.count()]);
        caller.write(to_hit, arb_hit { triangle, t, u, v });
        Ok(())
    })
}

/// Reads and converts a ray.
fn one(caller: Caller, ray: *const arb_ray) -> Result<Ray, Failure> {
    let rays = caller.borrow(Input::check(ray, 1, "ray")?);
    let invalid = |error| Failure::Ray { error, at: 0 };
    match rays.first() {
        Some(ray) => ray.ray().map_err(invalid),
        None => Err(invalid(arboleda::RayError::ZeroDirection)),
    }
}

/// Closest-hit query that keeps a record of what it does.
struct Walk<'a> {
    octrees: Octrees<'a>,
    ray: &'a Ray,
    spans: RaySpan,
    steps: Records<'a, STEP_WORDS>,
    tests: Records<'a, 1>,
    hit: Hit,
}

impl Walk<'_> {
    /// Traverses the cluster tree, of each join the nearer node first; of two at the same distance, the left.
    fn run(&mut self) {
        let mut waiting = ArrayVec::<(u32, Span, u32), JOINS_WAITING>::new();
        let count = self.octrees.sections.nodes().len() as u32;
        let mut next = count
            .checked_sub(1)
            .and_then(|root| self.clipped(root, self.spans.whole()))
            .map(|(id, span)| (id, span, 0));
        while let Some((id, span, level)) = next {
            if self.matters(span) {
                for (child, span) in self.enter(id, span, level).into_iter().flatten() {
                    let pushed = waiting.try_push((child, span, level + 1)).is_ok();
                    debug_assert!(pushed, "opening bounds the depth");
                }
            }
            next = waiting.pop();
        }
    }

    /// Tells whether a part of the ray may hold a hit that is closer.
    fn matters(&self, span: Span) -> bool {
        span.from <= self.spans.last(self.hit.t)
    }

    /// The part of the ray in a node of the cluster tree; `None` if there is none.
    fn clipped(&self, id: u32, span: Span) -> Option<(u32, Span)> {
        let span = self.spans.clip(&self.octrees.node(id)?.bounds, span);
        (!span.is_empty()).then_some((id, span))
    }

    /// Enters a node of the cluster tree. Returns the nodes to be entered after it, the nearer last.
    fn enter(&mut self, id: u32, span: Span, level: u32) -> [Option<(u32, Span)>; 2] {
        let Some(node) = self.octrees.node(id) else { return [None; 2] };
        if id < self.octrees.sections.cluster_count() {
            self.step(What::Cluster, id, level, &[], &Cell::of(node));
            self.octree(&self.octrees.octree(node), Cell::of(node), span);
            return [None; 2];
        }
        self.step(What::Join, id, level, &[], &Cell::of(node));
        match node.links.map(|child| self.clipped(child, span)) {
            [Some(left), Some(right)] if right.1.from < left.1.from => [Some(left), Some(right)],
            [left, right] => [right, left],
        }
    }

    /// Traverses the octree of a cluster, front to back.
    fn octree(&mut self, octree: &Octree<'_>, root: Cell, span: Span) {
        let signs = self.spans.sign_mask() as u32;
        let mut waiting = ArrayVec::<(u32, Cell, Span, u32), WAITING>::new();
        // The query has entered the cluster, so it enters the root in any case.
        let mut next = Some((octree.root(), root, span, 0));
        while let Some((link, cell, span, level)) = next {
            match octree.node(link, &cell) {
                Node::Leaf(ids) => {
                    self.step(What::Leaf, link & !LEAF, level, ids, &cell);
                }
                Node::Inner(inner) => {
                    self.step(What::Inner, link, level, &[], &cell);
                    // Octants with flipped bits are in the order in which the ray may meet them.
                    for flipped in (0..8).rev() {
                        let (octant, span) = (flipped ^ signs, self.part(&inner, flipped, span));
                        if inner.mask >> octant & 1 == 1 && !span.is_empty() {
                            let child = octree.child(&inner, octant);
                            let cell = cell.child(&inner.planes, octant);
                            let pushed = waiting.try_push((child, cell, span, level + 1)).is_ok();
                            debug_assert!(pushed, "opening bounds the depth");
                        }
                    }
                }
            }
            next = loop {
                match waiting.pop() {
                    Some(child) if !self.matters(child.2) => {}
                    child => break child,
                }
            };
        }
    }

    /// The part of the ray in an octant: in the half of an axis that is entered first, up to the latest crossing of the
    /// plane; in the other half, from the earliest on.
    fn part(&self, inner: &Inner, flipped: u32, span: Span) -> Span {
        let mut span = span;
        for (axis, &plane) in inner.planes.iter().enumerate() {
            let crossing = self.spans.crossing(axis, plane);
            span = if flipped >> axis & 1 == 1 {
                span.after(crossing.earliest)
            } else {
                span.until(crossing.latest)
            };
        }
        span
    }

    /// Records that a node is entered, and tests its triangles.
    fn step(&mut self, what: What, id: u32, level: u32, ids: &[u32], cell: &Cell) {
        let (lo, hi) = cell.corners();
        let [a, b, c, d, e, f] = bits_of(lo, hi);
        let (first, count) = (self.tests.count() as u32, ids.len() as u32);
        self.steps.push([what as u32, id, level, first, count, a, b, c, d, e, f]);
        for &id in ids {
            self.tests.push([id]);
            if let Some(triangle) = self.octrees.sections.triangles().get(id) {
                self.test(TriangleId(id), &triangle);
            }
        }
    }

    /// Tests a triangle: of hits at the same `t`, that of the lowest id counts.
    fn test(&mut self, triangle: TriangleId, corners: &Triangle) {
        let Some(met) = intersect(self.ray, corners) else { return };
        if met.t < self.hit.t || (met.t == self.hit.t && triangle < self.hit.triangle) {
            self.hit = Hit { triangle, t: met.t, u: met.u, v: met.v };
        }
    }
}
