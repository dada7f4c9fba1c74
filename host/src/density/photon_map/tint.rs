//! Colour of a photon in 32 bits: three mantissas of 9 bits and an exponent that they share.
//!
//! A weight of 1 is exact. Other weights are rounded at random, up with the probability of the remainder, so that sums
//! have the right mean. The random numbers are a function of the photon's rank.
//!
//! # Source
//! Shared exponents: G. Ward, *Real Pixels*, Graphics Gems II, 1991; the 9-9-9-5 bits are those of OpenGL's `RGB9_E5`.

use crate::photon::PhotonRandom;

/// Bits of a mantissa.
const BITS: u32 = 9;
const MOST: u32 = (1 << BITS) - 1;
/// Exponent bits of the smallest step, 2^-24: the bias 127 less 24.
const LEAST_STEP_BITS: u32 = 127 - 24;
/// Largest weight: 511 times 2^7.
const LARGEST: f32 = 65_408.0;

/// Encodes the weights of a photon.
pub fn encoded(weights: [f32; 3], rank: u32) -> u32 {
    let weights = weights.map(|weight| weight.clamp(0.0, LARGEST));
    let largest = weights[0].max(weights[1]).max(weights[2]);
    // The smallest step of which the largest weight has at most 511, also if it is rounded up.
    let mut exponent = 0;
    while exponent < 31 && largest > step(exponent) * (MOST - 1) as f32 {
        exponent += 1;
    }
    let mut random = PhotonRandom::new(u64::from(rank), 0);
    let mut word = exponent;
    for (place, weight) in (0..).zip(weights) {
        let steps = weight / step(exponent);
        let whole = steps as u32;
        let rest = steps - whole as f32;
        // A draw is below 1, and not below a rest of 0.
        let up = rest > 0.0 && random.uniform() < rest;
        let mantissa = (whole + u32::from(up)).min(MOST);
        word |= mantissa << (5 + BITS * place);
    }
    word
}

/// Decodes the weights of a photon.
#[inline]
pub fn decoded(word: u32) -> [f32; 3] {
    let step = step(word & 31);
    [0, 1, 2].map(|place| (word >> (5 + BITS * place) & MOST) as f32 * step)
}

/// Returns 2^(exponent - 24), by its bits.
#[inline]
fn step(exponent: u32) -> f32 {
    f32::from_bits((exponent + LEAST_STEP_BITS) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_exact_and_other_weights_are_right_on_average() {
        for exact in [[1.0; 3], [0.0; 3], [0.5, 2.0, 0.0], [65_280.0, 0.0, 0.0]] {
            assert_eq!(decoded(encoded(exact, 7)), exact);
        }
        for weights in [[2.649, 0.273, 0.0789], [1e-3, 0.7, 0.299], [3e4, 1.0, 0.0]] {
            let (count, mut sums) = (20_000, [0.0_f64; 3]);
            for rank in 0..count {
                for (sum, weight) in sums.iter_mut().zip(decoded(encoded(weights, rank))) {
                    *sum += f64::from(weight);
                }
            }
            let largest = f64::from(weights.into_iter().fold(0.0, f32::max));
            for (sum, weight) in sums.into_iter().zip(weights) {
                // A step is at most 1/255 of the largest weight; a rounding has a deviation of half a step or less.
                let sigma = 0.5 * largest / 255.0 / f64::from(count).sqrt();
                let error = (sum / f64::from(count) - f64::from(weight)).abs();
                assert!(error < 4.0 * sigma, "{weights:?} {error} {sigma}");
            }
        }
        assert_eq!(decoded(encoded([f32::NAN, f32::INFINITY, -1.0], 0))[1..], [LARGEST, 0.0]);
    }
}
