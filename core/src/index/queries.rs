//! Queries of an index: one ray, or a batch.

use super::Index;
use crate::geometry::Ray;
#[cfg(any(feature = "wide-bvh", feature = "compact-bvh", feature = "lean-bvh"))]
use crate::indices::wide;
use crate::memory::put;
use crate::query::{All, AllHits, BatchQuery, Closest, Count, Counters, Hit, Occluded, Query};
use crate::structure::{Representation, Structure};

/// Length in bytes of a scratch that every batch query of every index can use, wherever it begins: about 39 KiB on
/// x86-64. 0 if the target or the features have no index that uses one.
///
/// # Examples
/// ```
/// # #[cfg(all(feature = "alloc", feature = "wide-bvh"))] {
/// use arboleda::{BATCH_SCRATCH, Hit, Index, Options, OwnedIndex, IndexKind, Ray, Scene, Triangle, Vec3};
///
/// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
/// let owned = OwnedIndex::build(IndexKind::WideBvh, &Scene::new(&triangles), &Options::DEFAULT)?;
/// let rays = [Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z)?; 200];
/// let (mut hits, mut scratch) = ([Hit::NONE; 200], vec![0; BATCH_SCRATCH]);
/// owned.index().closest_hits_in(&rays, &mut hits, &mut scratch);
/// assert!(hits.iter().all(|hit| hit.t == 1.0));
/// # }
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[cfg(any(feature = "wide-bvh", feature = "compact-bvh", feature = "lean-bvh"))]
pub const BATCH_SCRATCH: usize = wide::BATCH_SCRATCH;
#[cfg(not(any(feature = "wide-bvh", feature = "compact-bvh", feature = "lean-bvh")))]
#[allow(missing_docs)] // above
pub const BATCH_SCRATCH: usize = 0;

impl<R: Representation> Index<'_, R> {
    fn run<Q: Query>(&self, query: &mut Q) {
        R::Structure::traverse(&self.sections, self.simd_level, query);
    }

    fn run_each<Q: BatchQuery>(
        &self,
        scratch: &mut [u8],
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        finish: impl FnMut(usize, Hit),
    ) {
        let (sections, level) = (&self.sections, self.simd_level);
        R::Structure::traverse_each(sections, level, scratch, count, start, finish);
    }

    fn closest<C: Count>(&self, ray: &Ray, count: C) -> Option<Hit> {
        let mut query = Closest::new(ray, count);
        self.run(&mut query);
        query.finish()
    }

    fn any<C: Count>(&self, ray: &Ray, count: C) -> bool {
        let mut query = Occluded::new(ray, count);
        self.run(&mut query);
        query.found
    }
}

/// Queries. None fails, and none allocates. The answers are exact, and the same bits for every kind of index.
impl<'a, R: Representation> Index<'a, R> {
    /// The bytes of the index: what to write to a file, and to open with [`Index::from_bytes`].
    pub fn as_bytes(&self) -> &'a [u8] {
        self.sections.bytes()
    }

    /// Finds the closest hit in `t_min..=t_max`. Of several at the same `t`, it is the triangle with the lowest id.
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.closest(ray, ())
    }

    /// Tells whether any triangle is hit in `t_min..=t_max`: an any-hit query, which ends at the first hit. For shadow
    /// rays.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.any(ray, ())
    }

    /// Finds the closest hit of each ray, or [`Hit::NONE`]: the same bits as [`Index::closest_hit`].
    ///
    /// In the wide, compact and lean BVH it takes less time than single rays; [`Index::closest_hits_in`] takes the least.
    /// Rays beyond the length of `hits` are not asked about; hits beyond the length of `rays` stay as they are.
    ///
    /// On targets with vector registers, these three traverse four rays in turn, whose state takes some 13 KiB of the
    /// stack; single rays take less. For other targets see [`IndexKind`](crate::IndexKind#stack).
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.closest_hits_in(rays, hits, &mut []);
    }

    /// Finds the closest hit of each ray, as [`Index::closest_hits`] does and with the same bits, in memory of the
    /// caller: the fastest way to trace many rays.
    ///
    /// `scratch` has [`BATCH_SCRATCH`] bytes or more, at any alignment; what is in it does not matter. With AVX2, the wide,
    /// compact and lean BVH use it for batches of 128 rays or more, for the state of 32 rays in flight. In other cases, and
    /// with a shorter scratch, this is [`Index::closest_hits`].
    pub fn closest_hits_in(&self, rays: &[Ray], hits: &mut [Hit], scratch: &mut [u8]) {
        let start = |index: usize| rays.get(index).map(|ray| Closest::new(ray, ()));
        let count = rays.len().min(hits.len());
        let finish = |index, hit| put(hits, index, hit);
        self.run_each(scratch, count, start, finish);
    }

    /// Tells for each ray whether any triangle is hit, as [`Index::occluded`] does; a batch as in
    /// [`Index::closest_hits`].
    pub fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.occluded_each_in(rays, occluded, &mut []);
    }

    /// Tells for each ray whether any triangle is hit, as [`Index::occluded_each`] does, in memory of the caller; see
    /// [`Index::closest_hits_in`].
    pub fn occluded_each_in(&self, rays: &[Ray], occluded: &mut [bool], scratch: &mut [u8]) {
        let start = |index: usize| rays.get(index).map(|ray| Occluded::new(ray, ()));
        let count = rays.len().min(occluded.len());
        let finish = |index, hit: Hit| put(occluded, index, !hit.is_none());
        self.run_each(scratch, count, start, finish);
    }

    /// Finds all hits, sorted by `(t, id)`. If `buffer` is too short, it gets the closest ones, and
    /// [`AllHits::truncated`] is true.
    pub fn all_hits<'h>(&self, ray: &Ray, buffer: &'h mut [Hit]) -> AllHits<'h> {
        let mut query = All::new(ray, buffer, ());
        self.run(&mut query);
        query.finish()
    }

    /// Finds the closest hit, as [`Index::closest_hit`] does, and adds the work to `counters`.
    pub fn closest_hit_counted(&self, ray: &Ray, counters: &mut Counters) -> Option<Hit> {
        self.closest(ray, counters)
    }

    /// Tells whether any triangle is hit, as [`Index::occluded`] does, and adds the work to `counters`.
    pub fn occluded_counted(&self, ray: &Ray, counters: &mut Counters) -> bool {
        self.any(ray, counters)
    }
}
