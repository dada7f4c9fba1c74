//! Tests of packed scenes: what is read is what was written, and a wrong pair is told.

use std::fs;

use arboleda::{IndexKind, Options, OwnedIndex};
use tempfile::TempDir;

use super::*;
use crate::scene::builtin::require;
use crate::scene::{FaceLight, LitSides};

/// A scene with all that a scene may have.
fn coloured() -> Model {
    let mut model = require("fig2").unwrap();
    model.colours =
        (0..model.triangles.len()).map(|at| [0.5, 0.25, (at % 7) as f32 / 9.0]).collect();
    model.origin = [5e5, -4e6, 12.25];
    for (triangle, sides) in [(3, LitSides::Both), (5, LitSides::Front)] {
        model.emitters.push(FaceLight { triangle, radiance: [1.0, 2.0, 0.5], sides });
    }
    model
}

fn built(model: &Model, kind: IndexKind) -> OwnedIndex {
    OwnedIndex::build(kind, &model.scene(), &Options::DEFAULT).unwrap()
}

fn packed(folder: &TempDir, name: &str, model: &Model, kind: IndexKind) -> PathBuf {
    let path = folder.path().join(name);
    PackedScene::write(&path, model, &built(model, kind).index()).unwrap();
    path
}

fn problem(path: &Path) -> String {
    match PackedScene::open(path, Validation::Always) {
        Ok(_) => panic!("{} was opened", path.display()),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_scene_is_read_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    for model in
        [coloured(), require("fig2").unwrap(), require("fig3").unwrap(), Model::named("none")]
    {
        for &kind in IndexKind::ALL {
            let owned = built(&model, kind);
            let path = packed(&folder, "a.arb", &model, kind);
            assert_eq!(fs::read(&path).unwrap(), owned.as_bytes());
            let scene = PackedScene::open(&path, Validation::Always).unwrap();
            assert!(scene.is_validated_now);
            assert_eq!(scene.index.index().as_bytes(), owned.as_bytes());
            assert_eq!(scene.model.digest(), model.digest());
            assert!(model.triangles.is_empty() || scene.model.triangles.is_mapped());
            let object_names = scene.object_names().unwrap();
            assert_eq!(Model { object_names, ..scene.model }, model, "{}", kind.name());
        }
    }
}

#[test]
fn triangles_are_in_one_of_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let model = coloured();
    let bytes = |kind| {
        let path = packed(&folder, "a.arb", &model, kind);
        fs::metadata(scene_path(&path)).unwrap().len()
    };
    let triangles = size_of_val(model.triangles.as_slice()) as u64;
    let (with, without) = (bytes(IndexKind::WideBvh), bytes(IndexKind::LeanBvh));
    assert!(with.abs_diff(without + triangles) < 64, "{with} {without}");
}

#[test]
fn a_wrong_pair_names_both() {
    let folder = tempfile::tempdir().unwrap();
    let model = coloured();
    let a = packed(&folder, "a.arb", &model, IndexKind::WideBvh);
    // Another kind, and another scene of as many triangles: its index has as many bytes.
    let mut moved = model.clone();
    moved.triangles[4].a.x += 0.125;
    for (other, kind) in [(&model, IndexKind::Octree), (&moved, IndexKind::WideBvh)] {
        let b = packed(&folder, "b.arb", other, kind);
        fs::copy(scene_path(&b), scene_path(&a)).unwrap();
        let said = problem(&a);
        assert!(said.contains("a.arb.scene: it is not the scene of "), "{said}");
        assert!(said.contains("a.arb, but of another index"), "{said}");
    }
}

