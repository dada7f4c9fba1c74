//! The three queries: closest hit, any hit (occlusion), all hits.
//!
//! An index traverses its nodes and shows every triangle that it comes across to a [`Query`]. The query tests the
//! triangle exactly, and says up to which `t` hits still matter. The answer does not depend on which further triangles
//! are shown, nor on their order: of hits at the same `t`, the one with the lowest id wins.

mod batch;
mod counters;

use core::ops::ControlFlow;

use bytemuck::{Pod, Zeroable};

pub use batch::BatchQuery;
pub use counters::{Count, Counters};

use crate::geometry::kernel::{self, Intersection, Meeting, Verdict, Volumes, meet, meet_exactly};
use crate::geometry::{Candidates, Ray, Triangle};
use crate::sealed::Sealed;

/// Id of a triangle: its index in the scene.
///
/// `u32` rather than `usize`: leaves take half the memory, and an index has the same bytes on every target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct TriangleId(pub u32);

/// Hit of a ray: the triangle, the parameter along the ray, and the barycentric weights.
///
/// Layout: 16 bytes, aligned to 4, in the order of the fields.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Hit {
    /// The triangle. Of several hit at the same `t`, the one with the lowest id.
    pub triangle: TriangleId,
    /// The `f32` nearest to the exact parameter along the ray, in lengths of its direction; finite.
    pub t: f32,
    /// The weight of corner `b`, 0 to 1; see [`crate::Intersection`].
    pub u: f32,
    /// The weight of corner `c`, 0 to 1.
    pub v: f32,
}

impl Hit {
    /// Placeholder for a ray that hits nothing, and for filling buffers. Names no triangle.
    pub const NONE: Self =
        Self { triangle: TriangleId(u32::MAX), t: f32::INFINITY, u: 0.0, v: 0.0 };

    /// Tells whether this is [`Hit::NONE`].
    pub fn is_none(&self) -> bool {
        self.triangle == Self::NONE.triangle
    }
}

/// Hits of a ray, as many as the caller's buffer holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllHits<'h> {
    /// The hits in the order of `(t, triangle)`, closest first.
    pub hits: &'h [Hit],
    /// True if the buffer was too short: the hits left out come after the last one in it.
    pub truncated: bool,
}

/// Query that is answered during a traversal.
///
/// An index [enters](Query::enter) nodes and [tests](Query::test) triangles, until a call returns `Break`.
pub trait Query: Sealed {
    /// True for an any-hit query. Only these receive [`Query::surely_hit`].
    const ANY: bool = false;

    /// Counts a node that the traversal enters. The leaf of the cluster tree is counted already; an index without nodes
    /// of its own counts nothing.
    fn enter(&mut self);
    /// The ray of the query.
    fn ray(&self) -> &Ray;
    /// The `t` beyond which hits no longer matter; see [`RaySpan::last`](crate::custom::RaySpan::last). It never grows
    /// during a traversal.
    fn last_t(&self) -> f32;
    /// Counts `count` triangles as tested.
    fn count_tests(&mut self, count: u32);
    /// Receives that some triangle is surely hit. Returns `Break` if the answer is then known.
    #[inline]
    fn surely_hit(&mut self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Accepts the exact hit of a triangle, within the ray's interval. Returns `Break` once the answer is known.
    /// Accepting a hit twice does no harm.
    fn accept(&mut self, id: TriangleId, hit: Intersection) -> ControlFlow<()>;

    /// Decides exactly whether a triangle is hit, from the verdict of a filter. Returns `Break` once the answer is
    /// known.
    fn judge(&mut self, id: TriangleId, triangle: &Triangle, verdict: Verdict) -> ControlFlow<()>;

    /// Decides exactly whether a triangle is hit, without a filter's verdict; see [`Query::judge`].
    #[inline]
    fn decide(&mut self, id: TriangleId, triangle: &Triangle) -> ControlFlow<()> {
        self.judge(id, triangle, Verdict::InDoubt)
    }

    /// Tests a triangle: counts it, and decides exactly unless the `f32` filter rejects it.
    #[inline]
    fn test(&mut self, id: TriangleId, triangle: &Triangle) -> ControlFlow<()> {
        self.count_tests(1);
        self.test_counted(id, triangle)
    }

    /// Tests a triangle that is counted already.
    #[inline]
    fn test_counted(&mut self, id: TriangleId, triangle: &Triangle) -> ControlFlow<()> {
        if kernel::surely_missed(self.ray(), triangle) {
            return ControlFlow::Continue(());
        }
        self.decide(id, triangle)
    }
}

impl Candidates {
    /// Tells the query if a triangle is surely hit. Returns the triangles that it has to judge.
    // Forced: the traversal of the wide BVH is compiled for the instructions of its lanes, with all that it calls.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub(crate) fn of<Q: Query>(self, query: &mut Q) -> ControlFlow<(), u32> {
        if self.sure != 0 {
            query.surely_hit()?;
        }
        ControlFlow::Continue(self.any)
    }
}

