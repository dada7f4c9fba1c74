//! Which vector instructions to use.

/// The vector instructions that queries may use. The answers and the counters are the same for all.
///
/// What the crate is compiled for is always used; a value of this type allows more, found at run time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Vectors {
    avx2: bool,
}

#[cfg(target_arch = "x86_64")]
cpufeatures::new!(avx2, "avx2");

impl Vectors {
    /// Nothing beyond what the crate is compiled for.
    pub const COMPILED: Self = Self { avx2: false };

    /// Asks the processor.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        let found = Self { avx2: avx2::get() };
        #[cfg(not(target_arch = "x86_64"))]
        let found = Self::COMPILED;
        found
    }

    /// Whether AVX2 may be used.
    pub const fn has_avx2(self) -> bool {
        self.avx2
    }
}
