//! Counter-based random numbers, which do not depend on the order of computation.
//!
//! The problem: several threads shoot photons in any order, and the result must not depend on the order. The idea:
//! there is no shared state. A random number is a function of the seed, the photon's number, and the count of the
//! photon's earlier draws:
//!
//! ```text
//! counter = (draw / 4: 64 bits, photon: 64 bits)   key = seed: 64 bits
//! Philox4x32-10(counter, key) = 4 numbers of 32 bits
//! ```
//!
//! # Source
//! J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, *Parallel Random Numbers: As Easy as 1, 2, 3*, 2011, section
//! 3.3. The test vectors are those published with it (Random123, `kat_vectors`).

use super::lanes::LANES;

/// Multipliers of the two halves (section 3.3, table 2).
const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
/// Increments of the key after each round: the fractions of the golden ratio and of the square root of 3.
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
/// Number of rounds: the paper's recommendation. 7 rounds pass all tests; 10 leave a margin.
const ROUND_COUNT: u32 = 10;

/// Computes the bijection Philox4x32-10 of a 128-bit counter under a 64-bit key.
pub fn philox4x32(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let [mut c0, mut c1, mut c2, mut c3] = counter;
    let [mut k0, mut k1] = key;
    for _ in 0..ROUND_COUNT {
        let left = u64::from(MULTIPLIERS[0]) * u64::from(c0);
        let right = u64::from(MULTIPLIERS[1]) * u64::from(c2);
        (c0, c2) = ((right >> 32) as u32 ^ c1 ^ k0, (left >> 32) as u32 ^ c3 ^ k1);
        (c1, c3) = (right as u32, left as u32);
        k0 = k0.wrapping_add(WEYL[0]);
        k1 = k1.wrapping_add(WEYL[1]);
    }
    [c0, c1, c2, c3]
}

/// Computes [`philox4x32`] in lanes: replaces the counter of each lane by its numbers.
///
/// A word is the low half of a lane of 64 bits, and the high half is arbitrary. So a product needs no shuffles: SSE2
/// and AVX2 multiply the low halves of such lanes.
#[inline(always)]
pub(super) fn philox_lanes(words: &mut [[u64; LANES]; 4], key: [u32; 2]) {
    const LOW: u64 = u32::MAX as u64;
    let [words0, words1, words2, words3] = words;
    for lane in 0..LANES {
        let (mut c0, mut c1) = (words0[lane], words1[lane]);
        let (mut c2, mut c3) = (words2[lane], words3[lane]);
        let [mut k0, mut k1] = key;
        for _ in 0..ROUND_COUNT {
            let left = u64::from(MULTIPLIERS[0]) * (c0 & LOW);
            let right = u64::from(MULTIPLIERS[1]) * (c2 & LOW);
            (c0, c2) = (right >> 32 ^ c1 ^ u64::from(k0), left >> 32 ^ c3 ^ u64::from(k1));
            (c1, c3) = (right, left);
            k0 = k0.wrapping_add(WEYL[0]);
            k1 = k1.wrapping_add(WEYL[1]);
        }
        (words0[lane], words1[lane], words2[lane], words3[lane]) = (c0, c1, c2, c3);
    }
}

/// Sequence of one photon's random numbers.
///
/// # Examples
/// ```
/// use arboleda_host::photon::PhotonRandom;
/// let mut random = PhotonRandom::new(1, 42);
/// let first = random.uniform();
/// assert!((0.0..1.0).contains(&first));
/// assert_eq!(PhotonRandom::new(1, 42).uniform(), first);
/// ```
#[derive(Clone, Debug)]
pub struct PhotonRandom {
    key: [u32; 2],
    place: Place,
}

/// Place in the sequence of one photon's random numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub photon: u64,
    /// Number of draws so far.
    pub draw_count: u64,
    /// Block that contains the next draw.
    pub block: [u32; 4],
}

impl Place {
    /// Returns what [`PhotonRandom::uniform`] will draw next.
    #[inline]
    pub fn next_uniform(&self) -> f32 {
        uniform(self.block[self.draw_count as usize % 4])
    }

