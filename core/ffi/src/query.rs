//! Queries of one ray.

use arboleda::{Counters, Hit, Ray, RayError, Vec3};
use bytemuck::{Pod, Zeroable};

use crate::error::{Failure, arb_status, status_of};
use crate::index::arb_index;
use crate::memory::{Caller, Output, apart, borrowed};

/// Ray: the points origin + t * direction for t_min <= t <= t_max. 32 bytes.
///
/// origin is finite. direction is finite, not zero, and of any length; t counts in lengths of it, so t is a distance if
/// that length is 1. t_min is at most t_max, neither is NaN, and both may be infinite: 0 and INFINITY of math.h for a
/// half-line, 0 and 1 for a segment whose direction goes from one end to the other.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct arb_ray {
    /// x, y, z of the point at t = 0.
    pub origin: [f32; 3],
    /// x, y, z of the direction.
    pub direction: [f32; 3],
    /// The smallest t that counts as a hit.
    pub t_min: f32,
    /// The largest t that counts as a hit.
    pub t_max: f32,
}

impl arb_ray {
    /// Converts the ray; the error names it as ray number `at`.
    pub fn converted(&self, at: usize) -> Result<Ray, Failure> {
        self.ray().map_err(|error| Failure::Ray { error, at })
    }

    /// Converts the ray.
    pub fn ray(&self) -> Result<Ray, RayError> {
        let (origin, direction) = (Vec3::from(self.origin), Vec3::from(self.direction));
        Ray::with_interval(origin, direction, self.t_min, self.t_max)
    }
}

/// Value of arb_hit.triangle for a ray that hits nothing.
pub const ARB_NO_TRIANGLE: u32 = 0xffff_ffff;

/// Hit of a ray. 16 bytes. All numbers are exact results, rounded once: the same bits for every kind of index, on every
/// machine.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct arb_hit {
    /// The triangle's id; of several that are hit at the same t, the lowest. ARB_NO_TRIANGLE if nothing is hit.
    pub triangle: u32,
    /// Distance from the origin of the ray, in lengths of its direction; INFINITY if nothing is hit.
    pub t: f32,
    /// The weight of corner b, 0 to 1: the point is a + u * (b - a) + v * (c - a).
    pub u: f32,
    /// The weight of corner c, 0 to 1.
    pub v: f32,
}

const _: () = assert!(size_of::<arb_hit>() == size_of::<Hit>());

/// Work of queries. The same for an index on every machine.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct arb_counters {
    /// Nodes entered.
    pub nodes_visited: u64,
    /// Triangles tested.
    pub triangle_tests: u64,
}

/// Checks a ray: ARB_OK if every query takes it.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, and any of arb_status from 60 to 69.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_check_ray(ray: *const arb_ray) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| caller.read(ray, "ray")?.converted(0).map(drop))
}

/// Finds the closest hit of a ray in t_min to t_max, both included; of several at the same t, the triangle with the
/// lowest id. A ray that hits nothing is no error: the hit's triangle is ARB_NO_TRIANGLE.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_NOT_OPEN, and any of arb_status from 60 to 69. `hit` is then unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_closest(
    index: *const arb_index,
    ray: *const arb_ray,
    hit: *mut arb_hit,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        let (index, ray) = (caller.index(index)?, caller.read(ray, "ray")?.converted(0)?);
        let to = Output::one(hit, "hit")?;
        caller.write(to, bytemuck::must_cast(index.closest_hit(&ray).unwrap_or(Hit::NONE)));
        Ok(())
    })
}

/// Tells whether a ray hits any triangle in t_min to t_max, both included: for shadow rays. It ends at the first hit
/// that it finds, and takes less time than arb_closest.
///
/// Errors: as arb_closest. `occluded` is then unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_occluded(
    index: *const arb_index,
    ray: *const arb_ray,
    occluded: *mut bool,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        let (index, ray) = (caller.index(index)?, caller.read(ray, "ray")?.converted(0)?);
        let to = Output::one(occluded, "occluded")?;
        caller.write(to, index.occluded(&ray));
        Ok(())
    })
}

/// Finds all hits of a ray, sorted by t, of the same t by id.
///
/// - `hits`: room for `capacity` hits; NULL if that is 0.
/// - `hit_count`: receives the number of hits that were written.
/// - `truncated`: receives true if there are more hits than `capacity`. The closest ones were written then; for the
///   others, ask again with more room.
///
/// Errors: as arb_closest, ARB_LENGTH_OVERFLOW, ARB_OVERLAP. All outputs are then unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_all_hits(
    index: *const arb_index,
    ray: *const arb_ray,
    hits: *mut arb_hit,
    capacity: usize,
    hit_count: *mut usize,
    truncated: *mut bool,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        let (index, ray) = (caller.index(index)?, caller.read(ray, "ray")?.converted(0)?);
        let hits = Output::check(hits, capacity, "hits")?;
        let count = Output::one(hit_count, "hit_count")?;
        let more = Output::one(truncated, "truncated")?;
        apart(&[hits.region(), count.region(), more.region()], &borrowed(index))?;
        let buffer = bytemuck::must_cast_slice_mut(caller.borrow_mut(hits));
        let all = index.all_hits(&ray, buffer);
        caller.write(count, all.hits.len());
        caller.write(more, all.truncated);
        Ok(())
    })
}

/// Finds the closest hit, as arb_closest does, and adds the work to `counters`, which the caller has set to zeros.
///
/// Errors: as arb_closest. Hit and counters are then unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_closest_counted(
    index: *const arb_index,
    ray: *const arb_ray,
    hit: *mut arb_hit,
    counters: *mut arb_counters,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        let (index, ray) = (caller.index(index)?, caller.read(ray, "ray")?.converted(0)?);
        let to = Output::one(hit, "hit")?;
        let mut work = Tally::read(caller, counters)?;
        let found = index.closest_hit_counted(&ray, &mut work.counters);
        caller.write(to, bytemuck::must_cast(found.unwrap_or(Hit::NONE)));
        work.write(caller);
        Ok(())
    })
}

/// Tells whether a ray hits any triangle, as arb_occluded does, and adds the work to `counters`, which the caller has
/// set to zeros.
///
/// Errors: as arb_closest. Both outputs are then unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_occluded_counted(
    index: *const arb_index,
    ray: *const arb_ray,
    occluded: *mut bool,
    counters: *mut arb_counters,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        let (index, ray) = (caller.index(index)?, caller.read(ray, "ray")?.converted(0)?);
        let to = Output::one(occluded, "occluded")?;
        let mut work = Tally::read(caller, counters)?;
        let found = index.occluded_counted(&ray, &mut work.counters);
        caller.write(to, found);
        work.write(caller);
        Ok(())
    })
}

/// The caller's counters, and where they lie.
struct Tally {
    to: Output<arb_counters>,
    before: arb_counters,
    /// Work of one query, which cannot overflow; the sum wraps.
    counters: Counters,
}

impl Tally {
    fn read(caller: Caller, counters: *mut arb_counters) -> Result<Self, Failure> {
        let before = caller.read(counters.cast_const(), "counters")?;
        let to = Output::one(counters, "counters")?;
        Ok(Self { to, before, counters: Counters::default() })
    }

    fn write(self, caller: Caller) {
        let Counters { nodes_visited, triangle_tests } = self.counters;
        let sum = arb_counters {
            nodes_visited: self.before.nodes_visited.wrapping_add(nodes_visited),
            triangle_tests: self.before.triangle_tests.wrapping_add(triangle_tests),
        };
        caller.write(self.to, sum);
    }
}
