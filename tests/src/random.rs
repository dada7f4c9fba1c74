//! Random number generator that works on integers only, so scenes are the same on every target.
//!
//! # Source
//! SplitMix64: G. L. Steele, D. Lea, C. H. Flood, *Fast Splittable Pseudorandom Number Generators*, 2014.

use arboleda::Vec3;

/// Stream of random numbers, a function of its seed.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Starts a stream.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Draws 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Draws a number below `limit`; 0 if `limit` is 0.
    pub fn below(&mut self, limit: usize) -> usize {
        (((self.bits() >> 32) * limit as u64) >> 32) as usize
    }

    /// Draws a whole number in `lo..=hi`.
    pub fn whole(&mut self, lo: i32, hi: i32) -> i32 {
        lo + self.below((hi - lo + 1) as usize) as i32
    }

    /// Returns true with probability 1 in `n`.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// Draws one of the values.
    pub fn pick<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// Draws a multiple of 2^-24 in `0..1`.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// Draws a multiple of 2^-23 in `-1..1`.
    pub fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    /// Draws a point of the cube from -1 to 1.
    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    /// Draws a point with whole coordinates in `-reach..=reach`.
    pub fn lattice(&mut self, reach: i32) -> Vec3 {
        let mut whole = || self.whole(-reach, reach) as f32;
        Vec3::new(whole(), whole(), whole())
    }

    /// Draws a number of either sign, with a binary exponent in `lo..=hi`.
    pub fn magnitude(&mut self, lo: i32, hi: i32) -> f32 {
        let exponent = self.whole(lo, hi);
        let sign = if self.once_in(2) { -1.0 } else { 1.0 };
        (sign * (1.0 + f64::from(self.unit())) * power_of_two(exponent)) as f32
    }

    /// Shuffles a slice.
    pub fn shuffle<T>(&mut self, values: &mut [T]) {
        for last in (1..values.len()).rev() {
            values.swap(last, self.below(last + 1));
        }
    }
}

/// Computes 2 to the power of `exponent`, which lies in -1022..=1023. The result is exact, unlike that of `powi` on
/// some targets.
pub fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}
