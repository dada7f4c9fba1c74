//! All tests of the promises, in one program: sixteen would each be linked with everything below them.
//!
//! `cargo test -p arboleda-tests determinism::` runs those of one file.

mod batches;
mod builds_end;
mod clusters;
mod determinism;
mod index_bytes;
mod indices;
mod kernel_oracle;
mod layout;
mod leaks;
mod mesh;
mod old_bytes;
mod opening;
mod pieces;
mod selection;
mod slices;
mod special_rays;

/// A file without its line above would not be run.
#[test]
fn each_file_is_a_module() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for file in std::fs::read_dir(folder).expect("the folder of this file") {
        let name = file.expect("a file").file_name().into_string().expect("a name");
        let module = name.strip_suffix(".rs").expect("a file of Rust");
        let line = format!("\nmod {module};\n");
        assert!(module == "main" || include_str!("main.rs").contains(&line), "{name}");
    }
}
