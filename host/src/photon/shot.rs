//! What shooting photons resulted in.

use arboleda::{Counters, Triangle, TriangleId};

use super::digest::Digest;
use super::vector::Vector64;

/// The outcome of shooting photons.
///
/// Invariants: `emitted_photons = absorbed + escaped + cut_off + refused`; `hit_count` is the sum of
/// `hit_counts`, and no entry of `front_hit_counts` is above that of `hit_counts`; `ray_count = hit_count + escaped`.
/// Everything but the time and the number of threads depends on the model and the options only (the counters on the
/// index too), never on threads.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// How many photons left the lights; 0 if the model has none that emits.
    pub emitted_photons: u64,
    /// Photons that a triangle did not reflect.
    pub absorbed: u64,
    /// Photons that left the scene.
    pub escaped: u64,
    /// Photons that reached the largest number of bounces.
    pub cut_off: u64,
    /// Photons for which no valid ray could be made; see [`super::PathEnd::Refused`].
    pub refused: u64,
    /// Reflections of all photons together.
    pub bounce_count: u64,
    /// Hits of all triangles together.
    pub hit_count: u64,
    /// Rays asked for: one for each segment of a path.
    pub ray_count: u64,
    /// Hits of each triangle, from either side, by id.
    pub hit_counts: Vec<u64>,
    /// Hits of each triangle on its [front](super::Side::Front), by id.
    pub front_hit_counts: Vec<u64>,
    /// The power of all lights, in watts.
    pub total_flux: f64,
    /// What the index did, where that was asked for.
    pub counters: Option<Counters>,
    /// A hash over all hits.
    pub digest: Digest,
    /// How long it took, start of threads excluded.
    pub seconds: f64,
    /// How many threads took part.
    pub thread_count: usize,
}

impl Shot {
    /// Photons followed to their end in a second.
    pub fn photons_per_second(&self) -> f64 {
        self.emitted_photons as f64 / self.seconds
    }

    /// Rays answered in a second.
    pub fn rays_per_second(&self) -> f64 {
        self.ray_count as f64 / self.seconds
    }

    /// The power that each photon carries, in watts; 0 without photons.
    pub fn photon_flux(&self) -> f64 {
        if self.emitted_photons == 0 {
            return 0.0;
        }
        self.total_flux / self.emitted_photons as f64
    }

    /// The power that falls on a triangle, on both sides together, in watts; 0 if there is none of
    /// that id.
    pub fn flux(&self, id: TriangleId) -> f64 {
        let count = self.hit_counts.get(id.0 as usize).copied().unwrap_or(0);
        count as f64 * self.photon_flux()
    }

    /// The power that falls on a triangle divided by its area, in watts per square metre; 0 if it has
    /// no area.
    pub fn irradiance(&self, id: TriangleId, triangle: &Triangle) -> f64 {
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
        let area = 0.5 * (b - a).cross(c - a).length();
        if area > 0.0 { self.flux(id) / area } else { 0.0 }
    }
}
