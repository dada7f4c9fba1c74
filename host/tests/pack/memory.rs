//! Tests of `pack --memory`, and of scenes of several files: the bytes of a scene of one file, packed at once.

use std::fs;
use std::path::Path;

use crate::program::{command_in, failure, folder, names, run_in, success};

/// Writes an OBJ file of boxes: each is an object of twelve triangles.
fn write_boxes(path: &Path, boxes: impl Iterator<Item = ([f32; 3], f32)>) {
    let mut text = String::new();
    let mut count = 0;
    for (number, ([x, y, z], side)) in boxes.enumerate() {
        text += &format!("o box {number}\n");
        for corner in 0..8_u8 {
            let at = |bit: u8| f32::from(corner >> bit & 1) * side;
            text += &format!("v {} {} {}\n", x + at(0), y + at(1), z + at(2));
        }
        for face in ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"] {
            let corners = face.split(' ').map(|corner| corner.parse::<u32>().unwrap() + count);
            let corners: Vec<String> = corners.map(|corner| corner.to_string()).collect();
            text += &format!("f {}\n", corners.join(" "));
        }
        count += 8;
    }
    fs::write(path, text).unwrap();
}

/// Boxes apart from each other, some touching, of two sizes.
fn boxes(from: u8, to: u8) -> impl Iterator<Item = ([f32; 3], f32)> {
    (from..to).map(|number| {
        let at = f32::from(number);
        let apart = if number % 3 == 0 { 5.0 } else { 1.0 };
        ([at * apart, at * 0.25, at % 7.0], if number % 5 == 0 { 9.0 } else { 1.0 })
    })
}

/// Makes a folder of scene files, and one file of the same scene.
fn write_scene(at: &Path) {
    fs::create_dir(at.join("tiles")).unwrap();
    write_boxes(&at.join("tiles/1.obj"), boxes(0, 40));
    write_boxes(&at.join("tiles/2.obj"), boxes(40, 41));
    fs::write(at.join("tiles/3.obj"), "v 0 0 0\n").unwrap();
    write_boxes(&at.join("tiles/4.obj"), boxes(41, 120));
    write_boxes(&at.join("whole.obj"), boxes(0, 120));
}

const ENOUGH: &str = "1G";

#[test]
fn several_files_are_one_scene_for_every_command() {
    let folder = folder();
    let at = folder.path();
    write_scene(at);
    let (whole, _) = success(&run_in(at, &["inspect", "whole.obj"]));
    let (tiles, said) = success(&run_in(at, &["inspect", "tiles"]));
    let clusters = |text: &str| {
        let line = text.lines().find(|line| line.starts_with("clusters: ")).unwrap_or_default();
        line.split(", found").next().unwrap_or_default().to_owned()
    };
    assert_eq!(clusters(&whole), clusters(&tiles));
    assert!(clusters(&whole).contains(" in 2 size classes"), "{whole}");
    assert!(said.contains("3.obj: no faces") && said.contains("left out"), "{said}");
    let digest = |scene: &[&str]| {
        let line = [&["shoot"], scene, &["--photons", "2000", "--index", "bvh"]].concat();
        let (shown, _) = success(&run_in(at, &line));
        let start = shown.find("digest").unwrap_or_else(|| panic!("{shown}"));
        shown[start..].split_whitespace().take(3).collect::<Vec<_>>().join(" ")
    };
    let files = ["tiles/1.obj", "tiles/2.obj", "tiles/3.obj", "tiles/4.obj"];
    assert_eq!(digest(&["whole.obj"]), digest(&["tiles"]));
    assert_eq!(digest(&["whole.obj"]), digest(&files));
}

#[test]
fn the_bytes_are_those_of_a_pack_at_once() {
    let folder = folder();
    let at = folder.path();
    write_scene(at);
    for name in arboleda_host::kind_names() {
        for more in [&[][..], &["--objects"], &["--origin", "auto"], &["--proximity", "1000000"]] {
            let pack = |scene: &str, out: &str, last: &[&str]| {
                let line = ["pack", scene, "--index", name, "-o", out];
                let (shown, _) = success(&run_in(at, &[&line, more, last].concat()));
                let scene = fs::read(at.join(format!("{out}.scene"))).unwrap();
                (fs::read(at.join(out)).unwrap(), shown.replace(out, ""), scene)
            };
            let once = pack("tiles", "once.arb", &[]);
            let within = pack("tiles", "within.arb", &["--memory", ENOUGH]);
            assert!(once.0 == within.0, "{name} {more:?}: {} {}", once.1, within.1);
            assert!(once.1 == within.1, "{name} {more:?}: {} {}", once.1, within.1);
            assert!(once.2 == within.2, "{name} {more:?}: the scene");
            // The file of the scene has its name, so it differs.
            let whole = pack("whole.obj", "whole.arb", &[]);
            assert!(whole.0 == within.0, "{name} {more:?}: {} {}", whole.1, within.1);
        }
    }
    let left = names(at);
    let expected = [
        "once.arb",
        "once.arb.scene",
        "tiles",
        "whole.arb",
        "whole.arb.scene",
        "whole.obj",
        "within.arb",
        "within.arb.scene",
    ];
    assert_eq!(left, expected, "no file is left");
}

