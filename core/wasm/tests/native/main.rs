//! Tests of the functions beyond the C interface, and the digests that WebAssembly must give too.
#![allow(unsafe_code, missing_docs)]

mod digests;
mod octrees;
mod scene;

#[test]
fn unsafe_blocks_only_take_the_promise() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut count = 0;
    for file in [
        "lib.rs",
        "records.rs",
        "clusters.rs",
        "octree/mod.rs",
        "octree/cells.rs",
        "octree/path.rs",
    ] {
        let text = std::fs::read_to_string(root.join(file)).expect("a source");
        for line in text.lines().filter(|line| line.contains("unsafe {")) {
            assert_eq!(line.trim(), "let caller = unsafe { Caller::promises() };", "{file}");
            count += 1;
        }
    }
    assert_eq!(count, 4);
}
