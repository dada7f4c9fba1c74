//! The indices of `arboleda`, as contenders among the others.

use arboleda::kinds::Representation;
use arboleda::{AnyIndex, BATCH_SCRATCH, Hit, Index, IndexKind, Ray, RayIndex};

use super::contender::{Batch, Contender};

/// Names an index of ours among the contenders: as usual, unless a library has that name.
pub fn name(kind: IndexKind) -> &'static str {
    match kind {
        IndexKind::Bvh => "arboleda-bvh",
        other => other.name(),
    }
}

/// Tells whether an index of ours is measured as it is meant to be used: beside an indexed mesh that the application
/// keeps, and without a copy of the triangles.
pub fn is_beside(kind: IndexKind) -> bool {
    matches!(kind, IndexKind::LeanBvh | IndexKind::LeanBvhHierarchy)
}

/// Index of ours. For [`AnyIndex`], each ray pays for finding out its kind: the same for all kinds, where they are
/// compared with each other.
pub struct Ours<I>(pub I);

/// Takes an index whose kind is to be known where the loops are compiled, as the libraries' is.
///
/// The kinds made for speed, and those that libraries are compared with by default, are known there. The others are
/// [`Ours`] of any index.
pub fn direct(index: AnyIndex<'_>) -> Box<dyn Contender + '_> {
    fn known<'a, R: Representation>(index: Index<'a, R>) -> Box<dyn Contender + 'a> {
        Box::new(Ours(index))
    }
    match index {
        AnyIndex::Octree(index) => known(index),
        AnyIndex::OctreeHierarchy(index) => known(index),
        AnyIndex::Bvh(index) => known(index),
        AnyIndex::BvhHierarchy(index) => known(index),
        AnyIndex::WideBvh(index) => known(index),
        AnyIndex::WideBvhHierarchy(index) => known(index),
        AnyIndex::CompactBvh(index) => known(index),
        AnyIndex::CompactBvhHierarchy(index) => known(index),
        AnyIndex::LeanBvh(index) => known(index),
        AnyIndex::LeanBvhHierarchy(index) => known(index),
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
        self.0.occluded_each_in(rays, answers, &mut vec![0; BATCH_SCRATCH]);
    }

    fn batch(&self) -> Option<&dyn Batch> {
        Some(self)
    }
}

impl<I: RayIndex> Batch for Ours<I> {
    fn closest_hits_together(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.0.closest_hits_in(rays, hits, &mut vec![0; BATCH_SCRATCH]);
    }
}
