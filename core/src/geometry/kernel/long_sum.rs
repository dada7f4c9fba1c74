//! Exact sums of products of `f32`, however large and small they are, as one long fixed-point number.
//!
//! ```text
//! 2^554 ............ 2^0 ............ 2^-597        1,152 bits in two's complement, 18 words, the lowest first
//! ```
//!
//! # Why everything fits
//! A finite `f32` is a mantissa below 2^24 times 2^(exponent - 149), the exponent from 0 to 253. A term is the
//! product of three of them and of a [`Factor`], a mantissa below 2^25 times 2^(exponent - 150), the exponent from 0
//! to 253 too. So a term is a whole number below 2^97 times a power of two from 2^-597 to 2^(1012 - 597), and the
//! sum of up to 64 of them lies below 2^(1012 + 97 + 6 - 597) = 2^518; one bit is the sign. Nothing is rounded, lost
//! or carried out of the highest word.
//!
//! # Source
//! U. Kulisch, *Computer Arithmetic and Validity*, 2008: the long accumulator.
//!
//! # What lost
//! - Expansions (J. R. Shewchuk 1997): at worst 288 terms of 8 bytes, several times.

use core::ops::Neg;

use super::lattice::{decoded, factored};

/// The exponent of the lowest bit of a sum.
const LOWEST: i32 = -597;
const WORDS: usize = 18;

/// One of the `f32` of a term.
#[derive(Clone, Copy)]
pub(super) struct Number {
    mantissa: u64,
    /// The exponent, counted from that of the lowest bit there is.
    place: u32,
    negative: bool,
}

impl From<f32> for Number {
    fn from(value: f32) -> Self {
        let (mantissa, exponent) = decoded(value);
        Self { mantissa: u64::from(mantissa), place: exponent - 1, negative: value < 0.0 }
    }
}

/// The factor of all products of a triple product: an `f64` of at most 25 bits, a multiple of 2^-150 up to 2^128.
#[derive(Clone, Copy)]
pub(super) struct Factor(Number);

impl Factor {
    /// No change.
    pub const ONE: Self = Self(Number { mantissa: 1, place: 150, negative: false });

    /// The factor of a value.
    pub fn of(value: f64) -> Self {
        let (whole, exponent) = factored(value);
        debug_assert!(exponent >= -150, "no factor: {value}");
        Self(Number {
            mantissa: whole.unsigned_abs(),
            place: (exponent + 150).max(0) as u32,
            negative: whole < 0,
        })
    }
}

impl Neg for Factor {
    type Output = Self;

    fn neg(self) -> Self {
        Self(Number { negative: !self.0.negative, ..self.0 })
    }
}

/// The exact sum of up to 64 terms.
pub(super) struct LongSum {
    words: [u64; WORDS],
}

impl LongSum {
    /// No terms yet.
    pub const ZERO: Self = Self { words: [0; WORDS] };

    /// Adds `factor * p . (q x r)`: six terms.
    #[inline(never)]
    pub fn add_triple(&mut self, factor: Factor, p: &[f32; 3], q: &[f32; 3], r: &[f32; 3]) {
        for (i, &p) in p.iter().enumerate() {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.add_term(factor, [p, q[j], r[k]]);
            self.add_term(-factor, [p, q[k], r[j]]);
        }
    }

    fn add_term(&mut self, factor: Factor, term: [f32; 3]) {
        let ([x, y, z], factor) = (term.map(Number::from), factor.0);
        // 48 and 49 bits, and the product 97.
        let (left, right) = (x.mantissa * y.mantissa, z.mantissa * factor.mantissa);
        let magnitude = u128::from(left) * u128::from(right);
        if magnitude == 0 {
            return;
        }
        let place = x.place + y.place + z.place + factor.place;
        let negative = x.negative ^ y.negative ^ z.negative ^ factor.negative;

        let shift = place % u64::BITS;
        let low = magnitude << shift;
        let high = (magnitude >> 1) >> (u128::BITS - 1 - shift);
        let mut parts = [low as u64, (low >> u64::BITS) as u64, high as u64].into_iter();
        let mut carried = false;
        for word in self.words.iter_mut().skip((place / u64::BITS) as usize) {
            let part = match parts.next() {
                Some(part) => part,
                None if carried => 0,
                None => break,
            };
            let (sum, first, second);
            if negative {
                (sum, first) = word.overflowing_sub(part);
                (*word, second) = sum.overflowing_sub(u64::from(carried));
            } else {
                (sum, first) = word.overflowing_add(part);
                (*word, second) = sum.overflowing_add(u64::from(carried));
            }
            carried = first || second;
        }
    }

