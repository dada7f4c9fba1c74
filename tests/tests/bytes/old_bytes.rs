//! Tests that bytes of earlier versions of the crate open and answer, as CHANGELOG.md promises.
//!
//! `formats/version_1.bin` has an index of each kind over the same scene: its length in 32 bits, then its bytes. It was
//! written once, and stays as it is: later builds may divide the scene otherwise, but must read this. The file of a new
//! version, where there is none yet, is written by `ARBOLEDA_BLESS=1 cargo test -p arboleda-tests old_bytes`.

use std::path::PathBuf;
use std::{env, fs};

use arboleda::{AnyIndex, IndexKind, Options, Scene, Triangle, Vec3};
use arboleda_tests::build::Built;
use arboleda_tests::{rays, scenes};

/// Kinds of that time, in the order of the file.
const KINDS_OF_VERSION_1: usize = 19;

fn path() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "formats", "version_1.bin"].iter().collect()
}

/// Makes two groups far apart, of few triangles.
fn scene() -> Vec<Triangle> {
    let mut triangles = scenes::soup(12, 2);
    triangles.extend(scenes::moved(&scenes::icosphere(0), 0.5, Vec3::new(60.0, -3.0, 0.125)));
    triangles
}

/// Writes the file.
fn write(triangles: &[Triangle]) {
    let mut file = Vec::new();
    for &kind in IndexKind::ALL {
        let built = Built::new(kind, &Scene::new(triangles), &Options::default());
        let built = built.expect("an ordinary scene");
        file.extend((built.bytes().len() as u32).to_le_bytes());
        file.extend(built.bytes());
    }
    fs::create_dir_all(path().with_file_name("")).expect("a folder");
    fs::write(path(), file).expect("a file");
}

#[test]
#[cfg(target_endian = "little")]
fn bytes_of_version_1_open_and_answer() {
    let triangles = scene();
    if env::var_os("ARBOLEDA_BLESS").is_some() && !path().exists() {
        write(&triangles);
    }
    let file = fs::read(path()).expect("it is committed");
    let linear = Built::new(IndexKind::Linear, &Scene::new(&triangles), &Options::default());
    let linear = linear.expect("an ordinary scene");
    let rays = rays::around(&triangles, 100, 4);
    let mut rest = file.as_slice();
    for &kind in &IndexKind::ALL[..KINDS_OF_VERSION_1] {
        let (length, after) = rest.split_first_chunk().expect("a length");
        let (bytes, after) = after.split_at(u32::from_le_bytes(*length) as usize);
        rest = after;
        let copied = Built::copied(kind, bytes);
        let index = AnyIndex::from_bytes(copied.bytes());
        let index = index.unwrap_or_else(|error| panic!("{}: {error}", kind.name()));
        assert_eq!(index.kind(), kind);
        let linear = linear.index();
        for ray in &rays {
            assert_eq!(index.closest_hit(ray), linear.closest_hit(ray), "{} {ray:?}", kind.name());
            assert_eq!(index.occluded(ray), linear.occluded(ray), "{} {ray:?}", kind.name());
        }
    }
    assert!(rest.is_empty());
}
