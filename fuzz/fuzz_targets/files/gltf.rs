//! Random glTF documents, as text and as binary files.
//!
//! Workload: any bytes, with the keywords of the format from a dictionary. Every buffer file that a document names has
//! the same bytes, so that accessors have something to read.
//!
//! Constraints: an error, or a surface that passes [`becomes_triangles`]; memory in proportion to the input, which
//! libFuzzer's limits check.
#![no_main]

use std::path::Path;

use arboleda_fuzz::surfaces::becomes_triangles;
use arboleda_host::scene::formats::gltf;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let companions = |_: &Path| Ok(bytes.to_vec());
    if let Ok(surface) = gltf::read(bytes, Path::new("input.gltf"), &companions) {
        becomes_triangles(&surface);
    }
});
