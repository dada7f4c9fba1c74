//! Work of a caller, compiled for the instructions of each SIMD level.
//!
//! The problem: a program that is compiled for every processor of its architecture has loops in the oldest vector
//! instructions. The idea: the same loops once more in a function that is compiled for newer instructions, which is
//! called where the processor has them. The compiler contracts no operations, so the bits are the same.
//!
//! `unsafe` here is calling such functions, as in `indices::wide::dispatch`. What it gains is stated where it is used.
#![allow(unsafe_code, clippy::inline_always)]

use crate::input::SimdLevel;

/// Function body that is compiled once for each SIMD instruction set. [`SimdLevel::run`] calls the one for its level.
///
/// # Examples
/// ```
/// use arboleda::{SimdLevel, Work};
///
/// struct Sum<'v>(&'v [u32]);
///
/// impl Work for Sum<'_> {
///     type Output = u32;
///
///     #[inline(always)]
///     fn run(self) -> u32 {
///         self.0.iter().fold(0, |sum, &value| sum.wrapping_add(value))
///     }
/// }
///
/// assert_eq!(SimdLevel::detect().run(Sum(&[1, 2, 3])), 6);
/// ```
pub trait Work {
    /// Result of the work.
    type Output;

    /// Does the work. Only what is inlined here is compiled for the level: mark this method and the functions that it
    /// calls with `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

impl SimdLevel {
    /// Does work, compiled for the vector instructions of this level. The result is the same at every level, but
    /// for the bits of a NaN, if the work's own code is the same.
    ///
    /// # Panics
    /// If the work panics.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
        if self.has_avx512() {
            // SAFETY: `SimdLevel::detect` alone can make this true, after the processor and the system said that they
            // have AVX-512: F, VL, DQ, BW, AVX2 and FMA.
            return unsafe { x86_64::run_avx512(work) };
        } else if self.has_avx2() {
            // SAFETY: `SimdLevel::detect` alone can make this true, after the processor and the system said that they
            // have AVX2.
            return unsafe { x86_64::run_avx2(work) };
        }
        work.run()
    }
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod x86_64 {
    use super::Work;

    #[inline(never)]
    #[target_feature(enable = "avx2")]
    pub fn run_avx2<W: Work>(work: W) -> W::Output {
        work.run()
    }

    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
    pub fn run_avx512<W: Work>(work: W) -> W::Output {
        work.run()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of products, which would differ in their last bits if they were contracted.
    struct Products<'v>(&'v [f64; 64]);

    impl Work for Products<'_> {
        type Output = [u64; 64];

        #[inline(always)]
        fn run(self) -> [u64; 64] {
            let mut bits = [0; 64];
            for (bits, &value) in bits.iter_mut().zip(self.0) {
                *bits = (value * value - value).to_bits();
            }
            bits
        }
    }

    #[test]
    fn work_has_the_same_bits_at_every_level() {
        let mut values = [0.0; 64];
        for (value, number) in values.iter_mut().zip(1_u32..) {
            *value = 1.0 + 1.0 / f64::from(number);
        }
        let expected = SimdLevel::COMPILED.run(Products(&values));
        let detected = SimdLevel::detect();
        for level in [detected.without_avx512(), detected] {
            assert_eq!(level.run(Products(&values)), expected);
        }
    }
}
