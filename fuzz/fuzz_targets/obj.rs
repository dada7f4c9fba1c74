//! OBJ and material files that nobody wrote.
//!
//! Workload: any bytes, with the words of the formats from a dictionary. Whatever material file they name is
//! the same bytes again, so that one input is both.
//! Constraints: none. An error, or triangles as [`becomes_triangles`] wants them; memory in proportion to the
//! input, which libFuzzer's limits watch.
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
