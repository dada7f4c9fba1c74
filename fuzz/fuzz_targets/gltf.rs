//! glTF documents that nobody wrote, as text and in binary files.
//!
//! Workload: any bytes, with the words of the format from a dictionary. Whatever buffer they name is the
//! same bytes again, so that accessors find something to read.
//! Constraints: none. An error, or triangles as [`becomes_triangles`] wants them; memory in proportion to the
//! input, which libFuzzer's limits watch.
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
