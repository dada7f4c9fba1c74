//! Colours of pictures and plots.

use image::Rgb;

/// Colour of red, green and blue, each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour(pub f32, pub f32, pub f32);

impl Colour {
    /// Background of the page.
    pub const PAPER: Self = Self(0.97, 0.97, 0.96);
    /// Colour of text and lines.
    pub const INK: Self = Self(0.16, 0.18, 0.22);

    /// Multiplies the brightness.
    #[must_use]
    pub fn times(self, factor: f32) -> Self {
        Self(self.0 * factor, self.1 * factor, self.2 * factor)
    }

    /// Interpolates linearly: `self` at `part` 0, `other` at `part` 1.
    #[must_use]
    pub fn mixed(self, other: Self, part: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * part;
        Self(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }

    pub(super) fn to_pixel(self) -> Rgb<u8> {
        Rgb([self.0, self.1, self.2].map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8))
    }
}

/// Returns the colour of a cluster. Clusters with neighbouring numbers get distant hues.
pub fn cluster_colour(cluster: u32) -> Colour {
    // Multiples of the golden ratio, modulo 1, fill the circle of hues evenly.
    let hue = (f64::from(cluster) * 0.618_033_988_749_895 + 0.07).fract() as f32 * 6.0;
    let ramp = |offset: f32| {
        let x = (hue + offset).rem_euclid(6.0);
        (if x < 3.0 { x - 1.0 } else { 5.0 - x }).clamp(0.0, 1.0)
    };
    let pure = Colour(ramp(2.0), ramp(0.0), ramp(4.0));
    pure.mixed(Colour(0.62, 0.62, 0.62), 0.38)
}

/// Returns the colour of a value from 0 to 1: dark violet, red, light yellow.
pub fn heat(value: f32) -> Colour {
    const STOPS: [Colour; 5] = [
        Colour(0.03, 0.02, 0.10),
        Colour(0.34, 0.06, 0.43),
        Colour(0.74, 0.22, 0.33),
        Colour(0.98, 0.56, 0.04),
        Colour(0.99, 0.99, 0.75),
    ];
    let position = value.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let stop = (position as usize).min(STOPS.len() - 2);
    STOPS[stop].mixed(STOPS[stop + 1], position - stop as f32)
}

/// Returns the CSS colour of a plot's line, dark enough on white.
///
/// After eight lines the hues repeat nearly, so every second group of eight is darker.
pub fn line_colour(number: usize) -> String {
    let light = [0.78, 0.4][number / 8 % 2];
    let Colour(red, green, blue) = cluster_colour(number as u32).times(light);
    let byte = |part: f32| (part.clamp(0.0, 1.0) * 255.0) as u8;
    format!("#{:02x}{:02x}{:02x}", byte(red), byte(green), byte(blue))
}
