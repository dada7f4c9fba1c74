//! Tone: from radiance to the 256 levels of a screen.
//!
//! Levels are those of sRGB. They are found by comparison with 255 thresholds, which `libm` computes, so a level is the
//! same on every machine.
//!
//! # Source
//! IEC 61966-2-1, for the curve.

use std::sync::LazyLock;

use crate::render::film::Film;

/// Smallest linear values of the levels 1, 2, ... 255.
static THRESHOLDS: LazyLock<[f32; 255]> =
    LazyLock::new(|| std::array::from_fn(|level| linear((level as f64 + 0.5) / 255.0) as f32));

/// Computes the linear value of a value of sRGB, 0 to 1.
fn linear(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

/// Converts a linear value to a level of sRGB. Values above 1 are cut off; NaN is 0.
pub fn to_srgb(value: f32) -> u8 {
    THRESHOLDS.partition_point(|&threshold| threshold <= value) as u8
}

/// Share of the pixels that an automatic exposure makes at most white.
const NOT_BRIGHTER: f64 = 0.99;

/// Computes the automatic exposure of a picture: 1 over the 99th percentile of the reflected radiance, of which the
/// largest channel counts. Only pixels with surfaces count, and none that emit, as those are far brighter than what
/// they light. The exposure of a dark picture is 1.
pub fn exposure_of(film: &Film) -> f32 {
    let largest = |[red, green, blue]: [f32; 3]| red.max(green).max(blue);
    let hit = film.pixels().iter().filter(|pixel| pixel.is_hit() && pixel.emitted == [0.0; 3]);
    let white = percentile(hit.map(|pixel| largest(pixel.reflected)).collect(), NOT_BRIGHTER);
    if white > 0.0 { 1.0 / white } else { 1.0 }
}

/// Returns the value below which a share of the values lies; 0 without values.
pub(super) fn percentile(mut values: Vec<f32>, share: f64) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() - 1) as f64 * share) as usize;
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_the_nearest_of_srgb() {
        for level in 0..=255_u8 {
            assert_eq!(to_srgb(linear(f64::from(level) / 255.0) as f32), level);
        }
        for (value, level) in [
            (f32::NEG_INFINITY, 0),
            (-1.0, 0),
            (f32::NAN, 0),
            (0.0, 0),
            (0.2140, 127),
            (0.2142, 128),
            (1.0, 255),
            (f32::INFINITY, 255),
        ] {
            assert_eq!(to_srgb(value), level, "{value}");
        }
    }

    #[test]
    fn percentiles_are_values_of_the_list() {
        assert_eq!(percentile(vec![], 0.99), 0.0);
        assert_eq!(percentile(vec![3.0], 0.99), 3.0);
        assert_eq!(percentile((0..=100).rev().map(|x| x as f32).collect(), 0.99), 99.0);
    }
}
