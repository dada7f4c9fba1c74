//! SIMD level: the vector instructions that queries and builds may use.

/// Set of vector instructions that queries, builds and a caller's [`Work`](crate::Work) may use beyond those that the
/// crate is compiled for.
///
/// Answers and counters are the same at every level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SimdLevel {
    avx2: bool,
    avx512: bool,
}

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
cpufeatures::new!(avx2, "avx2");
// The instruction sets that `wide::dispatch` and `simd::work` are compiled for. AVX-512 F has AVX2 and FMA with it for the
// compiler. It has F16C, too, which only code with 16-bit floats would use.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
cpufeatures::new!(avx512, "avx2", "fma", "avx512f", "avx512vl", "avx512dq", "avx512bw");

impl SimdLevel {
    /// The level that allows nothing beyond what the crate is compiled for.
    pub const COMPILED: Self = Self { avx2: false, avx512: false };

    /// Detects what the processor has and the operating system supports. Cost: the answer is cached after the first
    /// call.
    pub fn detect() -> Self {
        #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
        let found = Self { avx2: avx2::get(), avx512: avx512::get() };
        #[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
        let found = Self::COMPILED;
        found
    }

    /// Tells whether AVX2 may be used.
    pub const fn has_avx2(self) -> bool {
        self.avx2
    }

    /// Tells whether AVX-512 (F, VL, DQ and BW) may be used.
    pub const fn has_avx512(self) -> bool {
        self.avx512
    }

    /// The same level without AVX-512.
    #[must_use]
    pub const fn without_avx512(self) -> Self {
        Self { avx512: false, ..self }
    }
}
