//! Random numbers without a state: each number is a function of the seed, the object and the number's position.
//!
//! The shape of a building therefore does not depend on how many numbers other buildings draw.
//!
//! # Source
//! The mixing function of splitmix64: G. Steele, D. Lea, C. Flood, *Fast Splittable Pseudorandom Number
//! Generators*, 2014; its constants are theirs.

/// Random numbers of one object, such as one building.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws {
    key: u64,
}

impl Draws {
    /// Creates the numbers of object `index` of a scene with this seed.
    pub fn new(seed: u64, index: u64) -> Self {
        Self { key: mixed(mixed(seed).wrapping_add(index)) }
    }

    /// Returns number `nth`: a multiple of 2^-24 in `0..1`.
    pub fn unit(self, nth: u64) -> f32 {
        (mixed(self.key.wrapping_add(nth)) >> 40) as f32 / 16_777_216.0
    }

    /// Returns number `nth`, from `low` to `high`.
    pub fn between(self, nth: u64, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit(nth)
    }

    /// Returns number `nth` as a whole number below `count`; 0 if `count` is 0.
    pub fn below(self, nth: u64, count: u32) -> u32 {
        ((u64::from(count) * (mixed(self.key.wrapping_add(nth)) >> 32)) >> 32) as u32
    }
}

fn mixed(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ value >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_number_is_the_published_one() {
        // The first output of splitmix64 from state 0.
        assert_eq!(mixed(0), 0xe220_a839_7b1d_cdaf);
    }

    #[test]
    fn numbers_stay_in_range_and_cover_it() {
        let draws = Draws::new(7, 3);
        let units: Vec<f32> = (0..1000).map(|nth| draws.unit(nth)).collect();
        assert!(units.iter().all(|unit| (0.0..1.0).contains(unit)));
        assert!(units.iter().any(|&unit| unit < 0.01) && units.iter().any(|&unit| unit > 0.99));
        for value in 0..5 {
            assert!((0..1000).any(|nth| draws.below(nth, 5) == value));
        }
        assert!((0..1000).all(|nth| draws.below(nth, 5) < 5));
        assert_eq!(draws.below(0, 0), 0);
    }
}
