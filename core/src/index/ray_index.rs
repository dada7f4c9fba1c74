//! Trait with the queries, for code that is generic over indices or has them behind `dyn`.

use super::{AnyIndex, Index};
use crate::geometry::Ray;
use crate::query::{AllHits, Counters, Hit};
use crate::sealed::Sealed;
use crate::structure::Representation;

/// Queries of [`Index`] and [`AnyIndex`], for generic and `dyn` use. Every index over the same triangles gives the same
/// bits.
pub trait RayIndex: Sealed {
    /// The bytes of the index; see [`Index::as_bytes`](crate::Index::as_bytes).
    fn as_bytes(&self) -> &[u8];

    /// Finds the closest hit; see [`Index::closest_hit`](crate::Index::closest_hit).
    fn closest_hit(&self, ray: &Ray) -> Option<Hit>;

    /// Tells whether any triangle is hit; see [`Index::occluded`](crate::Index::occluded).
    fn occluded(&self, ray: &Ray) -> bool;

    /// Finds the closest hit of each ray; see [`Index::closest_hits`](crate::Index::closest_hits).
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]);

    /// Finds the closest hit of each ray, in memory of the caller; see
    /// [`Index::closest_hits_in`](crate::Index::closest_hits_in).
    fn closest_hits_in(&self, rays: &[Ray], hits: &mut [Hit], scratch: &mut [u8]);

    /// Tells for each ray whether any triangle is hit; see [`Index::occluded_each`](crate::Index::occluded_each).
    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]);

    /// Tells for each ray whether any triangle is hit, in memory of the caller; see
    /// [`Index::occluded_each_in`](crate::Index::occluded_each_in).
    fn occluded_each_in(&self, rays: &[Ray], occluded: &mut [bool], scratch: &mut [u8]);

    /// Finds all hits, sorted by `(t, id)`; see [`Index::all_hits`](crate::Index::all_hits).
    fn all_hits<'h>(&self, ray: &Ray, buffer: &'h mut [Hit]) -> AllHits<'h>;

    /// Finds the closest hit and counts the work; see
    /// [`Index::closest_hit_counted`](crate::Index::closest_hit_counted).
    fn closest_hit_counted(&self, ray: &Ray, counters: &mut Counters) -> Option<Hit>;

    /// Tells whether any triangle is hit and counts the work; see
    /// [`Index::occluded_counted`](crate::Index::occluded_counted).
    fn occluded_counted(&self, ray: &Ray, counters: &mut Counters) -> bool;
}

impl<R: Representation> Sealed for Index<'_, R> {}
impl Sealed for AnyIndex<'_> {}

/// Implements the trait by the methods of the same names.
macro_rules! forward {
    ([$($generics:tt)*] $index:ty) => {
        impl<$($generics)*> RayIndex for $index {
            fn as_bytes(&self) -> &[u8] {
                <$index>::as_bytes(self)
            }

            fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
                <$index>::closest_hit(self, ray)
            }

            fn occluded(&self, ray: &Ray) -> bool {
                <$index>::occluded(self, ray)
            }

            fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
                <$index>::closest_hits(self, rays, hits);
            }

            fn closest_hits_in(&self, rays: &[Ray], hits: &mut [Hit], scratch: &mut [u8]) {
                <$index>::closest_hits_in(self, rays, hits, scratch);
            }

            fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
                <$index>::occluded_each(self, rays, occluded);
            }

            fn occluded_each_in(&self, rays: &[Ray], occluded: &mut [bool], scratch: &mut [u8]) {
                <$index>::occluded_each_in(self, rays, occluded, scratch);
            }

            fn all_hits<'h>(&self, ray: &Ray, buffer: &'h mut [Hit]) -> AllHits<'h> {
                <$index>::all_hits(self, ray, buffer)
            }

            fn closest_hit_counted(&self, ray: &Ray, counters: &mut Counters) -> Option<Hit> {
                <$index>::closest_hit_counted(self, ray, counters)
            }

            fn occluded_counted(&self, ray: &Ray, counters: &mut Counters) -> bool {
                <$index>::occluded_counted(self, ray, counters)
            }
        }
    };
}
forward!(['a, R: Representation] Index<'a, R>);
forward!(['a] AnyIndex<'a>);
