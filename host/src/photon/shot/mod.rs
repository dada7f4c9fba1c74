//! Shot: photons through an index, and what they leave behind.
//!
//! ```text
//! stream of photons --shoot--> hits of each triangle | balance of ends and power | digest of all hits
//! a range of them --shoot_range--> sums --join--> the same
//! ```

mod balance;
mod digest;
mod digest_tree;
mod range_sums;
mod shoot;

pub use balance::Balance;
pub use digest::Digest;
pub use range_sums::RangeSums;
pub use shoot::{Counting, ShootOptions, shoot, shoot_range};

use arboleda::{Counters, Triangle, TriangleId};

use crate::scene::vector::area_of;

/// Result of shooting photons.
///
/// # Invariants
/// - `balance.hits` is the sum of `hit_counts`.
/// - Each entry of `front_hit_counts` is at most that of `hit_counts`.
/// - All fields but `seconds`, `thread_count` and `counters` are functions of the model and the options. `counters`
///   depend on the index too, but not on the threads.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// Ends of the photons.
    pub balance: Balance,
    /// Reflections of all photons together.
    pub bounce_count: u64,
    /// Hits of each triangle, from either side, by id.
    pub hit_counts: Vec<u64>,
    /// Hits of each triangle on its [front](crate::photon::Side::Front), by id.
    pub front_hit_counts: Vec<u64>,
    /// Counters of the index, with [`super::Counting::On`].
    pub counters: Option<Counters>,
    /// Hash of all hits.
    pub digest: Digest,
    /// Duration in seconds, without the start of threads.
    pub seconds: f64,
    /// Number of threads.
    pub thread_count: usize,
}

impl Shot {
    /// Computes the number of photons followed to their end in a second.
    pub fn photons_per_second(&self) -> f64 {
        self.balance.emitted as f64 / self.seconds
    }

    /// Computes the number of rays answered in a second.
    pub fn rays_per_second(&self) -> f64 {
        self.balance.rays as f64 / self.seconds
    }

    /// Computes the power that falls on both sides of a triangle, in watts; 0 if no triangle has this id.
    pub fn flux(&self, id: TriangleId) -> f64 {
        let count = self.hit_counts.get(id.0 as usize).copied().unwrap_or(0);
        count as f64 * self.balance.photon_flux()
    }

    /// Computes the irradiance of a triangle: the flux on both sides, divided by the area of one, in watts per square
    /// metre if coordinates are in metres; 0 if it has no area. The relative standard error is about 1/√hits.
    pub fn irradiance(&self, id: TriangleId, triangle: &Triangle) -> f64 {
        let area = area_of(triangle);
        if area > 0.0 { self.flux(id) / area } else { 0.0 }
    }
}