/// Decides exactly, for a ray and a triangle that a filter has left in doubt, whether there is a hit up to `t_max`.
#[inline]
fn decided<'p>(
    ray: &'p Ray,
    triangle: &'p Triangle,
    verdict: &Verdict,
    t_max: f32,
) -> Option<Meeting<'p>> {
    match verdict {
        Verdict::Doubtful(volumes) => meet_exactly(ray, triangle, volumes, ray.t_min(), t_max),
        _ => meet(ray, triangle, ray.t_min(), t_max),
    }
}

/// Closest-hit query.
pub(crate) struct Closest<'r, C> {
    ray: &'r Ray,
    count: C,
    hit: Hit,
}

impl<'r, C: Count> Closest<'r, C> {
    #[inline]
    pub fn new(ray: &'r Ray, count: C) -> Self {
        Self { ray, count, hit: Hit { t: ray.t_max(), ..Hit::NONE } }
    }

    #[inline]
    pub fn finish(&self) -> Option<Hit> {
        (!self.hit.is_none()).then_some(self.hit)
    }

    /// The last `t` at which a hit of a triangle still counts. A triangle with a higher id has to be hit strictly
    /// before the hit found so far.
    #[inline]
    fn last_t_of(&self, id: TriangleId) -> f32 {
        if id < self.hit.triangle { self.hit.t } else { self.hit.t.next_down() }
    }

    // This function and the next are separate, so that a traversal that rarely calls them keeps its registers.
    #[cold]
    #[inline(never)]
    fn decide_apart(&mut self, id: TriangleId, triangle: &Triangle) {
        let (ControlFlow::Continue(()) | ControlFlow::Break(())) = self.decide(id, triangle);
    }

    #[cold]
    #[inline(never)]
    fn decide_exactly(&mut self, id: TriangleId, triangle: &Triangle, volumes: &Volumes) {
        // Around a corner, most triangles are hit at the last `t`, and half of them or more have a higher id. Their
        // `t_max` is the number before it, so they are rejected without exact arithmetic.
        let (ray, t_max) = (self.ray, self.last_t_of(id));
        if let Some(meeting) = meet_exactly(ray, triangle, volumes, ray.t_min(), t_max) {
            self.hit = hit_of(id, meeting.intersection());
        }
    }
}

fn hit_of(triangle: TriangleId, Intersection { t, u, v }: Intersection) -> Hit {
    Hit { triangle, t, u, v }
}

impl<C> Sealed for Closest<'_, C> {}

impl<C: Count> Query for Closest<'_, C> {
    #[inline]
    fn enter(&mut self) {
        self.count.node();
    }

    #[inline]
    fn ray(&self) -> &Ray {
        self.ray
    }

    #[inline]
    fn last_t(&self) -> f32 {
        self.hit.t
    }

    #[inline]
    fn count_tests(&mut self, count: u32) {
        self.count.tests(count);
    }

    #[inline]
    fn accept(&mut self, id: TriangleId, hit: Intersection) -> ControlFlow<()> {
        if hit.t < self.hit.t || id < self.hit.triangle {
            self.hit = hit_of(id, hit);
        }
        ControlFlow::Continue(())
    }

    #[inline]
    fn judge(&mut self, id: TriangleId, triangle: &Triangle, verdict: Verdict) -> ControlFlow<()> {
        match verdict {
            Verdict::Missed => {}
            Verdict::Hit(hit) => return self.accept(id, hit),
            Verdict::InDoubt => self.decide_apart(id, triangle),
            Verdict::Doubtful(volumes) => self.decide_exactly(id, triangle, &volumes),
        }
        ControlFlow::Continue(())
    }

    #[inline]
    fn decide(&mut self, id: TriangleId, triangle: &Triangle) -> ControlFlow<()> {
        let (ray, t_max) = (self.ray, self.last_t_of(id));
        if let Some(meeting) = meet(ray, triangle, ray.t_min(), t_max) {
            self.hit = hit_of(id, meeting.intersection());
        }
        ControlFlow::Continue(())
    }
}

