//! Digests of index bytes, hits and counters of every kind, in `tests/digests.txt`. Node.js and a browser compare theirs.
//!
//! `ARBOLEDA_BLESS=1 cargo test -p arboleda-wasm digests` writes the file again.

use std::path::Path;
use std::{env, fs};

use arboleda::{Counters, Hit, IndexKind, Options, OwnedIndex, Scene};

use crate::scene;

/// FNV-1a of 32 bits (Fowler, Noll, Vo).
fn digest(bytes: impl IntoIterator<Item = u8>) -> u32 {
    bytes
        .into_iter()
        .fold(0x811c_9dc5, |sum, byte| (sum ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

fn bytes_of(hit: &Hit) -> impl Iterator<Item = u8> + use<> {
    [hit.triangle.0, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()]
        .into_iter()
        .flat_map(u32::to_le_bytes)
}

#[test]
fn digests_are_those_of_the_file() {
    let (triangles, rays) = (scene::triangles(), scene::rays(2000));
    let mut lines = String::new();
    for &kind in IndexKind::ALL {
        let owned =
            OwnedIndex::build(kind, &Scene::new(&triangles), &Options::DEFAULT).expect("builds");
        let (index, mut counters) = (owned.index(), Counters::default());
        let hits: Vec<Hit> = rays
            .iter()
            .map(|ray| index.closest_hit_counted(ray, &mut counters).unwrap_or(Hit::NONE))
            .collect();
        let bytes = index.as_bytes();
        lines += &format!(
            "{} {} {:08x} {:08x} {} {}\n",
            kind.name(),
            bytes.len(),
            digest(bytes.iter().copied()),
            digest(hits.iter().flat_map(bytes_of)),
            counters.nodes_visited,
            counters.triangle_tests,
        );
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/digests.txt");
    if env::var_os("ARBOLEDA_BLESS").is_some() {
        fs::write(&path, &lines).expect("tests/ is writable");
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(found, lines, "kind, bytes, digest of bytes, digest of hits, nodes, tests");
}
