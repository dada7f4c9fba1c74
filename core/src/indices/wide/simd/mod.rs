//! SIMD: tests of eight boxes, or of eight triangles, against one ray.

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) mod avx2;
mod lanes;
pub(crate) mod portable;

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) use avx2::{Avx2, Avx2 as Fastest};
pub(crate) use lanes::{Candidates, FAR, LaneRay, Lanes, PreparedRay, key};
pub(crate) use portable::Portable;
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(crate) use portable::Portable as Fastest;
