//! Random PLY files, text and binary.
//!
//! Workload: any bytes, with the keywords of the format from a dictionary.
//!
//! Constraints: an error, or a surface that passes [`becomes_triangles`]; memory in proportion to the input, which
//! libFuzzer's limits check.
#![no_main]

use std::path::Path;

use arboleda_fuzz::surfaces::becomes_triangles;
use arboleda_host::scene::formats::ply;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(surface) = ply::read(bytes, Path::new("input.ply")) {
        becomes_triangles(&surface);
    }
});