/// Rooms beside each other, in a folder. Those that `coloured` names are of three materials, of which one emits light.
fn write_rooms(folder: &Path, coloured: &[bool]) {
    fs::create_dir(folder).unwrap();
    let materials =
        "newmtl red\nKd 0.9 0.5 0.3\nnewmtl grey\nKd 0.6 0.6 0.6\nnewmtl lamp\nKe 9 8 5\n";
    fs::write(folder.join("rooms.mtl"), materials).unwrap();
    for (number, is_coloured) in coloured.iter().enumerate() {
        let x = 4_000_000 + 4 * number;
        let mut text = String::from("mtllib rooms.mtl\n");
        for [dx, y, z] in [[0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0], [0, 0, 2], [3, 0, 2]] {
            text += &format!("v {} {y} {z}\n", x + dx);
        }
        text += &format!("v {x}.9 0.5 1.9\nv {x}.9 1.5 1.9\nv {} 1.5 1.9\n", x + 2);
        for (object, material, face) in
            [("floor", "red", "1 2 3 4"), ("wall", "grey", "1 5 6 2"), ("lamp", "lamp", "7 8 9")]
        {
            let material = if *is_coloured { material } else { "grey" };
            text += &format!("o {object}\nusemtl {material}\nf {face}\n");
        }
        fs::write(folder.join(format!("{number}.obj")), text).unwrap();
    }
}

#[test]
fn photons_need_only_the_two_files() {
    let folder = folder();
    let at = folder.path();
    write_rooms(&at.join("grey first"), &[false, true, false]);
    write_rooms(&at.join("grey last"), &[true, false]);
    write_rooms(&at.join("one"), &[true]);
    let line = |words: &[&[&str]]| success(&run_in(at, &words.concat()));
    let light = ["--photons", "5k", "--up", "z", "--out"];
    for scene in ["grey first", "grey last", "one"] {
        line(&[&["shoot", scene, "--origin", "auto"], &light, &["whole.npy"]]);
        for kind in ["wide-bvh", "lean-bvh", "octree-hierarchy"] {
            let pack = ["pack", scene, "--origin", "auto", "--index", kind, "-o"];
            line(&[&pack, &["once.arb"]]);
            let (_, said) = line(&[&pack, &["within.arb", "--memory", ENOUGH]]);
            assert!(said.contains("its scene: within.arb.scene"), "{said}");
            assert!(!said.contains("does not hold the origin"), "{said}");
            // Nothing else is read.
            fs::rename(at.join(scene), at.join("away")).unwrap();
            line(&[&["shoot", "--index-file", "within.arb"], &light, &["packed.npy"]]);
            fs::rename(at.join("away"), at.join(scene)).unwrap();
            for (a, b) in [
                ("whole.npy", "packed.npy"),
                ("once.arb", "within.arb"),
                ("once.arb.scene", "within.arb.scene"),
            ] {
                let bytes = |name: &str| fs::read(at.join(name)).unwrap();
                assert!(bytes(a) == bytes(b), "{scene}, {kind}: {b}");
            }
        }
    }
}

#[test]
fn the_index_alone_has_no_origin() {
    let folder = folder();
    let at = folder.path();
    write_rooms(&at.join("rooms"), &[true, false]);
    let pack = ["pack", "rooms", "--origin", "auto", "--memory", ENOUGH, "--index-only"];
    let (_, said) = success(&run_in(at, &[&pack[..], &["-o", "a.arb"]].concat()));
    assert!(said.contains("does not hold the origin 4000003.5,"), "{said}");
    assert_eq!(names(at), ["a.arb", "rooms"], "no scene is written");
}

#[test]
fn clusters_may_be_many_or_few() {
    let folder = folder();
    let at = folder.path();
    let triangle = |number: u32| {
        let x = 10 * number;
        format!("v {x} 0 0\nv {} 0 0\nv {x} 1 0\nf -3 -2 -1\n", x + 1)
    };
    fs::write(at.join("one.obj"), triangle(0)).unwrap();
    fs::write(at.join("many.obj"), (0..5000).map(triangle).collect::<String>()).unwrap();
    for (scene, clusters) in [("one.obj", "1 cluster,"), ("many.obj", "5,000 clusters,")] {
        let line = ["pack", scene, "--index", "octree-hierarchy", "-o"];
        success(&run_in(at, &[&line[..], &["once.arb"]].concat()));
        // `auto` is the octree hierarchy.
        let within = ["pack", scene, "-o", "within.arb", "--memory", ENOUGH];
        let (shown, _) = success(&run_in(at, &within));
        assert!(shown.contains(clusters), "{shown}");
        let bytes = |name: &str| fs::read(at.join(name)).unwrap();
        assert!(bytes("once.arb") == bytes("within.arb"), "{scene}");
    }
}