    fn is_negative(&self) -> bool {
        self.words[WORDS - 1] >> (u64::BITS - 1) != 0
    }

    /// The sign of the sum: -1, 0 or 1.
    pub fn sign(&self) -> i32 {
        if self.is_negative() { -1 } else { i32::from(self.words.iter().any(|&word| word != 0)) }
    }

    /// The sum rounded: off by less than 2^-51 of it.
    ///
    /// The highest word of the magnitude that is not 0 and the two words below hold at least 129 bits; the rest is less
    /// than 2^-128 of the magnitude. Words are rounded to 53 bits, and so are the two sums: less than 4 * 2^-53 in all.
    pub fn estimate(&self) -> f64 {
        const WORD: f64 = 18_446_744_073_709_551_616.0; // 2^64
        let negative = self.is_negative();
        let mut borrowed = negative;
        // The three words of the magnitude up to the highest that is not 0, and where the lowest begins.
        let (mut low, mut middle, mut high, mut place) = (0, 0, 0, LOWEST);
        let (mut below, mut below_that) = (0, 0);
        let mut begin = LOWEST - 2 * u64::BITS.cast_signed();
        for &word in &self.words {
            let magnitude = if negative {
                let (magnitude, carried) = (!word).overflowing_add(u64::from(borrowed));
                borrowed = carried;
                magnitude
            } else {
                word
            };
            if magnitude != 0 {
                (low, middle, high, place) = (below_that, below, magnitude, begin);
            }
            (below_that, below) = (below, magnitude);
            begin += u64::BITS.cast_signed();
        }
        let sum = (high as f64 * WORD + middle as f64) * WORD + low as f64;
        let size = sum * power_of_two(place);
        if negative { -size } else { size }
    }
}

/// `2^exponent`, a normal number.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f32; 3] = [1.0, 0.0, 0.0];
    const Y: [f32; 3] = [0.0, 1.0, 0.0];

    fn sum_of(terms: &[(f64, [f32; 3])]) -> LongSum {
        let mut sum = LongSum::ZERO;
        for (factor, z) in terms {
            sum.add_triple(Factor::of(*factor), &X, &Y, z);
        }
        sum
    }

    #[test]
    fn a_sum_keeps_what_f64_loses() {
        let (least, most) = (f32::from_bits(1), f32::MAX);
        let z = |z: f32| [0.0, 0.0, z];
        let sum = sum_of(&[(1.0, z(most)), (1.0, z(least)), (-1.0, z(most))]);
        assert_eq!((sum.sign(), sum.estimate()), (1, f64::from(least)));
        let sum = sum_of(&[(-1.0, z(most)), (-1.0, z(least)), (1.0, z(most))]);
        assert_eq!((sum.sign(), sum.estimate()), (-1, -f64::from(least)));
        let sum = sum_of(&[(3.0, z(least)), (1.5, z(-least)), (-1.5, z(least))]);
        assert_eq!((sum.sign(), sum.estimate()), (0, 0.0));
    }

    /// The lowest bit, and the largest sum there can be.
    #[test]
    fn the_smallest_and_the_largest_terms_fit() {
        let (least, most) = ([f32::from_bits(1); 3], [f32::MAX; 3]);
        let [half, beyond] = [power_of_two(-150), power_of_two(128) - power_of_two(103)];
        let mut sum = LongSum::ZERO;
        sum.add_term(Factor::of(half), least);
        assert_eq!((sum.sign(), sum.estimate()), (1, power_of_two(LOWEST)));
        sum.add_term(Factor::of(-half), least);
        assert_eq!(sum.sign(), 0);
        for _ in 0..64 {
            sum.add_term(Factor::of(beyond), most);
        }
        let all = 64.0 * beyond * f64::from(f32::MAX).powi(3);
        assert_eq!(sum.sign(), 1);
        assert!((sum.estimate() / all - 1.0).abs() < 1e-15);
        for _ in 0..128 {
            sum.add_term(-Factor::of(beyond), most);
        }
        assert_eq!(sum.sign(), -1);
        assert!((sum.estimate() / all + 1.0).abs() < 1e-15);
    }
}
