//! BVH8: bounding volume hierarchies with eight children a node, tested at once by SIMD.
//!
//! | index | nodes | leaves | bytes a triangle |
//! |---|---|---|---|
//! | [`WideBvh`] | eight boxes in `f32` | hold the triangles, in eight lanes | 50 to 55 |
//! | [`CompactBvh`] | eight boxes in 16 bits a side | hold the triangles, with a table of vertices | 25 to 30 |
//! | [`LeanBvh`] | up to eight boxes in 16 bits a side | name the triangles, which lie elsewhere | 7.3 to 9.4 |
//!
//! All three are the same tree, and share build, traversal and triangle tests:
//! ```text
//! triangles --build: binned SAH, collapsed to eight--> subtrees --full | quantised: emit--> words
//! query --dispatch: instruction set--> traversal --tree: contract--> full | quantised: reader --simd--> query
//! batch --dispatch: instruction set--> wavefront --tree: contract--> full | quantised: reader --simd--> query
//! ```
//!
//! # Unsafe
//! The `unsafe` of these indices is calls of functions that are compiled for instructions which the processor may not
//! have. [`SimdLevel`](crate::SimdLevel) allows such instructions only after asking the processor.
//!
//! | module | calls | gain |
//! |---|---|---|
//! | `dispatch` | the traversal and the wavefront, compiled for AVX2 or AVX-512 | the calls of the other modules are inlined into them |
//! | [`simd`](crate::simd) | eight boxes, eight triangles, one triangle in `f64` | about a third of the time |
//! | `quantised/avx2` | unpacking of boxes and of triangles | |

// Forced, because what a traversal calls must be compiled for the instructions of its lanes, in one function with it.
#![allow(clippy::inline_always)]

mod build;
mod dispatch;
mod full;
mod quantised;
mod rows;
mod traversal;
mod tree;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod wavefront;

pub use full::WideBvh;
pub(crate) use full::{SliceError, SlicedWords, Unsorted};
pub use quantised::{CompactBvh, LeanBvh};

use crate::input::Options;

/// Bytes of scratch that a wavefront takes; 0 where there is none.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
pub(crate) const BATCH_SCRATCH: usize = wavefront::SCRATCH;
#[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
pub(crate) const BATCH_SCRATCH: usize = 0;

/// Bounds the scratch of all three indices, which have the same build; see
/// [`Structure::scratch_bytes`](crate::structure::Structure::scratch_bytes).
pub(crate) const fn scratch_bytes(triangle_count: usize, _: &Options) -> usize {
    build::scratch_bytes(triangle_count)
}
