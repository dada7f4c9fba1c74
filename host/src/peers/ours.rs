//! The indices of `arboleda`, in the same ring as the others.

use arboleda::{AnyIndex, Ray, RayIndex};

use super::contender::{Contender, PeerHit};

/// An index of ours.
pub struct Ours<'a> {
    index: AnyIndex<'a>,
}

impl<'a> Ours<'a> {
    /// Takes an index as it was read from its arena.
    pub fn new(index: AnyIndex<'a>) -> Self {
        Self { index }
    }
}

impl Contender for Ours<'_> {
    fn bytes(&self) -> Option<usize> {
        Some(self.index.as_bytes().len())
    }

    // The kind is looked up once for the slice. What is left for each ray is one call through a
    // pointer, which Embree's interface costs too.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [PeerHit]) {
        let index = self.index.as_ray_index();
        for (ray, answer) in rays.iter().zip(hits) {
            *answer = index
                .closest_hit(ray)
                .map_or(PeerHit::MISS, |hit| PeerHit { triangle: hit.triangle.0, t: hit.t });
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        let index = self.index.as_ray_index();
        for (ray, answer) in rays.iter().zip(answers) {
            *answer = index.occluded(ray);
        }
    }
}
