//! Test of `include/arboleda.h`: it is what the sources say.
//!
//! After a change of the interface, `ARBOLEDA_BLESS=1 cargo test -p arboleda-ffi --test header` writes it again.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The files that make up the interface, in the order of the header; those of `index/` with their modules.
const SOURCES: [&str; 8] = [
    "abi.rs",
    "kind.rs",
    "error.rs",
    "scene.rs",
    "options.rs",
    "index/mod.rs",
    "query.rs",
    "batch.rs",
];

/// Returns all files below a folder of sources.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("src/ is readable");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

fn generated() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml");
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in SOURCES {
        builder = builder.with_src(root.join("src").join(source));
    }
    let mut header = Vec::new();
    builder.generate().expect("the sources are parsed").write(&mut header);
    String::from_utf8(header).expect("the sources are UTF-8")
}

#[test]
fn header_is_not_stale() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/arboleda.h");
    let header = generated();
    if env::var_os("ARBOLEDA_BLESS").is_some() {
        fs::write(&path, &header).expect("include/ is writable");
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == header,
        "include/arboleda.h is stale: run `ARBOLEDA_BLESS=1 cargo test -p arboleda-ffi --test header`"
    );
}

/// A program that was compiled against an older header needs every function to stay.
#[test]
fn all_exported_functions_are_in_the_header() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let header = generated();
    let mut count = 0;
    for path in files(&root.join("src")) {
        let text = fs::read_to_string(path).expect("a source");
        for line in text.lines().filter(|line| line.starts_with("pub ")) {
            let Some((_, signature)) = line.split_once("extern \"C\" fn ") else { continue };
            let name = signature.split('(').next().expect("a name");
            assert!(header.contains(&format!("{name}(")), "{name} is not in the header");
            count += 1;
        }
    }
    assert_eq!(count, 28, "exported functions");
}

#[test]
fn unsafe_blocks_are_in_one_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for path in files(&root.join("src")) {
        let text = fs::read_to_string(&path).expect("a source");
        if path.ends_with("memory.rs") {
            continue;
        }
        for line in text.lines().filter(|line| line.contains("unsafe {")) {
            let line = line.trim();
            assert_eq!(line, "let caller = unsafe { Caller::promises() };", "{}", path.display());
        }
    }
}
