//! Runs the examples.

use std::path::Path;

#[path = "../examples/obj_to_hits.rs"]
#[allow(dead_code, reason = "its `main` reads the command line, which is the test's")]
mod obj_to_hits;

/// The comb's bar covers 17 of the 100 rows of rays, and its teeth 50 of the 100 columns of the others.
#[test]
fn obj_to_hits() {
    let comb = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/comb.obj");
    let hits = obj_to_hits::run(&comb).unwrap();
    assert_eq!(hits.values().sum::<usize>(), 17 * 100 + 83 * 50);
}
