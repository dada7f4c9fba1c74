//! Probe rays: they measure a subdivision before any of it is written, because their hit distances are already known.
//!
//! ```text
//! once:                 ray -> closest triangle of the group -> the t at which the ray ends
//! for each subdivision: ray -> the cells it enters up to that t, and the number of triangles in each
//! ```
//! The work of a query depends on where its ray ends, and that does not depend on the subdivision. So the number of
//! triangles in each cell is enough to compute exactly what the probe rays would take.

use core::ops::ControlFlow;

use bytemuck::{Pod, Zeroable};

use super::sample;
use crate::Vec3;
use crate::geometry::kernel::{Intersection, Verdict};
use crate::geometry::{Aabb, Ray, RaySpan, Span, Triangle};
use crate::input::CostModel;
use crate::query::{Closest, Counters, Query, TriangleId};

/// Probe ray, up to its closest hit.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ProbeRay {
    origin: [f32; 3],
    direction: [f32; 3],
    t_min: f32,
    end: f32,
}

/// Least number of probe rays. If fewer of the caller's rays meet a group, the group gets a sample of rays instead.
const FEWEST: usize = 32;
/// Largest number of probe rays.
const MOST: usize = 384;
/// Largest number of the caller's rays that are examined for one group: ten times the number of probe rays.
const MOST_EXAMINED: usize = 4096;

/// Returns the number of probe rays for a group of `triangle_count` triangles: enough that another choice of rays
/// changes little, and few beside the triangles that are filed for each subdivision.
pub(crate) const fn ray_count(triangle_count: usize) -> usize {
    match triangle_count {
        0..FEWEST => FEWEST,
        FEWEST..MOST => triangle_count,
        _ => MOST,
    }
}

/// Probe rays of a group.
pub(crate) struct Probe<'s> {
    bounds: Aabb,
    rays: &'s [ProbeRay],
    steps: u64,
}

impl<'s> Probe<'s> {
    /// Fills `room` with probe rays of some triangles in the box `bounds`.
    ///
    /// 1. Of the rays `given`, those that meet the box are taken, evenly.
    /// 2. If they are fewer than `FEWEST`, a [sample](sample::for_each_ray) is taken instead.
    /// 3. `find` finds the closest hit of each. After `most_tests` triangle tests, no more rays are taken.
    pub fn new(
        triangles: impl Iterator<Item = Triangle> + Clone,
        bounds: &Aabb,
        given: &[Ray],
        room: &'s mut [ProbeRay],
        most_tests: u64,
        mut find: impl FnMut(&RaySpan, Span, &mut Closest<'_, &mut Counters>),
    ) -> Self {
        let mut slots = room.iter_mut();
        let wanted = slots.len();
        let mut count = 0;
        let mut counters = Counters::default();
        let add = |ray: &Ray| {
            if counters.triangle_tests > most_tests {
                return;
            }
            let Some(slot) = slots.next() else { return };
            let mut query = Closest::new(ray, &mut counters);
            clipped(ray, bounds, |ray, span| find(ray, span, &mut query));
            let (origin, direction) = (ray.origin().to_array(), ray.direction().to_array());
            *slot = ProbeRay { origin, direction, t_min: ray.t_min(), end: query.last_t() };
            count += 1;
        };
        let meets = |ray: &&Ray| {
            let ray = RaySpan::new(ray, bounds);
            !ray.clip(bounds, ray.whole()).is_empty()
        };
        let given = given.iter().step_by(given.len().div_ceil(MOST_EXAMINED).max(1)).filter(meets);
        let met = given.clone().count();
        if met < FEWEST {
            sample::for_each_ray(triangles, wanted as u32, add);
        } else {
            given.step_by(met.div_ceil(wanted.max(1)).max(1)).for_each(add);
        }
        let steps = counters.triangle_tests.saturating_add(counters.nodes_visited);
        Self { bounds: *bounds, rays: room.get(..count).unwrap_or(&[]), steps }
    }

    /// The number of cells entered and triangles tested to find out where the rays end.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The cost of all probe rays together. `walk` shows a query the part of a ray that lies in the box.
    pub fn cost(
        &self,
        model: &CostModel,
        mut walk: impl FnMut(&RaySpan, Span, &mut CountingQuery<'_>),
    ) -> f64 {
        let (mut nodes, mut tests) = (0_u64, 0_u64);
        for tried in self.rays {
            let [origin, direction] = [tried.origin, tried.direction].map(Vec3::from_array);
            let ray = Ray::with_interval(origin, direction, tried.t_min, f32::INFINITY);
            let Ok(ray) = ray else { continue };
            let mut query = CountingQuery { ray: &ray, end: tried.end, nodes: 0, tests: 0 };
            clipped(&ray, &self.bounds, |ray, span| walk(ray, span, &mut query));
            nodes += query.nodes;
            tests += query.tests;
        }
        model.traversal * nodes as f64 + model.intersection * tests as f64
    }
}

/// Shows the part of a ray that may lie in a box, if there is one.
fn clipped(ray: &Ray, bounds: &Aabb, show: impl FnOnce(&RaySpan, Span)) {
    let ray = RaySpan::new(ray, bounds);
    let span = ray.clip(bounds, ray.whole());
    if !span.is_empty() {
        show(&ray, span);
    }
}

/// Query whose answer is known, and which only counts.
pub(crate) struct CountingQuery<'r> {
    ray: &'r Ray,
    end: f32,
    nodes: u64,
    tests: u64,
}

impl crate::sealed::Sealed for CountingQuery<'_> {}

impl Query for CountingQuery<'_> {
    fn enter(&mut self) {
        self.nodes += 1;
    }

    fn ray(&self) -> &Ray {
        self.ray
    }

    fn last_t(&self) -> f32 {
        self.end
    }

    fn count_tests(&mut self, count: u32) {
        self.tests += u64::from(count);
    }

    fn accept(&mut self, _: TriangleId, _: Intersection) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn judge(&mut self, _: TriangleId, _: &Triangle, _: Verdict) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