    /// Computes the block that contains the next draw.
    pub fn compute_block(&mut self, key: [u32; 2]) {
        let ([c0, c1], [c2, c3]) = (halves(self.draw_count / 4), halves(self.photon));
        self.block = philox4x32([c0, c1, c2, c3], key);
    }
}

impl PhotonRandom {
    /// Begins the sequence of a photon.
    pub fn new(seed: u64, photon: u64) -> Self {
        let mut place = Place { photon, draw_count: 0, block: [0; 4] };
        place.compute_block(halves(seed));
        Self::at(seed, place)
    }

    /// Continues the sequence of a photon.
    #[inline]
    pub(super) fn at(seed: u64, place: Place) -> Self {
        Self { key: halves(seed), place }
    }

    /// Returns the place in the sequence.
    #[inline]
    pub(super) fn place(&self) -> &Place {
        &self.place
    }

    /// Draws 32 random bits.
    #[inline]
    pub fn bits(&mut self) -> u32 {
        let bits = self.place.block[self.place.draw_count as usize % 4];
        self.place.draw_count += 1;
        if self.place.draw_count.is_multiple_of(4) {
            self.place.compute_block(self.key);
        }
        bits
    }

    /// Draws one of the 2^24 multiples of 2^-24 in `0 <= x < 1`, with equal probability. Each is an `f32`.
    #[inline]
    pub fn uniform(&mut self) -> f32 {
        uniform(self.bits())
    }
}

#[inline]
fn uniform(bits: u32) -> f32 {
    const STEP: f32 = 1.0 / (1 << 24) as f32;
    (bits >> 8) as f32 * STEP
}

/// Splits a number into its low and its high half.
#[inline]
pub(super) fn halves(whole: u64) -> [u32; 2] {
    [whole as u32, (whole >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_vectors() {
        let ones = u32::MAX;
        let known = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([ones; 4], [ones; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, expected) in known {
            assert_eq!(philox4x32(counter, key), expected);
        }
    }

    #[test]
    fn lanes_compute_the_same_blocks() {
        let mut random = PhotonRandom::new(2, 0);
        let counters = [(); 4].map(|()| [(); LANES].map(|()| random.bits()));
        let key = [random.bits(), random.bits()];
        // The high halves are arbitrary.
        let wide = counters.map(|word| word.map(|low| 0xffff_fffe_0000_0000 | u64::from(low)));
        let mut words = wide;
        philox_lanes(&mut words, key);
        for lane in 0..LANES {
            let block = philox4x32(counters.map(|word| word[lane]), key);
            assert_eq!(words.map(|word| word[lane] as u32), block);
        }
    }

    #[test]
    fn a_draw_is_a_function_of_seed_photon_and_index() {
        let (seed, photon) = (0x0123_4567_89ab_cdef, 0xfedc_ba98_7654_3210);
        let mut random = PhotonRandom::new(seed, photon);
        for draw in 0..40_u32 {
            let counter = [draw / 4, 0, 0x7654_3210, 0xfedc_ba98];
            let block = philox4x32(counter, [0x89ab_cdef, 0x0123_4567]);
            assert_eq!(random.bits(), block[draw as usize % 4]);
        }
    }

    #[test]
    fn uniform_has_the_moments_of_the_uniform_distribution() {
        let count = 400_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for photon in 0..count / 4 {
            let mut random = PhotonRandom::new(7, photon);
            for _ in 0..4 {
                let x = f64::from(random.uniform());
                assert!((0.0..1.0).contains(&x));
                sum += x;
                squares += x * x;
            }
        }
        let count = count as f64;
        // Standard deviations: sqrt(1/12) = 0.289 of x and sqrt(4/45) = 0.298 of its square.
        let sigma = 1.0 / count.sqrt();
        assert!((sum / count - 0.5).abs() < 4.0 * 0.289 * sigma);
        assert!((squares / count - 1.0 / 3.0).abs() < 4.0 * 0.298 * sigma);
    }
}
