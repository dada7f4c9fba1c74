//! Tests of `irradiance --part` and `render --part`: merged, they are the bytes of one run.

use std::fs;
use std::path::Path;

use crate::program::{command_line, failure, folder, same_bytes, success, write_rays};

/// A room without a lid, whose walls have two colours.
const ROOM: &str = "mtllib room.mtl
v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nv 0 0 2\nv 3 0 2\nv 3 2 2\nv 0 2 2
usemtl red\nf 1 2 3 4\nf 1 5 6 2\nusemtl grey\nf 4 3 7 8\nf 1 4 8 5\n";
const MATERIALS: &str = "newmtl red\nKd 0.9 0.5 0.3\nnewmtl grey\nKd 0.6 0.6 0.6\n";

fn write_room(at: &Path) {
    fs::write(at.join("room.obj"), ROOM).unwrap();
    fs::write(at.join("room.mtl"), MATERIALS).unwrap();
    let on_floor = |place: usize| {
        let [x, y] = [place % 6, place / 6].map(|step| step as f32 * 0.4 + 0.3);
        [x, y, 0.0, 0.0, 0.0, 1.0]
    };
    // One row is not valid, and gets zeros.
    let mut points: Vec<[f32; 6]> = (0..24).map(on_floor).collect();
    points[7] = [0.0; 6];
    write_rays(&at.join("points.npy"), &points);
    points[8] = [1.5, 1.0, 0.0, 0.0, 0.0, 1.0];
    write_rays(&at.join("others.npy"), &points);
}

fn run(at: &Path, line: &str) -> String {
    success(&command_line(at, line).output().unwrap()).0
}

fn refused(at: &Path, line: &str) -> String {
    failure(&command_line(at, line).output().unwrap())
}

/// The line of the digest of estimates or pixels.
fn digest(shown: &str) -> &str {
    shown.lines().find(|line| line.starts_with("digest of")).expect(shown)
}

/// Cuts a job of 9,000 photons, in each of a few ways, and shoots the parts through one index after the other.
fn shoot_parts(at: &Path, command: &str, cuts: &[u64]) -> Vec<String> {
    let indices = ["wide-bvh", "octree-hierarchy", "linear", "grid-hierarchy"];
    let ranges = cuts.iter().zip(&cuts[1..]).enumerate();
    let shot = ranges.map(|(number, (start, end))| {
        let (index, threads) = (indices[number % indices.len()], 1 + number % 3);
        let file = format!("{start}.part");
        let with = format!("--index {index} --threads {threads} --part {file}");
        run(at, &format!("{command} --photon-range {start}..{end} {with}"));
        file
    });
    shot.collect()
}

#[test]
fn estimates_of_parts_are_those_of_one_run() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    for options in [
        "",
        "--domain disc --bounces indirect",
        "--estimator photon-map --k 40",
        "--estimator photon-map --radius 0.3 --domain visible --kernel epanechnikov",
    ] {
        let command = format!(
            "irradiance room.obj --up z --photons 9k --seed 5 --points points.npy {options} --quiet"
        );
        let shown = run(at, &format!("{command} --out whole.npy"));
        for cuts in [&[0, 9_000][..], &[0, 1, 1_025, 4_000, 8_999, 9_000]] {
            let mut files = shoot_parts(at, &command, cuts);
            files.reverse();
            let merged = run(at, &format!("merge {} --out merged.npy --quiet", files.join(" ")));
            assert_eq!(digest(&merged), digest(&shown), "{options}");
            same_bytes(at, "merged.npy", "whole.npy");
        }
        // Parts of parts.
        run(at, "merge 1.part 1025.part --part middle.part --quiet");
        run(at, "merge 4000.part 8999.part --part last.part --quiet");
        run(at, "merge last.part middle.part 0.part --part all.part --out merged.npy --quiet");
        same_bytes(at, "merged.npy", "whole.npy");
        let merged = run(at, "merge all.part --quiet");
        assert_eq!(digest(&merged), digest(&shown), "{options}");
    }
}

#[test]
fn pictures_of_parts_are_those_of_one_run() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    for options in [
        "--passes 3",
        "--passes 2 --estimator photon-map --k 30 --false-colour --quantity irradiance",
        "--final-gather 3 --samples 1 --radius 0.3",
        "--final-gather 4 --estimator photon-map --passes 2",
    ] {
        let photons = if options.contains("--passes 3") {
            3_000
        } else if options.contains("--passes 2") {
            4_500
        } else {
            9_000
        };
        let command = format!(
            "render room.obj --up z --photons {photons} --size 64 64 {options} --eye 1.5,-4,3 --quiet"
        );
        let shown = run(at, &format!("{command} --out whole.png --values whole.exr"));
        // Within a pass, at its end, and over it.
        let files = shoot_parts(at, &command, &[0, 700, 3_000, 4_400, 9_000]);
        let [a, b, c, d] = &files[..] else { panic!("four parts") };
        run(at, &format!("merge {d} {c} --part later.part --quiet"));
        let line = format!("merge later.part {b} {a} --out merged.png --values merged.exr --quiet");
        assert_eq!(digest(&run(at, &line)), digest(&shown), "{options}");
        same_bytes(at, "merged.png", "whole.png");
        same_bytes(at, "merged.exr", "whole.exr");
    }
}

