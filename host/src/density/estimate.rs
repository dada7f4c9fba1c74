//! Estimate of the irradiance at a point, and the sums that it is made of.
//!
//! Sums are of whole numbers, so the order of the photons does not matter: neither threads nor the shape of a tree can
//! change a bit.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Irradiance at a point, estimated from photons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Estimate {
    /// Irradiance of red, green and blue in W/m2. The three are equal in a grey model.
    pub irradiance: [f32; 3],
    /// Photons that were found. An estimate of the k nearest that found fewer than k is one of a fixed radius.
    pub count: u32,
    /// Radius of the disc in which photons were counted, in the scene's units.
    pub radius: f32,
    /// Standard deviation of the mean of the three irradiances, as estimated from the same photons. 0 without photons.
    pub standard_error: f32,
}

impl Estimate {
    /// Returns the mean of the three irradiances.
    pub fn mean(&self) -> f32 {
        (self.irradiance[0] + self.irradiance[1] + self.irradiance[2]) / 3.0
    }
}

/// Steps of a sum for a weight of 1: 2^24.
///
/// A weight is rounded to the nearest step, at most 3e-8 off, and clamped to 2^16. So 2^24 photons of the largest
/// weight fit into 64 bits. A weight of 2^16 takes ten bounces in a row on surfaces of one pure colour.
const STEPS: f64 = (1 << 24) as f64;
/// Largest weight of a photon in a sum.
const MOST: f64 = (1 << 16) as f64;

/// Rounds a weight to steps.
#[inline]
fn steps(weight: f64) -> u64 {
    (weight.min(MOST) * STEPS + 0.5) as u64
}

/// Sums over the photons of an estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sums {
    count: u32,
    weights: [u64; 3],
    /// Sum of the squares of the mean weights.
    squares: u64,
}

impl Sums {
    /// Adds a photon: its weights of red, green and blue, and that of the kernel.
    #[inline]
    pub fn add(&mut self, weights: [f32; 3], kernel: f64) {
        let [red, green, blue] = weights.map(|weight| f64::from(weight) * kernel);
        let mean = (red + green + blue) / 3.0;
        self.count += 1;
        for (sum, weight) in self.weights.iter_mut().zip([red, green, blue]) {
            *sum = sum.saturating_add(steps(weight));
        }
        self.squares = self.squares.saturating_add(steps(mean * mean));
    }

    /// Returns the sums over `count` photons of weight 1.
    pub fn of_count(count: u32) -> Self {
        let sum = u64::from(count) << 24;
        Self { count, weights: [sum; 3], squares: sum }
    }

    /// Returns the number of photons.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Makes the estimate: photons of `photon_flux` watts each on an `area` that the kernel covers. Values beyond the
    /// range of `f32` become its largest.
    pub fn estimate(&self, photon_flux: f64, area: f64, radius: f64) -> Estimate {
        if self.count == 0 || area <= 0.0 {
            return Estimate { count: self.count, radius: radius as f32, ..Estimate::default() };
        }
        let rounded = |value: f64| value.min(f64::from(f32::MAX)) as f32;
        let density = |sum: u64| sum as f64 / STEPS * photon_flux / area;
        Estimate {
            irradiance: self.weights.map(|sum| rounded(density(sum))),
            count: self.count,
            radius: rounded(radius),
            standard_error: rounded((self.squares as f64 / STEPS).sqrt() * photon_flux / area),
        }
    }
}

/// Computes the area of a disc.
pub(super) fn disc_area(radius_squared: f64) -> f64 {
    PI * radius_squared
}

/// Sums of many estimates that any thread may add to.
#[derive(Debug)]
pub(super) struct SharedSums {
    counts: Vec<AtomicU32>,
    /// Weights and squares; empty if every photon has the weight 1.
    weights: Vec<[AtomicU64; 4]>,
}

impl SharedSums {
    /// Creates sums of `len` estimates. If they are `uniform`, every photon has the weight 1, and 4 bytes an estimate
    /// suffice.
    pub fn new(len: usize, uniform: bool) -> Self {
        let weights = if uniform { 0 } else { len };
        Self {
            counts: (0..len).map(|_| AtomicU32::new(0)).collect(),
            weights: (0..weights).map(|_| [const { AtomicU64::new(0) }; 4]).collect(),
        }
    }

    /// Adds a photon to an estimate. Sums of whole numbers do not depend on the order, so relaxed ordering suffices.
    #[inline]
    pub fn add(&self, at: usize, weights: [f32; 3], kernel: f64) {
        self.counts[at].fetch_add(1, Ordering::Relaxed);
        if let Some(slots) = self.weights.get(at) {
            let mut sums = Sums::default();
            sums.add(weights, kernel);
            let [red, green, blue] = sums.weights;
            for (slot, sum) in slots.iter().zip([red, green, blue, sums.squares]) {
                slot.fetch_add(sum, Ordering::Relaxed);
            }
        }
    }

    /// Returns the bytes of the sums.
    pub fn bytes(&self) -> usize {
        size_of_val(self.counts.as_slice()) + size_of_val(self.weights.as_slice())
    }

    /// Returns the sums of an estimate.
    pub fn get(&self, at: usize) -> Sums {
        let count = self.counts[at].load(Ordering::Relaxed);
        match self.weights.get(at) {
            None => Sums::of_count(count),
            Some(slots) => {
                let [red, green, blue, squares] =
                    [0, 1, 2, 3].map(|slot| slots[slot].load(Ordering::Relaxed));
                Sums { count, weights: [red, green, blue], squares }
            }
        }
    }
}
