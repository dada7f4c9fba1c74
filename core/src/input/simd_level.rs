//! Which vector instructions to use.

/// The vector instructions that queries may use. The answers and the counters are the same for all.
///
/// What the crate is compiled for is always used; a value of this type allows more, found at run time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SimdLevel {
    avx2: bool,
    avx512: bool,
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
cpufeatures::new!(avx2, "avx2");
// What the walk in `wide_bvh::avx512` is compiled for.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
cpufeatures::new!(avx512, "avx2", "avx512f", "avx512vl", "avx512dq", "avx512bw");

impl SimdLevel {
    /// Nothing beyond what the crate is compiled for.
    pub const COMPILED: Self = Self { avx2: false, avx512: false };

    /// Asks the processor, and whether the system keeps the registers.
    pub fn detect() -> Self {
        #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
        let found = Self { avx2: avx2::get(), avx512: avx512::get() };
        #[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
        let found = Self::COMPILED;
        found
    }

    /// Whether AVX2 may be used.
    pub const fn has_avx2(self) -> bool {
        self.avx2
    }

    /// Whether AVX-512 may be used: F, VL, DQ and BW.
    pub const fn has_avx512(self) -> bool {
        self.avx512
    }

    /// These, but not AVX-512.
    #[must_use]
    pub const fn without_avx512(self) -> Self {
        Self { avx512: false, ..self }
    }
}