#[test]
fn a_photon_map_of_parts_is_that_of_one_run() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    let command =
        "irradiance room.obj --photons 9k --points points.npy --estimator photon-map --quiet";
    run(at, &format!("{command} --out whole.npy --save-map whole.map"));
    let files = shoot_parts(at, command, &[0, 5_000, 9_000]).join(" ");
    run(at, &format!("merge {files} --save-map merged.map --quiet"));
    same_bytes(at, "merged.map", "whole.map");
    run(at, &format!("merge {files} --part all.part --save-map again.map --quiet"));
    same_bytes(at, "again.map", "whole.map");
    let first = files.split(' ').next().unwrap();
    let said = refused(at, &format!("merge {first} --part one.part --save-map one.map --quiet"));
    assert!(said.contains("are in no part"), "{said}");
}

#[test]
fn parts_of_other_jobs_are_named() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    let first = "room.obj --photons 9k --photon-range 0..4k --part a.part --quiet";
    let rest = "--photon-range 4k..9k --part b.part --quiet";
    run(at, &format!("irradiance {first} --points points.npy --radius 0.3"));
    for (line, difference) in [
        ("irradiance room.obj --photons 9k --points others.npy --radius 0.3", "points of digest"),
        (
            "irradiance room.obj --photons 9k --points points.npy --radius 0.25",
            "radius 0.25, not 0.3",
        ),
        (
            "irradiance room.obj --photons 9k --points points.npy --estimator photon-map --radius 0.3",
            "the estimator photon-map, not detp",
        ),
        (
            "irradiance room.obj --photons 9k --points points.npy --radius 0.3 --bounces direct",
            "--bounces direct, not all",
        ),
        (
            "irradiance room.obj --photons 9k --points points.npy --radius 0.3 --seed 2",
            "2 as seed, not 1",
        ),
        ("render room.obj --photons 9k --size 64 64", "photons for `render`, not for `irradiance`"),
        ("shoot room.obj --photons 9k", "photons for `shoot`, not for `irradiance`"),
    ] {
        run(at, &format!("{line} {rest}"));
        let said = refused(at, "merge a.part b.part --out e.npy");
        assert!(said.contains("b.part is a part of another job than a.part"), "{said}");
        assert!(said.contains(difference), "{said}");
    }
    run(at, &format!("render {first} --size 64 64"));
    for (options, difference) in [
        ("--size 64 65", "--size 64 x 65, not 64 x 64"),
        ("--size 64 64 --eye 9,9,9", "the camera at"),
        ("--size 64 64 --samples 3", "--samples 3, not 2"),
        ("--size 64 64 --final-gather 2", "--final-gather 2, not 0"),
        ("--size 64 64 --passes 2", "18000 photons in all, not 9000"),
    ] {
        run(at, &format!("render room.obj --photons 9k {options} {rest}"));
        let said = refused(at, "merge a.part b.part --out x.png");
        assert!(said.contains(difference), "{said}");
    }
    assert!(!at.join("e.npy").exists() && !at.join("x.png").exists());
}

#[test]
fn missing_doubled_torn_and_forged_parts_are_named() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    for options in ["", "--estimator photon-map"] {
        let command =
            format!("irradiance room.obj --photons 9k --points points.npy {options} --quiet");
        shoot_parts(at, &command, &[0, 2_000, 4_000]);
        run(at, &format!("{command} --photon-range 3999..5k --part c.part"));
        assert_eq!(run(at, "merge 2000.part 0.part --missing"), "4000..9000\n");
        let said = refused(at, "merge 0.part 2000.part --out e.npy");
        assert!(said.contains("photons 4000..9000 are in no part"), "{said}");
        let said = refused(at, "merge 0.part 2000.part 2000.part --out e.npy");
        assert!(said.contains("photons 2000..4000 are in 2000.part and in 2000.part"), "{said}");
        let said = refused(at, "merge 0.part 2000.part c.part --out e.npy");
        assert!(said.contains("photons 3999..4000 are in 2000.part and in c.part"), "{said}");

        let bytes = fs::read(at.join("0.part")).unwrap();
        fs::write(at.join("torn.part"), &bytes[..bytes.len() / 2]).unwrap();
        let said = refused(at, "merge torn.part 2000.part");
        assert!(said.contains("torn.part") && said.contains("torn"), "{said}");
        // A changed body with the right hash contradicts itself, or is of no known length.
        let mut forged = bytes.clone();
        forged.truncate(bytes.len() - 1);
        let hash = *blake3::hash(&forged[44..]).as_bytes();
        forged[12..44].copy_from_slice(&hash);
        fs::write(at.join("forged.part"), forged).unwrap();
        let said = refused(at, "merge forged.part 2000.part");
        assert!(said.contains("forged.part") && said.contains("contradicts itself"), "{said}");
    }
}

