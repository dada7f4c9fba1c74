//! Records of words that are written for JavaScript.

use arboleda::Vec3;

/// Word that stands for what is not there.
pub const NONE: u32 = u32::MAX;

/// Room for records of `N` words. Those that find no room are counted only.
pub struct Records<'a, const N: usize> {
    room: &'a mut [u32],
    count: usize,
}

impl<'a, const N: usize> Records<'a, N> {
    pub fn new(room: &'a mut [u32]) -> Self {
        Self { room, count: 0 }
    }

    /// Writes a record.
    pub fn push(&mut self, record: [u32; N]) {
        let room = self.room.get_mut(self.count.saturating_mul(N)..).unwrap_or_default();
        if room.len() >= N {
            for (slot, word) in room.iter_mut().zip(record) {
                *slot = word;
            }
        }
        self.count = self.count.saturating_add(1);
    }

    /// The number of records, with those that found no room.
    pub fn count(&self) -> usize {
        self.count
    }
}

/// The bits of a box: the lower corner, then the upper.
pub fn bits_of(lo: Vec3, hi: Vec3) -> [u32; 6] {
    let ([a, b, c], [d, e, f]) = (lo.to_array(), hi.to_array());
    [a, b, c, d, e, f].map(f32::to_bits)
}
