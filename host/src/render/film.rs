//! Film: values of the pixels of a picture, as the mean of its passes.

use super::samples::{Glow, PixelShare};
use crate::density::Estimate;
use crate::photon::Digest;

/// Values of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Irradiance of red, green and blue in W/m2, the mean over the part of the pixel that surfaces cover.
    pub irradiance: [f32; 3],
    /// Reflected radiance in W/(m2 sr), the mean over the whole pixel.
    pub reflected: [f32; 3],
    /// Emitted radiance in W/(m2 sr), the mean over the whole pixel.
    pub emitted: [f32; 3],
    /// Standard error of the mean of the three irradiances.
    pub standard_error: f32,
    /// Part of the pixel that surfaces cover, 0 to 1.
    pub coverage: f32,
    /// Photons of all passes, at the surface that most of the pixel's rays hit.
    pub count: u32,
    /// Mean radius of the estimates at that surface.
    pub radius: f32,
    /// Distance of that surface along the line of sight; infinite without a hit.
    pub depth: f32,
    /// Triangle that most of the pixel's rays hit; `u32::MAX` without a hit.
    pub triangle: u32,
}

impl Pixel {
    const EMPTY: Self = Self {
        irradiance: [0.0; 3],
        reflected: [0.0; 3],
        emitted: [0.0; 3],
        standard_error: 0.0,
        coverage: 0.0,
        count: 0,
        radius: 0.0,
        depth: f32::INFINITY,
        triangle: u32::MAX,
    };

    /// Tells whether some ray of the pixel hit a surface.
    pub fn is_hit(&self) -> bool {
        self.coverage > 0.0
    }

    /// Returns the radiance: reflected and emitted.
    pub fn radiance(&self) -> [f32; 3] {
        [0, 1, 2].map(|channel| self.reflected[channel] + self.emitted[channel])
    }

    /// Returns the mean of the three irradiances.
    pub fn mean_irradiance(&self) -> f32 {
        (self.irradiance[0] + self.irradiance[1] + self.irradiance[2]) / 3.0
    }
}

/// Pixels of a picture, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<Pixel>,
    /// Rays of each pixel that hit the surface whose triangle, depth and count the pixel has.
    main_rays: Vec<u32>,
}

impl Film {
    /// Creates a film on which nothing has fallen.
    pub fn new(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        Self { width, height, pixels: vec![Pixel::EMPTY; count], main_rays: vec![0; count] }
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Returns the pixels, row by row.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// Hashes the values of the pixels.
    pub fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        for pixel in &self.pixels {
            let Pixel { irradiance, reflected, emitted, .. } = pixel;
            let Pixel { standard_error, coverage, count, radius, depth, triangle, .. } = *pixel;
            let colours = irradiance.iter().chain(reflected).chain(emitted).copied();
            let floats = colours.chain([standard_error, coverage, radius, depth]);
            for word in floats.map(f32::to_bits).chain([count, triangle]) {
                hasher.update(&word.to_le_bytes());
            }
        }
        Digest(*hasher.finalize().as_bytes())
    }

    /// Adds an estimate to a `part` of a pixel, with the radiance that the surface reflects.
    pub(super) fn add(
        &mut self,
        share: &PixelShare,
        part: f32,
        estimate: &Estimate,
        reflected: [f32; 3],
    ) {
        let at = share.pixel as usize;
        let Some(pixel) = self.pixels.get_mut(at) else { return };
        add_part(&mut pixel.irradiance, part, estimate.irradiance);
        add_part(&mut pixel.reflected, part, reflected);
        pixel.coverage += part;
        // Estimates of one pixel share photons, so their errors add up.
        pixel.standard_error += part * estimate.standard_error;
        if share.rays > self.main_rays[at] {
            self.main_rays[at] = share.rays;
            pixel.count = estimate.count;
            pixel.radius = estimate.radius;
            pixel.depth = share.depth;
            pixel.triangle = share.triangle;
        }
    }

    pub(super) fn add_emitted(&mut self, share: &PixelShare, part: f32, glow: &Glow) {
        if let (Some(pixel), Some(radiance)) =
            (self.pixels.get_mut(share.pixel as usize), glow.seen(share.triangle, share.front))
        {
            add_part(&mut pixel.emitted, part, radiance);
        }
    }

    /// Divides the sums of irradiance and of its error by the covered part of each pixel, so that they become means.
    pub(super) fn finish(&mut self) {
        for pixel in self.pixels.iter_mut().filter(|pixel| pixel.coverage > 0.0) {
            for channel in &mut pixel.irradiance {
                *channel /= pixel.coverage;
            }
            pixel.standard_error /= pixel.coverage;
        }
    }

    /// Adds a pass to this film, the mean of `passes` passes.
    pub(super) fn join(&mut self, other: &Self, passes: u32) {
        let (before, all) = (passes as f32, (passes + 1) as f32);
        for (mean, pixel) in self.pixels.iter_mut().zip(&other.pixels) {
            let joined = |mean: f32, next: f32| mean + (next - mean) / all;
            for channel in 0..3 {
                mean.irradiance[channel] =
                    joined(mean.irradiance[channel], pixel.irradiance[channel]);
                mean.reflected[channel] = joined(mean.reflected[channel], pixel.reflected[channel]);
            }
            mean.radius = joined(mean.radius, pixel.radius);
            mean.count = mean.count.saturating_add(pixel.count);
            // Passes have different photons, so their errors are independent.
            let error = mean.standard_error * before;
            let next = pixel.standard_error;
            mean.standard_error = (error * error + next * next).sqrt() / all;
        }
    }
}

/// Adds a part of three values to their sums.
fn add_part(sums: &mut [f32; 3], part: f32, values: [f32; 3]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += part * value;
    }
}
