//! The three questions: which hit is closest, is there any, which are there.
//!
//! An index walks its nodes and shows each triangle it comes across to a [`Query`]; the query tests
//! it exactly and says how far along the ray anything still matters. Which triangles are shown, and
//! in which order, cannot change the answer: ties go to the lowest id.

use core::ops::ControlFlow;

use bytemuck::{Pod, Zeroable};

use crate::geometry::kernel::{Intersection, Meeting, Verdict, meet, meet_exactly};
use crate::geometry::{Ray, Triangle, kernel, last_parameter};

/// The place of a triangle in the scene it was built from.
///
/// `u32` rather than `usize`: half the memory in leaves, and the same image on every target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct TriangleId(pub u32);

/// Where a ray meets a triangle.
///
/// Layout: 16 bytes, aligned to 4, in the order of the fields.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// The triangle; of several at the same `t`, the lowest.
    pub triangle: TriangleId,
    /// The `f32` nearest to the exact parameter along the ray; finite.
    pub t: f32,
    /// The weight of corner `b`; see [`crate::geometry::kernel::Intersection`].
    pub u: f32,
    /// The weight of corner `c`.
    pub v: f32,
}

impl Hit {
    /// Nothing was hit; also to fill buffers with. Names no triangle.
    pub const NONE: Self =
        Self { triangle: TriangleId(u32::MAX), t: f32::INFINITY, u: 0.0, v: 0.0 };

    /// Tells whether nothing was hit.
    pub fn is_none(&self) -> bool {
        self.triangle == Self::NONE.triangle
    }
}

/// All hits of a ray, as far as the caller's buffer holds them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllHits<'h> {
    /// The hits by `(t, triangle)`, closest first.
    pub hits: &'h [Hit],
    /// Whether there were more, all of them behind the last one here.
    pub truncated: bool,
}

/// What answering took. The same for a given index on every machine.
///
/// Layout: 16 bytes, in the order of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Counters {
    /// Nodes whose box the ray entered, of the cluster tree and of the local indices.
    pub nodes_visited: u64,
    /// Exact tests between the ray and a triangle.
    pub triangle_tests: u64,
}

impl core::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.nodes_visited += other.nodes_visited;
        self.triangle_tests += other.triangle_tests;
    }
}

/// Counts, or does not: `()` compiles to nothing.
pub trait Count {
    /// A node was entered.
    fn node(&mut self);
    /// So many triangles were tested.
    fn tests(&mut self, count: u32);
}

impl Count for () {
    #[inline]
    fn node(&mut self) {}
    #[inline]
    fn tests(&mut self, _: u32) {}
}

impl Count for &mut Counters {
    #[inline]
    fn node(&mut self) {
        self.nodes_visited += 1;
    }
    #[inline]
    fn tests(&mut self, count: u32) {
        self.triangle_tests += u64::from(count);
    }
}

/// What an index asks while it walks.
pub trait Query: sealed::Sealed {
    /// Whether any hit is enough: then it is told of one that is sure.
    const ANY: bool = false;

    /// Says that a node is entered.
    fn enter(&mut self);
    /// The ray that is asked about.
    fn ray(&self) -> &Ray;
    /// The `t` beyond which nothing matters any more. Never grows.
    fn last_t(&self) -> f32;
    /// The parameter that may still be rounded to [`Query::last_t`]; a node is skipped only if it begins
    /// beyond.
    #[inline]
    fn last(&self) -> f64 {
        last_parameter(self.last_t())
    }
    /// Says that so many triangles are tested.
    fn count_tests(&mut self, count: u32);
    /// Says that some triangle is surely hit; `Break` if that is all there is to know.
    #[inline]
    fn surely_hit(&mut self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    /// Decides exactly whether a triangle is hit, where that is still in doubt; `Break` once the answer is
    /// known. Asking about one twice does no harm.
    fn judge(&mut self, id: TriangleId, triangle: &Triangle, verdict: Verdict) -> ControlFlow<()>;

    /// As [`Query::judge`], where nobody knows anything yet.
    #[inline]
    fn decide(&mut self, id: TriangleId, triangle: &Triangle) -> ControlFlow<()> {
        self.judge(id, triangle, Verdict::InDoubt)
    }

    /// Counts a test, and decides it where the filter does not.
    #[inline]
    fn test(&mut self, id: TriangleId, triangle: &Triangle) -> ControlFlow<()> {
        self.count_tests(1);
        if kernel::surely_missed(self.ray(), triangle) {
            return ControlFlow::Continue(());
        }
        self.decide(id, triangle)
    }
}

/// Only the queries of this crate: an index may rely on what they do.
pub(crate) mod sealed {
    pub trait Sealed {}
}

/// Decides exactly, for a pair that a filter has left in doubt, whether there is a hit up to `t_max`.
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

/// The closest hit.
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
}

impl<C> sealed::Sealed for Closest<'_, C> {}

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
    fn judge(&mut self, id: TriangleId, triangle: &Triangle, verdict: Verdict) -> ControlFlow<()> {
        let Hit { triangle: best, t: last, .. } = self.hit;
        let Intersection { t, u, v } = match verdict {
            Verdict::Hit(found) if found.t < last || id < best => found,
            Verdict::InDoubt | Verdict::Doubtful(_) => {
                // A triangle of a higher id must be hit before `last`: around a corner, most triangles are hit at
                // `last` itself, and are rejected without exact arithmetic.
                let t_max = if id < best { last } else { last.next_down() };
                match decided(self.ray, triangle, &verdict, t_max) {
                    Some(meeting) => meeting.intersection(),
                    None => return ControlFlow::Continue(()),
                }
            }
            _ => return ControlFlow::Continue(()),
        };
        self.hit = Hit { triangle: id, t, u, v };
        ControlFlow::Continue(())
    }
}

/// Whether anything is hit.
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

impl<C> sealed::Sealed for Occluded<'_, C> {}

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

/// Every hit, closest first, in a buffer that may be too short.
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

    /// Keeps the buffer sorted by `(t, id)`. A triangle filed in several cells comes again.
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
            // Only now may the search stop earlier: before, `truncated` was still to be found out.
            self.truncated = true;
            self.t_max = self.buffer.last().map_or(self.t_max, |hit| hit.t);
        }
    }
}

impl<C> sealed::Sealed for All<'_, '_, C> {}

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
    fn judge(&mut self, id: TriangleId, triangle: &Triangle, verdict: Verdict) -> ControlFlow<()> {
        let found = match verdict {
            Verdict::Missed => None,
            Verdict::Hit(found) => Some(found),
            _ => decided(self.ray, triangle, &verdict, self.t_max)
                .map(|meeting| meeting.intersection()),
        };
        if let Some(Intersection { t, u, v }) = found {
            self.insert(Hit { triangle: id, t, u, v });
        }
        if self.truncated && self.buffer.is_empty() {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}