#[test]
fn files_that_were_changed_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = packed(&folder, "a.arb", &coloured(), IndexKind::WideBvh);
    let beside = scene_path(&path);
    let (index, scene) = (fs::read(&path).unwrap(), fs::read(&beside).unwrap());
    // Behind the magic number, the byte order and the version: the number of the head's bytes, the digest, and all.
    for at in (16..64).chain((64..scene.len()).step_by(997)) {
        for bit in [16, 64] {
            let mut changed = scene.clone();
            changed[at] ^= bit;
            fs::write(&beside, changed).unwrap();
            assert!(problem(&path).contains("a.arb.scene: it is torn or was changed"), "{at}");
        }
    }
    for (bytes, said) in [
        (&scene[..scene.len() - 1], "a.arb.scene: it is torn"),
        (&scene[..100], "a.arb.scene: it is torn"),
        (&scene[..10], "a.arb.scene: it is not the scene of an index"),
        (&index[..], "a.arb.scene: it is not the scene of an index"),
    ] {
        fs::write(&beside, bytes).unwrap();
        assert!(problem(&path).contains(said), "{said}");
    }
    let swapped = [&scene[..8], &[1, 2, 3, 4], &scene[12..]].concat();
    fs::write(&beside, swapped).unwrap();
    let said = problem(&path);
    assert!(said.contains("the other byte order") || cfg!(target_endian = "big"), "{said}");

    fs::write(&beside, &scene).unwrap();
    for at in (64..index.len()).step_by(997) {
        let mut changed = index.clone();
        changed[at] ^= 1;
        fs::write(&path, changed).unwrap();
        let said = problem(&path);
        assert!(said.contains("a.arb: ") || said.contains("one of them was changed"), "{said}");
    }
    fs::write(&path, &index[..index.len() - 4]).unwrap();
    assert!(problem(&path).contains("a.arb: the bytes of the index are cut short"));
    fs::write(&path, &index).unwrap();
    assert!(PackedScene::open(&path, Validation::Always).is_ok());
    fs::remove_file(&beside).unwrap();
    assert!(problem(&path).contains("a.arb.scene: cannot be read"));
}

/// A head with a sound digest that does not fit the columns.
#[test]
fn forged_lengths_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let model = coloured();
    let path = packed(&folder, "a.arb", &model, IndexKind::WideBvh);
    let beside = scene_path(&path);
    let scene = fs::read(&beside).unwrap();
    let mut cut = scene[..1024].to_vec();
    let digest = *blake3::hash(&[&cut[16..24], &cut[64..]].concat()).as_bytes();
    cut[24..56].copy_from_slice(&digest);
    fs::write(&beside, cut).unwrap();
    assert!(problem(&path).contains("contradicts itself"));
}

#[cfg(target_os = "linux")]
#[test]
fn files_are_validated_once_until_they_change() {
    let folder = tempfile::tempdir().unwrap();
    let model = coloured();
    let path = packed(&folder, "a.arb", &model, IndexKind::WideBvh);
    let open =
        |validation| PackedScene::open(&path, validation).map(|scene| scene.is_validated_now);
    assert!(open(Validation::Once).unwrap() && open(Validation::Once).unwrap(), "too young");
    std::thread::sleep(std::time::Duration::from_millis(3100));
    // Of several at once, one validates.
    let validated = std::thread::scope(|scope| {
        let all = [(); 4].map(|()| scope.spawn(|| open(Validation::Once).unwrap()));
        all.map(|one| one.join().unwrap()).into_iter().filter(|&is_validated| is_validated).count()
    });
    assert_eq!(validated, 1);
    assert!(!open(Validation::Once).unwrap() && open(Validation::Always).unwrap());
    let known = PackedScene::open(&path, Validation::Once).unwrap();
    assert_eq!(known.model.digest(), model.digest());
    // A file that was changed in place has no record.
    let beside = scene_path(&path);
    let mut bytes = fs::read(&beside).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&beside, bytes).unwrap();
    assert!(open(Validation::Once).unwrap_err().to_string().contains("torn"));
    let files = [&path, &beside].map(|path| fs::metadata(path).unwrap());
    Record::of(&files).unwrap().forget();
}
