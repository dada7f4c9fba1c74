//! Estimate of the irradiance at a point, and the sums that it is made of.
//!
//! Sums are of whole numbers, so the order of the photons does not matter: neither threads nor the shape of a tree can
//! change a bit.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

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
        // In `f64`, so that the sum does not overflow.
        let [red, green, blue] = self.irradiance.map(f64::from);
        ((red + green + blue) / 3.0) as f32
    }

    /// Computes the light that leaves a surface of a colour, of red, green and blue in W/m2.
    pub fn exitance(&self, colour: [f32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|channel| f64::from(colour[channel]) * f64::from(self.irradiance[channel]))
    }
}

/// Steps of a sum in a weight of 1: 2^24.
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
        self.count = self.count.saturating_add(1);
        if weights == [1.0; 3] {
            // The usual case, with a third of the work.
            let sum = steps(kernel);
            self.weights = self.weights.map(|before| before.saturating_add(sum));
            self.squares = self.squares.saturating_add(steps(kernel * kernel));
            return;
        }
        let [red, green, blue] = weights.map(|weight| f64::from(weight) * kernel);
        let mean = (red + green + blue) / 3.0;
        for (sum, weight) in self.weights.iter_mut().zip([red, green, blue]) {
            *sum = sum.saturating_add(steps(weight));
        }
        self.squares = self.squares.saturating_add(steps(mean * mean));
    }

    /// Adds the sums over other photons. What reaches the largest number stays there, in whatever order sums are added.
    pub fn join(&mut self, other: &Self) {
        self.count = self.count.saturating_add(other.count);
        for (sum, other) in self.weights.iter_mut().zip(other.weights) {
            *sum = sum.saturating_add(other);
        }
        self.squares = self.squares.saturating_add(other.squares);
    }

    /// Numbers of which the sums consist; those of joined sums are the sums of the numbers.
    pub(super) fn to_words(self) -> [u64; 5] {
        let [red, green, blue] = self.weights;
        [self.count.into(), red, green, blue, self.squares]
    }

    /// Makes sums of their numbers.
    pub(super) fn from_words([count, red, green, blue, squares]: [u64; 5]) -> Self {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        Self { count, weights: [red, green, blue], squares }
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
        let density = |sum: u64| sum as f64 / STEPS * photon_flux / area;
        Estimate {
            irradiance: self.weights.map(|sum| rounded(density(sum))),
            count: self.count,
            radius: rounded(radius),
            standard_error: rounded((self.squares as f64 / STEPS).sqrt() * photon_flux / area),
        }
    }
}

/// Rounds to `f32`; values beyond its range become its largest.
pub(crate) fn rounded(value: f64) -> f32 {
    value.min(f64::from(f32::MAX)) as f32
}

/// Computes the area of a disc.
pub(super) fn disc_area(radius_squared: f64) -> f64 {
    PI * radius_squared
}