#[test]
fn what_cannot_be_done_within_the_memory_is_said() {
    let folder = folder();
    let at = folder.path();
    write_scene(at);
    fs::write(at.join("broken.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 8\n").unwrap();
    fs::write(at.join("old.arb"), "old").unwrap();
    fs::write(at.join("old.arb.scene"), "old scene").unwrap();
    fs::create_dir(at.join("folder.arb.scene")).unwrap();
    fs::create_dir(at.join("none")).unwrap();
    let before = names(at);
    for (line, problem) in [
        ("pack tiles --memory 10M -o old.arb", "is the least that would do"),
        ("pack whole.obj broken.obj --memory 1G -o old.arb", "broken.obj, line 5: "),
        ("pack none --memory 1G -o old.arb", "none: no scene files"),
        ("pack missing.obj --memory 1G -o old.arb", "missing.obj"),
        ("pack --scene fig2 --memory 1G -o old.arb", "--memory is for scene files"),
        ("pack tiles --memory 1G --index all -o old.arb", "--index all is for comparisons"),
        ("pack tiles --memory 0 -o old.arb", "must be 1 to"),
        ("pack tiles --memory 1G -o folder.arb", "folder.arb.scene: it is a folder"),
        ("inspect old.arb whole.obj", "name it alone"),
    ] {
        let said = failure(&run_in(at, &line.split(' ').collect::<Vec<_>>()));
        assert!(said.contains(problem), "{line}: {said}");
    }
    assert_eq!(fs::read(at.join("old.arb")).unwrap(), b"old");
    assert_eq!(fs::read(at.join("old.arb.scene")).unwrap(), b"old scene");
    assert_eq!(names(at), before, "no file is left");

    // The least that is named does.
    let said = failure(&run_in(at, &["pack", "tiles", "--memory", "10M", "-o", "new.arb"]));
    let least = said.split("is too small: ").nth(1).unwrap().split(' ').next().unwrap();
    success(&run_in(at, &["pack", "tiles", "--memory", least, "-o", "new.arb"]));
}

/// The scene is written last. Here its disk is full.
#[cfg(target_os = "linux")]
#[test]
fn a_scene_that_cannot_be_written_leaves_the_old_index() {
    let folder = folder();
    let at = folder.path();
    write_boxes(&at.join("a.obj"), boxes(0, 3));
    fs::write(at.join("a.arb"), "old").unwrap();
    std::os::unix::fs::symlink("/dev/full", at.join("a.arb.scene")).unwrap();
    let run = run_in(at, &["pack", "a.obj", "--memory", ENOUGH, "-o", "a.arb"]);
    assert!(run.stdout.is_empty(), "nothing is shown that is not there");
    let said = failure(&run);
    assert!(said.contains("cannot write a.arb.scene: No space left"), "{said}");
    assert_eq!(fs::read(at.join("a.arb")).unwrap(), b"old");
    assert_eq!(names(at), ["a.arb", "a.arb.scene", "a.obj"], "no file is left");
}

/// Resident memory at its peak, in bytes, and the number of triangles and bytes of the index.
#[cfg(target_os = "linux")]
#[test]
fn the_resident_memory_stays_below_the_limit() {
    use std::io::Read;
    let folder = folder();
    let at = folder.path();
    // Eight files of 50,000 triangles: with tables and index, 60 MB more than the program takes without them.
    fs::create_dir(at.join("tiles")).unwrap();
    for number in 0..8_u8 {
        let mut bytes = vec![b' '; 80];
        bytes.extend(50_000_u32.to_le_bytes());
        for triangle in 0..50_000_u32 {
            let (x, y) = ((triangle % 250) as f32, (triangle / 250) as f32);
            let z = f32::from(number) * 100.0;
            bytes.extend([0; 12]);
            for number in [x, y, z, x + 0.7, y, z, x, y + 0.7, z] {
                bytes.extend(number.to_le_bytes());
            }
            bytes.extend([0; 2]);
        }
        fs::write(at.join(format!("tiles/{number}.stl")), bytes).unwrap();
    }
    let said = failure(&run_in(at, &["pack", "tiles", "--memory", "1", "-o", "a.arb"]));
    let least = said.split("is too small: ").nth(1).unwrap().split(' ').next().unwrap();
    let mut child = command_in(at, &["pack", "tiles", "--memory", least, "-o", "a.arb"])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The peak is read as often as it can be, as long as the program runs.
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("0 kB");
        let kilobytes: u64 = line.trim().trim_end_matches(" kB").parse().unwrap();
        peak = peak.max(kilobytes << 10);
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let mut shown = String::new();
    child.stdout.take().unwrap().read_to_string(&mut shown).unwrap();
    assert!(shown.contains("400,000 triangles"), "{shown}");
    let least: u64 = least.parse().unwrap();
    assert!(peak > 10_000_000 && peak < least, "{peak} of {least}");
    success(&run_in(at, &["pack", "tiles", "--index", "octree-hierarchy", "-o", "once.arb"]));
    let bytes = |name: &str| fs::read(at.join(name)).unwrap();
    assert!(bytes("a.arb") == bytes("once.arb"));
    assert!(bytes("a.arb.scene") == bytes("once.arb.scene"));
}
