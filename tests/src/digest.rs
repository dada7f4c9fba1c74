//! Digest by which answers are compared across targets.
//!
//! # Source
//! FNV-1a, 64 bits: G. Fowler, L. C. Noll, K.-P. Vo, *The FNV Non-Cryptographic Hash Algorithm*.

use arboleda::{AllHits, Hit};

/// Running digest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    /// Adds a number, lowest byte first, independent of the machine's byte order.
    pub fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Adds index bytes. All their fields are 32 bits wide, and are added as numbers, so machines of either byte order
    /// agree.
    ///
    /// # Panics
    /// If the length is not a multiple of 4.
    pub fn index_bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<4>();
        assert!(rest.is_empty(), "index bytes are 32-bit fields");
        for word in words {
            self.word(u32::from_ne_bytes(*word));
        }
    }

    /// Adds a hit, bit for bit.
    pub fn hit(&mut self, hit: &Hit) {
        self.word(hit.triangle.0);
        for number in [hit.t, hit.u, hit.v] {
            self.word(number.to_bits());
        }
    }

    /// Adds a closest hit or a miss.
    pub fn closest(&mut self, hit: Option<Hit>) {
        self.word(u32::from(hit.is_some()));
        hit.iter().for_each(|hit| self.hit(hit));
    }

    /// Adds a list of hits.
    pub fn all(&mut self, all: &AllHits<'_>) {
        self.word(all.hits.len() as u32);
        self.word(u32::from(all.truncated));
        all.hits.iter().for_each(|hit| self.hit(hit));
    }
}
