//! Tests of `--index-file`: the bytes of a run that loads the scene and builds the index, however many processes share
//! the files; and a clear word where they do not belong together.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::program::{command_line, failure, folder, same_bytes, success, write_rays};

/// A room far from the origin of its coordinates, without a lid, of two colours and objects; one face shines.
const ROOM: &str = "mtllib room.mtl
v 4000000 0 0\nv 4000003 0 0\nv 4000003 2 0\nv 4000000 2 0\nv 4000000 0 2\nv 4000003 0 2\nv 4000003 2 2\nv 4000000 2 2
v 4000001 0.5 1.9\nv 4000001 1.5 1.9\nv 4000002 1.5 1.9
o floor\nusemtl red\nf 1 2 3 4\no walls\nusemtl grey\nf 1 5 6 2\nf 4 3 7 8\nf 1 4 8 5\no lamp\nusemtl lamp\nf 9 10 11\n";
const MATERIALS: &str =
    "newmtl red\nKd 0.9 0.5 0.3\nnewmtl grey\nKd 0.6 0.6 0.6\nnewmtl lamp\nKe 9 8 5\n";

fn write_room(at: &Path) {
    fs::write(at.join("room.obj"), ROOM).unwrap();
    fs::write(at.join("room.mtl"), MATERIALS).unwrap();
    let points: Vec<[f64; 6]> = (0..24)
        .map(|place| {
            let [x, y] = [place % 6, place / 6].map(|step| f64::from(step) * 0.4 + 0.3);
            [4e6 + x, y, 0.0, 0.0, 0.0, 1.0]
        })
        .collect();
    write_rays(&at.join("points.npy"), &points);
    let rays: Vec<[f64; 6]> = (0..300)
        .map(|ray| [4e6 + f64::from(ray) * 0.01, 1.0, 5.0, 0.05, f64::from(ray % 7) * 0.1, -1.0])
        .collect();
    write_rays(&at.join("rays.npy"), &rays);
}

/// Prepares the program, which keeps its records in the folder.
fn command(at: &Path, line: &str) -> Command {
    println!("{line}");
    let mut command = command_line(at, line);
    command.env("XDG_RUNTIME_DIR", at.canonicalize().unwrap());
    command
}

fn run(at: &Path, line: &str) -> (String, String) {
    success(&command(at, line).output().unwrap())
}

fn refused(at: &Path, line: &str) -> String {
    failure(&command(at, line).output().unwrap())
}

/// Asserts that two runs of a job wrote the same, under two names in place of `O`.
fn same_output(at: &Path, output: &str, a: &str, b: &str) {
    let ending = if output.ends_with("pfm") { "npy.pfm" } else { "npy" };
    same_bytes(at, &format!("{a}.{ending}"), &format!("{b}.{ending}"));
}

/// Commands, the photons of each, and how they name their output.
const JOBS: [(&str, &str, &str); 6] = [
    ("shoot", "--photons 30k --up z", "--out O.npy"),
    ("shoot", "--photons 30k --up z --two-sided-lights", "--out O.npy"),
    ("irradiance", "--photons 30k --up z --points points.npy", "--out O.npy"),
    ("irradiance", "--photons 30k --points points.npy --estimator photon-map", "--out O.npy"),
    ("render", "--photons 15k --passes 2 --up z --size 64 64", "--out x.png --values O.npy.pfm"),
    (
        "render",
        "--photons 30k --size 64 64 --estimator photon-map --final-gather 3",
        "--out x.png --values O.npy.pfm",
    ),
];

#[test]
fn a_packed_scene_gives_the_bytes_of_its_scene() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    let scene = "room.obj --origin auto";
    let outputs = |output: &str, name: &str| output.replace('O', name);
    for (number, (job, options, output)) in JOBS.into_iter().enumerate() {
        let name = format!("whole{number}");
        run(at, &format!("{job} {scene} {options} {}", outputs(output, &name)));
    }
    let cast = |scene: &str, name: &str| {
        let files = format!("--hits {name}h.npy --points {name}p.npy --normals {name}n.npy");
        run(at, &format!("cast {scene} --rays rays.npy {files} --object-names {name}.csv"));
    };
    cast(scene, "whole");
    for kind in ["wide-bvh", "octree-hierarchy", "lean-bvh", "linear"] {
        run(at, &format!("pack {scene} --index {kind} -o room.arb"));
        // Nothing else is read.
        fs::rename(at.join("room.obj"), at.join("away.obj")).unwrap();
        for (number, (job, options, output)) in JOBS.into_iter().enumerate() {
            let packed = outputs(output, "packed");
            run(at, &format!("{job} --index-file room.arb {options} {packed}"));
            same_output(at, output, "packed", &format!("whole{number}"));
        }
        cast("--index-file room.arb", "packed");
        for file in ["h.npy", "p.npy", "n.npy", ".csv"] {
            same_bytes(at, &format!("packed{file}"), &format!("whole{file}"));
        }
        fs::rename(at.join("away.obj"), at.join("room.obj")).unwrap();
    }
}

