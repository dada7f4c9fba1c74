//! WebAssembly of `arboleda`: the functions of the C interface, and some that show what an index looks like.
//!
//! ```text
//! page --typed arrays--> js/arboleda.js --addresses, lengths--> arboleda-ffi --> arboleda
//!                                       \---------------------> this crate ----^
//! ```
//! - The memory is the page's: JavaScript makes it, grows it, and decides what lies where. Nothing is allocated here.
//! - [`clusters`] and [`octree`] are what the C interface has no need for: the clusters, the cluster tree, the cells of
//!   an octree, and the way of a ray through it. They write records of words, of 32 bits each.
//!
//! # Safety
//! The promise is that of the C interface: memory of the stated length lies at an address. `js/` keeps it.
#![no_std]
// Of blocks, only those that take the promise; a test counts them.
#![allow(unsafe_code, clippy::missing_safety_doc)]

pub mod clusters;
pub mod octree;
mod records;

pub use arboleda_ffi;

/// Tells whether the module was built with simd128, and so whether it runs only where there is simd128.
#[unsafe(no_mangle)]
pub extern "C" fn arb_uses_simd128() -> bool {
    cfg!(target_feature = "simd128")
}
