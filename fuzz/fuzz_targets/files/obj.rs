//! Random OBJ and material files.
//!
//! Workload: any bytes, with the keywords of the formats from a dictionary. Every material file that the input names
//! has the same bytes, so one input is both files.
//!
//! Constraints: an error, or a surface that passes [`becomes_triangles`]; memory in proportion to the input, which
//! libFuzzer's limits check.
#![no_main]

use std::path::Path;

use arboleda_fuzz::surfaces::becomes_triangles;
use arboleda_host::scene::formats::obj;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let companions = |_: &Path| Ok(bytes.to_vec());
    if let Ok(surface) = obj::read(bytes, Path::new("input.obj"), &companions) {
        becomes_triangles(&surface);
    }
});