#[test]
fn light_on_surfaces_and_other_lights() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    run(at, "pack room.obj --origin auto -o room.arb");
    let light = "--light 4000001,0.5,1.5,0,1,0,1,0,0,60";
    let command = format!(
        "shoot {light} --photons 5k --triangles T.npy --mesh-ply M.ply --photons-ply P.ply"
    );
    run(at, &format!("{command} room.obj --origin auto"));
    let names = ["T.npy", "M.ply", "P.ply"];
    let whole = names.map(|name| fs::read(at.join(name)).unwrap());
    run(at, &format!("{command} --index-file room.arb"));
    assert!(names.map(|name| fs::read(at.join(name)).unwrap()) == whole);
}

/// Processes that run at the same time, each with a part; other parts are shot from the scene itself.
#[test]
fn processes_share_a_packed_scene() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    run(at, "pack room.obj --origin auto --index compact-bvh -o room.arb");
    for (job, options, output) in JOBS {
        let whole = output.replace('O', "whole");
        let merged = output.replace('O', "merged");
        run(at, &format!("{job} room.obj --origin auto {options} {whole}"));
        let part = |part: u32, scene: &str| {
            let (start, end) = (part * 7_500, (part + 1) * 7_500);
            let with =
                format!("--photon-range {start}..{end} --part {part}.part --threads 1 --quiet");
            command(at, &format!("{job} {scene} {options} {with}"))
        };
        let started: Vec<_> =
            (0..3).map(|number| part(number, "--index-file room.arb").spawn().unwrap()).collect();
        for mut process in started {
            assert!(process.wait().unwrap().success());
        }
        assert!(part(3, "room.obj --origin auto").status().unwrap().success());
        // The first part says where the scene is; the merge may say it, too.
        let merges: &[&str] = if job == "shoot" { &[""] } else { &["", "--index-file room.arb"] };
        for more in merges {
            run(at, &format!("merge 3.part 0.part 2.part 1.part {merged} {more}"));
            same_output(at, output, "merged", "whole");
        }
    }
}

#[test]
fn what_does_not_belong_together_is_told() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    run(at, "pack room.obj --origin auto --index bvh -o room.arb");
    run(at, "pack --scene fig2 --index bvh -o other.arb");
    fs::copy(at.join("other.arb.scene"), at.join("wrong.arb.scene")).unwrap();
    fs::copy(at.join("room.arb"), at.join("wrong.arb")).unwrap();
    run(at, "pack --scene fig2 --index-only -o alone.arb");
    assert!(!at.join("alone.arb.scene").exists());
    for (arguments, said) in [
        ("--index-file wrong.arb", &["wrong.arb.scene: it is not the scene of wrong.arb"][..]),
        ("--index-file alone.arb", &["alone.arb.scene: cannot be read", "pack"]),
        ("--index-file none.arb", &["none.arb: cannot be read"]),
        ("--index-file room.obj", &["must end in .arb"]),
        ("room.obj --index-file room.arb", &["cannot be used with", "--index-file"]),
        ("--scene fig2 --index-file room.arb", &["cannot be used with"]),
        ("--index-file room.arb --index bvh", &["cannot be used with"]),
        ("--index-file room.arb --origin auto", &["cannot be used with"]),
        ("--index-file room.arb --level 3", &["cannot be used with"]),
        ("--scene fig2 --check", &["--index-file"]),
        ("room.arb", &["it is an index", "--index-file"]),
    ] {
        for job in [
            "shoot --photons 10",
            "irradiance --points points.npy --out x.npy",
            "render --out x.png",
        ] {
            let error = refused(at, &format!("{job} {arguments}"));
            assert!(said.iter().all(|said| error.contains(said)), "{job} {arguments}: {error}");
        }
    }
    // Parts of two packed scenes are of two jobs.
    for name in ["room", "other"] {
        let start = if name == "room" { 0 } else { 10 };
        let range = format!("--photon-range {start}..{} --part {name}.part", start + 10);
        run(at, &format!("shoot --index-file {name}.arb --photons 20 {range}"));
    }
    assert!(
        refused(at, "merge room.part other.part").contains("other.part is a part of another job")
    );
}

#[cfg(target_os = "linux")]
#[test]
fn the_first_process_validates() {
    let folder = folder();
    let at = folder.path();
    write_room(at);
    run(at, "pack room.obj --origin auto -o room.arb");
    std::thread::sleep(std::time::Duration::from_millis(3100));
    let line = "shoot --index-file room.arb --photons 100";
    let validates = |line: &str| run(at, line).1.contains("room.arb: validated");
    assert!(validates(line) && !validates(line) && !validates(line));
    assert!(validates(&format!("{line} --check")) && !validates(line));
    // Changed in place: its record is not of it any more.
    let mut scene = fs::read(at.join("room.arb.scene")).unwrap();
    *scene.last_mut().unwrap() ^= 1;
    fs::write(at.join("room.arb.scene"), &scene).unwrap();
    assert!(refused(at, line).contains("room.arb.scene: it is torn or was changed"));
    run(at, "pack room.obj --origin auto -o room.arb");
    assert!(validates(line));
}
