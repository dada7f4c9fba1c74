//! Runs the examples.

use std::path::Path;

#[path = "../examples/obj_to_hits.rs"]
#[allow(dead_code, reason = "its `main` reads the command line, which is the test's")]
mod obj_to_hits;

#[path = "../examples/scene_to_files.rs"]
#[allow(dead_code, reason = "its `main` reads the command line, which is the test's")]
mod scene_to_files;

#[test]
fn scene_to_files() {
    use arboleda_host::scene::{Origin, SceneFiles, builtin::require};
    let folder = tempfile::tempdir().unwrap();
    scene_to_files::run("city-1000", folder.path(), 3).unwrap();
    let files = SceneFiles::list(&[folder.path().into()]).unwrap();
    assert_eq!(files.paths().len(), 3);
    let model = files.load(Origin::Unchanged).unwrap();
    assert_eq!(model.triangles, require("city-1000").unwrap().triangles);
}

/// The comb's bar covers 17 of the 100 rows of rays, and its teeth 50 of the 100 columns of the others.
#[test]
fn obj_to_hits() {
    let comb = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/comb.obj");
    let hits = obj_to_hits::run(&comb).unwrap();
    assert_eq!(hits.values().sum::<usize>(), 17 * 100 + 83 * 50);
}
