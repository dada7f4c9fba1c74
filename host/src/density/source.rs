//! Source of photons: a model with an index, the numbers of the photons, and the bounces that count.

use std::ops::Range;

use arboleda::{Hit, RayIndex, Triangle};

use crate::photon::{Balance, Counting, DEFAULT_MAX_BOUNCES, Segment, Tracer, Visitor, stream};
use crate::scene::Model;

/// Part of a photon's path that estimates count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bounces {
    /// The whole path.
    #[default]
    All,
    /// The segment from the light.
    Direct,
    /// The segments after the first bounce.
    Indirect,
}

impl Bounces {
    /// Tells whether a segment after `bounce` bounces counts.
    #[inline]
    pub fn includes(self, bounce: u32) -> bool {
        match self {
            Self::All => true,
            Self::Direct => bounce == 0,
            Self::Indirect => bounce > 0,
        }
    }
}

/// Photons from the lights of a model, made again from their numbers whenever they are needed.
#[derive(Clone)]
pub struct PhotonSource<'m> {
    /// Triangles and lights.
    pub model: &'m Model,
    /// Index over the model's triangles. No result depends on its kind.
    pub index: &'m (dyn RayIndex + Sync),
    /// Numbers of the photons.
    pub photons: Range<u64>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Most bounces of a photon.
    pub max_bounces: u32,
    /// Segments that count.
    pub bounces: Bounces,
}

impl<'m> PhotonSource<'m> {
    /// Creates the source of the first `photons` photons, which bounce at most [`DEFAULT_MAX_BOUNCES`] times. All
    /// segments count.
    pub fn new(
        model: &'m Model,
        index: &'m (dyn RayIndex + Sync),
        photons: u64,
        seed: u64,
    ) -> Self {
        let (max_bounces, bounces) = (DEFAULT_MAX_BOUNCES, Bounces::All);
        Self { model, index, photons: 0..photons, seed, max_bounces, bounces }
    }

    /// Streams all segments to a visitor, in the caller's pool. `end` receives the states of the chunks in their order.
    pub(crate) fn stream<V: Visitor>(
        &self,
        progress: &(impl Fn(u64) + Sync),
        visitor: &V,
        end: impl FnMut(V::State),
    ) -> Balance {
        let tracer = Tracer::new(self.model, self.seed, self.max_bounces);
        let photons = self.photons.clone();
        stream(&tracer, photons, self.index, Counting::Off, progress, visitor, end).balance
    }

    /// Returns the triangle and the hit at the end of a segment; `None` if the segment does not count, has no hit, or
    /// hits a triangle that the model does not have.
    #[inline]
    pub(super) fn counted_hit(&self, segment: &Segment) -> Option<(&'m Triangle, Hit)> {
        let hit = segment.hit.filter(|_| self.bounces.includes(segment.bounce))?;
        Some((self.model.triangles.get(hit.triangle.0 as usize)?, hit))
    }
}
