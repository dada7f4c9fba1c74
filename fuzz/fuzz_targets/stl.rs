//! STL files that nobody wrote, as text and binary.
//!
//! Workload: any bytes, with the words of the format from a dictionary.
//! Constraints: none. An error, or triangles as [`becomes_triangles`] wants them; memory in proportion to the
//! input, which libFuzzer's limits watch.
#![no_main]

use std::path::Path;

use arboleda_fuzz::surfaces::becomes_triangles;
use arboleda_host::scene::formats::stl;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(surface) = stl::read(bytes, Path::new("input.stl")) {
        becomes_triangles(&surface);
    }
});
