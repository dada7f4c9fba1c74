//! The indices of `arboleda`, in the same ring as the others.

use arboleda::kinds::Representation;
use arboleda::{AnyIndex, Hit, Index, IndexKind, Ray, RayIndex};

use super::contender::{Batch, Contender};

/// The name of an index of ours among the contenders: its own, unless a library has that.
pub fn name(kind: IndexKind) -> &'static str {
    match kind {
        IndexKind::Bvh => "arboleda-bvh",
        other => other.name(),
    }
}

/// Whether an index of ours is looked at as it is meant to be used: beside an indexed mesh that the application
/// keeps, and without a copy of the triangles.
pub(crate) fn is_beside(kind: IndexKind) -> bool {
    matches!(kind, IndexKind::LeanBvh | IndexKind::LeanBvhHierarchy)
}

/// An index of ours whose kind is known where the loops are compiled, as the others' is.
struct Ours<I>(I);

/// Takes an index as it was read from its arena.
///
/// The kinds made for speed, and those that Embree is compared with by default, are looked at directly;
/// the rest pays for an indirect call each ray.
pub fn contender(index: AnyIndex<'_>) -> Box<dyn Contender + '_> {
    fn direct<'a, R: Representation>(index: Index<'a, R>) -> Box<dyn Contender + 'a> {
        Box::new(Ours(index))
    }
    match index {
        AnyIndex::Octree(index) => direct(index),
        AnyIndex::OctreeHierarchy(index) => direct(index),
        AnyIndex::Bvh(index) => direct(index),
        AnyIndex::BvhHierarchy(index) => direct(index),
        AnyIndex::WideBvh(index) => direct(index),
        AnyIndex::WideBvhHierarchy(index) => direct(index),
        AnyIndex::CompactBvh(index) => direct(index),
        AnyIndex::CompactBvhHierarchy(index) => direct(index),
        AnyIndex::LeanBvh(index) => direct(index),
        AnyIndex::LeanBvhHierarchy(index) => direct(index),
        other => Box::new(Ours(other)),
    }
}

impl<I: RayIndex> Contender for Ours<I> {
    fn bytes(&self) -> Option<usize> {
        Some(self.0.as_bytes().len())
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.0.closest_hit(ray).unwrap_or(Hit::NONE);
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        self.0.occluded_each(rays, answers);
    }

    fn batch(&self) -> Option<&dyn Batch> {
        Some(self)
    }
}

impl<I: RayIndex> Batch for Ours<I> {
    fn closest_hits_together(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.0.closest_hits(rays, hits);
    }
}
