//! Photons of an estimate: which model, index, numbers and bounces they have.

use std::ops::Range;

use arboleda::RayIndex;

use crate::photon::{Counting, Tally, Tracer, Visitor, stream};
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

/// Ends of photons, and the power that each carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Photons that left the lights.
    pub emitted: u64,
    /// Photons that a triangle did not reflect.
    pub absorbed: u64,
    /// Photons that left the scene.
    pub escaped: u64,
    /// Photons that reached the most bounces.
    pub cut_off: u64,
    /// Photons for which no valid ray could be made.
    pub refused: u64,
    /// Hits of triangles.
    pub hits: u64,
    /// Segments: hits, and escapes.
    pub rays: u64,
    /// Power of all lights in watts.
    pub total_flux: f64,
}

impl Balance {
    /// Computes the power that each photon carries, in watts; 0 without photons.
    pub fn photon_flux(&self) -> f64 {
        if self.emitted == 0 { 0.0 } else { self.total_flux / self.emitted as f64 }
    }

    /// Adds the photons of another range of the same source.
    pub fn join(&mut self, other: &Self) {
        self.emitted += other.emitted;
        self.absorbed += other.absorbed;
        self.escaped += other.escaped;
        self.cut_off += other.cut_off;
        self.refused += other.refused;
        self.hits += other.hits;
        self.rays += other.rays;
        self.total_flux = other.total_flux;
    }
}

impl PhotonSource<'_> {
    /// Streams all segments to a visitor, in the caller's pool. `end` receives the states of the chunks in their order.
    pub(crate) fn stream<V: Visitor>(
        &self,
        progress: &(impl Fn(u64) + Sync),
        visitor: &V,
        end: impl FnMut(V::State),
    ) -> Balance {
        let tracer = Tracer::new(self.model, self.seed, self.max_bounces);
        let dark = tracer.emitter().is_dark();
        let photons =
            if dark { self.photons.start..self.photons.start } else { self.photons.clone() };
        let emitted = photons.end.saturating_sub(photons.start);
        let total_flux = tracer.emitter().total_flux();
        let Tally { absorbed, escaped, cut_off, refused, hit_count, ray_count, .. } =
            stream(&tracer, photons, self.index, Counting::Off, progress, visitor, end);
        Balance {
            emitted,
            absorbed,
            escaped,
            cut_off,
            refused,
            hits: hit_count,
            rays: ray_count,
            total_flux,
        }
    }
}