/// Any-hit query: it ends at the first triangle that is hit.
pub(crate) struct Occluded<'r, C> {
    ray: &'r Ray,
    count: C,
    pub found: bool,
}

impl<'r, C: Count> Occluded<'r, C> {
    #[inline]
    pub fn new(ray: &'r Ray, count: C) -> Self {
        Self { ray, count, found: false }
    }
}

impl<C> Sealed for Occluded<'_, C> {}

impl<C: Count> Query for Occluded<'_, C> {
    const ANY: bool = true;

    #[inline]
    fn enter(&mut self) {
        self.count.node();
    }

    #[inline]
    fn ray(&self) -> &Ray {
        self.ray
    }

    #[inline]
    fn last_t(&self) -> f32 {
        self.ray.t_max()
    }

    #[inline]
    fn count_tests(&mut self, count: u32) {
        self.count.tests(count);
    }

    #[inline]
    fn surely_hit(&mut self) -> ControlFlow<()> {
        self.found = true;
        ControlFlow::Break(())
    }

    #[inline]
    fn accept(&mut self, _: TriangleId, _: Intersection) -> ControlFlow<()> {
        self.found = true;
        ControlFlow::Break(())
    }

    #[inline]
    fn judge(&mut self, _: TriangleId, triangle: &Triangle, verdict: Verdict) -> ControlFlow<()> {
        let ray = self.ray;
        self.found = match verdict {
            Verdict::Missed => false,
            Verdict::Hit(_) => true,
            _ => decided(ray, triangle, &verdict, ray.t_max()).is_some(),
        };
        if self.found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// All-hits query. Keeps the closest hits if the buffer is too short.
pub(crate) struct All<'r, 'h, C> {
    ray: &'r Ray,
    count: C,
    buffer: &'h mut [Hit],
    filled: usize,
    truncated: bool,
    t_max: f32,
}

impl<'r, 'h, C: Count> All<'r, 'h, C> {
    pub fn new(ray: &'r Ray, buffer: &'h mut [Hit], count: C) -> Self {
        Self { ray, count, buffer, filled: 0, truncated: false, t_max: ray.t_max() }
    }

    pub fn finish(self) -> AllHits<'h> {
        let hits: &'h [Hit] = self.buffer;
        AllHits { hits: hits.get(..self.filled).unwrap_or(&[]), truncated: self.truncated }
    }

    /// Inserts a hit into the buffer, which is sorted by `(t, id)`. A triangle that is stored in several cells comes
    /// several times, and is kept once.
    fn insert(&mut self, mut carried: Hit) {
        let key = (carried.t, carried.triangle);
        let mut slots = self.buffer.iter_mut().take(self.filled).peekable();
        while slots.next_if(|hit| (hit.t, hit.triangle) < key).is_some() {}
        if slots.peek().is_some_and(|hit| hit.triangle == carried.triangle) {
            return;
        }
        for slot in slots {
            core::mem::swap(slot, &mut carried);
        }
        if let Some(slot) = self.buffer.get_mut(self.filled) {
            *slot = carried;
            self.filled += 1;
        } else {
            // The buffer was full: only now may the traversal end earlier. Before, it had to find out `truncated`.
            self.truncated = true;
            self.t_max = self.buffer.last().map_or(self.t_max, |hit| hit.t);
        }
    }
}

impl<C> Sealed for All<'_, '_, C> {}

impl<C: Count> Query for All<'_, '_, C> {
    #[inline]
    fn enter(&mut self) {
        self.count.node();
    }

    #[inline]
    fn ray(&self) -> &Ray {
        self.ray
    }

    #[inline]
    fn last_t(&self) -> f32 {
        self.t_max
    }

    #[inline]
    fn count_tests(&mut self, count: u32) {
        self.count.tests(count);
    }

    #[inline]
    fn accept(&mut self, id: TriangleId, hit: Intersection) -> ControlFlow<()> {
        self.insert(hit_of(id, hit));
        if self.truncated && self.buffer.is_empty() {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    #[inline]
    fn judge(&mut self, id: TriangleId, triangle: &Triangle, verdict: Verdict) -> ControlFlow<()> {
        let hit = match verdict {
            Verdict::Missed => None,
            Verdict::Hit(hit) => Some(hit),
            _ => decided(self.ray, triangle, &verdict, self.t_max)
                .map(|meeting| meeting.intersection()),
        };
        hit.map_or(ControlFlow::Continue(()), |hit| self.accept(id, hit))
    }
}
