//! Damaged index bytes.
//!
//! Workload: a small valid index of any kind, with its triangles or beside them. Some of its bytes or words are
//! replaced, or its whole local index. Raw bytes alone would seldom get past the header.
//!
//! Constraints: none on the bytes. An index that `from_bytes` accepts must be safe to query, with no more work than
//! there are words.
#![no_main]

use std::sync::LazyLock;

use arbitrary::Arbitrary;
use arboleda::{IndexKind, Mesh, Options, Ray, Scene, Triangle};
use arboleda_tests::build::Built;
use arboleda_tests::checks::hostile::{
    is_harmless_beside, small_options, with_words, with_words_beside,
};
use arboleda_tests::{rays, scenes};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Damage {
    kind: u8,
    is_beside: bool,
    /// Words that replace the local index of an index of one cluster.
    words: Option<Vec<u16>>,
    /// Offsets of words and their values; the highest bit of a value becomes that of the word.
    replaced: Vec<(u16, u16)>,
    bytes: Vec<(u16, u8)>,
    length: Option<u16>,
}

static TRIANGLES: LazyLock<Vec<Triangle>> = LazyLock::new(|| {
    [
        scenes::lattice(12, 2, 3),
        scenes::moved(&scenes::lattice(6, 2, 4), 1.0, arboleda::Vec3::splat(300.0)),
    ]
    .concat()
});
static RAYS: LazyLock<Vec<Ray>> = LazyLock::new(|| rays::around(&TRIANGLES, 6, 1));

/// Widens a value and moves its highest bit to the top, where links have their leaf bit.
fn widened(value: u16) -> u32 {
    u32::from(value & 0x7fff) | u32::from(value >> 15) << 31
}

fuzz_target!(|damage: Damage| {
    let kind = IndexKind::ALL[usize::from(damage.kind) % IndexKind::ALL.len()];
    let one_cluster = Options { proximity: 1e6, size_classes: 1, ..small_options() };
    let options = if damage.words.is_some() { one_cluster } else { small_options() };
    let mesh = (damage.is_beside && !kind.holds_triangles()).then_some(Mesh::Triangles(&TRIANGLES));
    let scene = Scene::new(&TRIANGLES);
    let scene = if mesh.is_some() { scene.beside() } else { scene };
    let valid = Built::new(kind, &scene, &options).expect("an ordinary scene");
    let mut damaged = match &damage.words {
        Some(words) => {
            let words: Vec<u32> = words.iter().copied().map(widened).collect();
            match mesh {
                Some(mesh) => with_words_beside(&valid, mesh, &words),
                None => with_words(&valid, &words),
            }
        }
        None => valid,
    };
    let length = damaged.bytes().len();
    for &(place, value) in &damage.replaced {
        let at = usize::from(place) % (length / 4) * 4;
        damaged.bytes_mut()[at..at + 4].copy_from_slice(&widened(value).to_ne_bytes());
    }
    for &(place, value) in &damage.bytes {
        damaged.bytes_mut()[usize::from(place) % length] = value;
    }
    if let Some(cut) = damage.length {
        damaged = Built::copied(kind, &damaged.bytes()[..usize::from(cut) % (length + 1)]);
    }
    is_harmless_beside(&damaged, mesh, &RAYS);
});
