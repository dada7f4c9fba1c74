//! C interface of `arboleda`. C programs read `include/arboleda.h`, which is generated from the comments of this crate.
//!
//! ```text
//! pointers, lengths --memory--> slices --> arboleda --> status, arb_error
//! ```
//! - `memory` checks pointers and lengths, and turns them into references. All other code is safe.
//! - Each exported function begins by taking the caller's promise, `memory::Caller`, and ends with a status.
//! - Names are those of the header, so that a reader of one finds them in the other.
//!
//! # Safety
//! One promise holds for all exported functions, and the header begins with it: a pointer is null, or memory of the
//! stated length lies there, which no other thread writes to during the call. Null pointers, misaligned pointers,
//! lengths that no memory has and outputs that overlap other arguments are errors.
//!
//! A build that takes several calls lies in its scratch between them, with references to the caller's memory whose
//! lifetime no compiler sees. So until it is over, nobody else reads or writes that scratch and the memory of the index,
//! and the arrays of the mesh stay as they are. It holds no reference into itself. A mark and its own address are checked
//! at each call, so that a build that was never begun, is over, or was copied elsewhere is an error.
//!
//! No panic is reachable; `.ci/run no_panic` proves it by linking, as for the core.
#![no_std]
// The names of the header.
#![allow(non_camel_case_types, clippy::enum_variant_names)]
// Of blocks, only in `memory`, and for the promise above; a test counts them.
#![allow(unsafe_code, clippy::missing_safety_doc)]

mod abi;
mod batch;
mod error;
mod index;
mod kind;
mod memory;
mod options;
#[cfg(feature = "panic-handler")]
mod panic_handler;
mod query;
mod scene;

pub use abi::{ARB_ABI_VERSION, arb_abi_version, arb_check_abi};
pub use batch::{arb_batch_scratch_bytes, arb_closest_each, arb_occluded_each};
pub use error::{ARB_MESSAGE_BYTES, arb_error, arb_status, arb_status_text};
pub use index::{
    ARB_ALIGNMENT, ARB_INDEX_WORDS, arb_build, arb_capacity, arb_close, arb_describe,
    arb_description, arb_index, arb_measure, arb_open, arb_piece, arb_piecewise_begin,
    arb_piecewise_build, arb_piecewise_join, arb_piecewise_next, arb_piecewise_scratch_bytes,
    arb_scratch_bytes, arb_sliced_begin, arb_sliced_build, arb_sliced_finish,
    arb_sliced_scratch_bytes, arb_sliced_step,
};
pub use kind::{arb_kind, arb_kind_name};
pub use options::{
    ARB_AUTOMATIC, ARB_BVH_BINNED, ARB_BVH_INSERTION, ARB_CELLS, ARB_CELLS_PER_TRIANGLE,
    ARB_RESOLUTION_AUTOMATIC, arb_options, arb_options_default,
};
pub use query::{
    ARB_NO_TRIANGLE, arb_all_hits, arb_check_ray, arb_closest, arb_closest_counted, arb_counters,
    arb_hit, arb_occluded, arb_occluded_counted, arb_ray,
};
pub use scene::arb_mesh;

/// Parts of which a package makes more functions in the manner of these, as `core/wasm` does. No part of the interface,
/// and not covered by its version.
#[doc(hidden)]
pub mod parts {
    pub use crate::error::{Failure, reported, status_of};
    pub use crate::memory::{Caller, Input, Output, Region, apart, borrowed};
    pub use crate::options::{Chosen, chosen};
    pub use crate::scene::Arrays;
}
