//! Digest of a shot, by which shots are compared.

use std::fmt;

/// BLAKE3 hash of all hits of a shot. It is the same for every index, thread count and machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Digest(pub [u8; 32]);

impl fmt::Display for Digest {
    /// Writes the first 16 hexadecimal digits, enough to compare by eye.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0[..8].iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shows_sixteen_digits() {
        let digest = Digest(*blake3::hash(b"").as_bytes());
        assert_eq!(digest.to_string(), "af1349b9f5f9a1a6");
    }
}
