//! Balance of photons: how each of them ended, and the power that they carry.

use serde::{Deserialize, Serialize};

use crate::photon::trace::PathEnd;

/// Ends of photons, and their power.
///
/// # Invariants
/// - `emitted = absorbed + escaped + cut_off + refused`, which is [`Balance::ended`].
/// - `rays = hits + escaped`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Photons that left the lights; 0 if no light of the model can emit.
    pub emitted: u64,
    /// Photons that a triangle did not reflect.
    pub absorbed: u64,
    /// Photons that left the scene.
    pub escaped: u64,
    /// Photons that would have bounced once more than the most bounces.
    pub cut_off: u64,
    /// Photons for which no valid ray could be made; see [`PathEnd::Refused`].
    pub refused: u64,
    /// Hits of all triangles together.
    pub hits: u64,
    /// Rays asked for: one for each segment of a path.
    pub rays: u64,
    /// Power of all lights in watts.
    pub total_flux: f64,
}

impl Balance {
    /// Computes the power that each photon carries, in watts; 0 without photons.
    pub fn photon_flux(&self) -> f64 {
        if self.emitted == 0 { 0.0 } else { self.total_flux / self.emitted as f64 }
    }

    /// Returns the number of photons whose paths ended.
    pub fn ended(&self) -> u64 {
        self.absorbed + self.escaped + self.cut_off + self.refused
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

    /// Counts the end of a photon.
    pub(in crate::photon) fn end(&mut self, end: PathEnd) {
        match end {
            PathEnd::Absorbed => self.absorbed += 1,
            PathEnd::Escaped => self.escaped += 1,
            PathEnd::CutOff => self.cut_off += 1,
            PathEnd::Refused => self.refused += 1,
        }
    }
}
