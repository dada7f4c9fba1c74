//! SIMD: tests of several boxes, or of several triangles, against one ray, and loops of callers.
//!
//! ```text
//! lanes       the trait of tests of eight, and the numbers of lanes     <- portable, avx2
//! leaf_test   the triangles that a leaf names                           <- avx2_leaf
//! candidates  what lanes leave in doubt, decided one by one
//! avx2_judge  four pairs of a ray and a triangle, in `f64`
//! avx2_ray    a ray, prepared for lanes
//! work        loops of a caller, compiled for each level
//! ```

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) mod avx2;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod avx2_judge;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod avx2_leaf;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod avx2_ray;
mod candidates;
mod lanes;
mod leaf_test;
pub(crate) mod portable;
mod work;

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) use avx2::{Avx2, Avx2 as Fastest};
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) use avx2_judge::{Quad, judge_four};
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) use avx2_ray::prepare;
pub(crate) use candidates::{decide_each, last_t};
pub(crate) use lanes::{
    Arithmetic, FAR, LANES, LEAF_ROWS, Lanes, LeafRows, NODE_ROWS, Node, Row, key,
};
pub(crate) use leaf_test::{HAS_VECTORS, test_each, test_triangles};
pub(crate) use portable::Portable;
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(crate) use portable::Portable as Fastest;
pub use work::Work;