#[test]
fn files_that_changed_or_moved_are_named() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    let command = "irradiance room.obj --photons 9k --points points.npy --quiet";
    run(at, &format!("{command} --out whole.npy"));
    run(at, &format!("{command} --part all.part"));
    // The scene and the points are elsewhere.
    fs::create_dir(at.join("moved")).unwrap();
    for file in ["room.obj", "room.mtl", "points.npy"] {
        fs::rename(at.join(file), at.join("moved").join(file)).unwrap();
    }
    let said = refused(at, "merge all.part --out merged.npy");
    assert!(said.contains("points.npy"), "{said}");
    let moved = "merge all.part --scene-file moved/room.obj --points moved/points.npy";
    run(at, &format!("{moved} --out merged.npy --quiet"));
    same_bytes(at, "merged.npy", "whole.npy");
    // Another scene, and other points.
    fs::write(at.join("moved/room.mtl"), MATERIALS.replace("0.9", "0.8")).unwrap();
    let said = refused(at, &format!("{moved} --out other.npy"));
    assert!(said.contains("have changed") && said.contains("another scene"), "{said}");
    fs::write(at.join("moved/room.mtl"), MATERIALS).unwrap();
    let others = "merge all.part --scene-file moved/room.obj --points others.npy --out other.npy";
    let said = refused(at, others);
    assert!(said.contains("points of digest"), "{said}");
    assert!(!at.join("other.npy").exists());
}

#[test]
fn options_that_a_part_does_not_have_are_refused() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    let light = "room.obj --photons 9k --quiet";
    for (line, problem) in [
        ("irradiance --points points.npy --photon-range 0..10k --part x.part", "there are 9000"),
        ("irradiance --points points.npy --part x.part --out e.npy", "--out"),
        ("irradiance --points points.npy", "--out"),
        ("irradiance --points points.npy --part x.part --save-map m", "--save-map"),
        ("render --photon-range 0..1k", "--part"),
        ("render --part x.part --values v.exr", "--values"),
        ("render --passes 3 --photon-range 0..30k --part x.part", "there are 27000"),
        ("render --photons 0 --part x.part", "no photons"),
    ] {
        let light = if line.contains("--photons 0") { "room.obj --quiet" } else { light };
        let said = refused(at, &format!("{line} {light}"));
        assert!(said.contains(problem), "{line}: {said}");
        assert!(!at.join("x.part").exists());
    }
    run(at, &format!("irradiance {light} --points points.npy --part a.part"));
    for (options, problem) in [
        ("--out x.png", "parts of `irradiance` make a file whose name ends in .npy"),
        ("--values x.exr", "--values is not for parts of `irradiance`"),
        ("--missing --out x.npy", "--missing"),
    ] {
        let said = refused(at, &format!("merge a.part {options}"));
        assert!(said.contains(problem), "{said}");
    }
}

#[test]
fn checkpoints_of_light_give_the_bytes_of_one_run() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    for (command, out) in [
        ("irradiance room.obj --photons 300k --points points.npy --quiet --out", "npy"),
        (
            "irradiance room.obj --photons 300k --points points.npy --quiet --estimator photon-map --out",
            "npy",
        ),
        ("render room.obj --photons 90k --passes 3 --size 64 64 --quiet --out", "png"),
    ] {
        run(at, &format!("{command} whole.{out}"));
        // A checkpoint after each range: the first has 65,536 photons.
        let with = "--checkpoint job.checkpoint --checkpoint-every 0.1";
        run(at, &format!("{command} job.{out} {with}"));
        same_bytes(at, &format!("job.{out}"), &format!("whole.{out}"));
        run(at, &format!("merge job.checkpoint --out merged.{out} --quiet"));
        same_bytes(at, &format!("merged.{out}"), &format!("whole.{out}"));
        fs::remove_file(at.join("job.checkpoint")).unwrap();
    }
    let said = refused(
        at,
        "irradiance room.obj --points points.npy --out e.npy --checkpoint c --load-map m --estimator photon-map",
    );
    assert!(said.contains("--load-map"), "{said}");
}
