//! SIMD: tests of eight boxes, or of eight triangles, against one ray.

// Inlining is forced: these functions must be compiled for the instructions of the traversal, not called from it.
#![allow(clippy::inline_always)]

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) mod avx2;
mod lanes;
pub(crate) mod portable;

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) use avx2::Avx2;
pub(crate) use lanes::{Candidates, FAR, LaneRay, Lanes, PreparedRay, key};
pub(crate) use portable::Portable;
