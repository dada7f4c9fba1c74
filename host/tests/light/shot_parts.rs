//! Tests of `shoot --part` and `merge`: the bytes of one run, and a clear word where photons are missing or doubled.

use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

use arboleda_host::parts::PartFile;

use crate::program::{command_in, failure, folder, run_in, success};

const SCENE: [&str; 6] = ["shoot", "--scene", "fig2", "--photons", "20k", "--quiet"];

fn shoot(folder: &Path, more: &[&str]) -> String {
    success(&run_in(folder, &[&SCENE, more].concat())).0
}

/// The line of the digest, without what shot it.
fn digest(shown: &str) -> String {
    let line = shown.lines().find(|line| line.starts_with("digest of")).expect(shown);
    line.split(" by ").next().unwrap().to_owned()
}

#[test]
fn parts_give_the_bytes_of_one_run() {
    let folder = folder();
    let at = folder.path();
    let whole = shoot(at, &["--index", "octree", "--out", "whole.npy"]);
    for (range, file, index) in [
        ("7k..9001", "b.part", "wide-bvh"),
        ("0..7k", "a.part", "linear"),
        ("9_001..20_000", "c.part", "grid-hierarchy"),
    ] {
        shoot(at, &["--photon-range", range, "--part", file, "--index", index]);
    }
    let merge = ["merge", "c.part", "a.part", "b.part", "--out"];
    for out in ["merged.npy", "merged.csv"] {
        let (merged, _) = success(&run_in(at, &[&merge[..], &[out]].concat()));
        assert_eq!(digest(&merged), digest(&whole));
    }
    assert_eq!(fs::read(at.join("merged.npy")).unwrap(), fs::read(at.join("whole.npy")).unwrap());
    shoot(at, &["--out", "whole.csv"]);
    assert_eq!(fs::read(at.join("merged.csv")).unwrap(), fs::read(at.join("whole.csv")).unwrap());

    // Parts of parts.
    success(&run_in(at, &["merge", "b.part", "c.part", "--part", "rest.part"]));
    let (merged, _) = success(&run_in(at, &["merge", "rest.part", "a.part"]));
    assert_eq!(digest(&merged), digest(&whole));
    assert!(success(&run_in(at, &["merge", "rest.part", "a.part", "--missing"])).0.is_empty());
}

#[test]
fn missing_and_doubled_photons_are_named() {
    let folder = folder();
    let at = folder.path();
    for (range, file) in [("1k..2k", "a.part"), ("3k..4k", "b.part"), ("3999..5k", "c.part")] {
        shoot(at, &["--photon-range", range, "--part", file]);
    }
    let (missing, _) = success(&run_in(at, &["merge", "b.part", "a.part", "--missing"]));
    assert_eq!(missing, "0..1000\n2000..3000\n4000..20000\n");
    let said = failure(&run_in(at, &["merge", "b.part", "a.part"]));
    assert!(said.contains("photons 0..1000, 2000..3000, 4000..20000 are in no part"), "{said}");
    let said = failure(&run_in(at, &["merge", "b.part", "a.part", "--part", "all.part"]));
    assert!(said.contains("2000..3000"), "{said}");
    let said = failure(&run_in(at, &["merge", "a.part", "b.part", "c.part"]));
    assert!(said.contains("photons 3999..4000 are in b.part and in c.part"), "{said}");
    let said = failure(&run_in(at, &["merge", "a.part", "a.part", "--missing"]));
    assert!(said.contains("photons 1000..2000 are in a.part and in a.part"), "{said}");
}

#[test]
fn parts_of_other_jobs_are_refused() {
    let folder = folder();
    let at = folder.path();
    shoot(at, &["--photon-range", "0..1k", "--part", "a.part"]);
    for (job, difference) in [
        ("--scene fig2 --photons 20k --seed 2", "2 as seed, not 1"),
        ("--scene fig2 --photons 10k", "10000 photons in all, not 20000"),
        ("--scene fig2 --photons 20k --light 0,0,9,1,0,0,0,1,0,100", "other lights"),
        ("--scene fig3 --photons 20k", "12288 triangles, not"),
    ] {
        let part = "--photon-range 1k..2k --part b.part";
        let line = format!("shoot {job} {part}");
        success(&run_in(at, &line.split(' ').collect::<Vec<_>>()));
        let said = failure(&run_in(at, &["merge", "a.part", "b.part"]));
        assert!(said.contains("b.part is a part of another job than a.part"), "{said}");
        assert!(said.contains(difference), "{said}");
    }
}

#[test]
fn parts_of_another_version_of_the_program_are_refused() {
    let folder = folder();
    let at = folder.path();
    shoot(at, &["--photon-range", "0..1k", "--part", "a.part"]);
    shoot(at, &["--photon-range", "1k..2k", "--part", "b.part"]);
    let path = at.join("b.part");
    let mut file = PartFile::read(&path).unwrap();
    let part = file.read_part(&path).unwrap();
    file.job.program = "0.0.9".into();
    file.write(&path, &part.sums).unwrap();
    let said = failure(&run_in(at, &["merge", "a.part", "b.part"]));
    let version = env!("CARGO_PKG_VERSION");
    let difference = format!("version 0.0.9 of the program, not {version}");
    assert!(
        said.contains("b.part is a part of another job") && said.contains(&difference),
        "{said}"
    );
    // Nor does a job go on from it.
    let with = ["--photon-range", "1k..3k", "--part", "c.part", "--checkpoint", "b.part"];
    let said = failure(&run_in(at, &[&SCENE[..], &with].concat()));
    assert!(said.contains("b.part is the checkpoint of another job") && said.contains(&difference));
}

#[test]
fn torn_parts_and_wrong_ranges_are_refused() {
    let folder = folder();
    let at = folder.path();
    shoot(at, &["--photon-range", "0..1k", "--part", "a.part"]);
    let bytes = fs::read(at.join("a.part")).unwrap();
    fs::write(at.join("torn.part"), &bytes[..bytes.len() - 1]).unwrap();
    fs::write(at.join("text.part"), "photons").unwrap();
    for (file, problem) in
        [("torn.part", "torn"), ("text.part", "not a part"), ("none.part", "No such file")]
    {
        let said = failure(&run_in(at, &["merge", "a.part", file]));
        assert!(said.contains(file) && said.contains(problem), "{said}");
    }
    for (more, problem) in [
        (&["--photon-range", "0..30k", "--part", "x.part"][..], "there are 20000 photons in all"),
        (&["--photon-range", "5..5", "--part", "x.part"], "the range is empty"),
        (&["--photon-range", "0..1k"], "--part"),
        (&["--part", "x.part", "--out", "x.npy"], "--out"),
        (&["--part", "x.part", "--index", "all"], "--index all"),
        (&["--part", "x.part", "--counters"], "--counters"),
    ] {
        let said = failure(&run_in(at, &[&SCENE, more].concat()));
        assert!(said.contains(problem), "{said}");
        assert!(!at.join("x.part").exists());
    }
}

/// Shoots a job with a checkpoint, kills it once that is there, and returns what is still to be shot.
fn killed(at: &Path, command: &[&str]) -> String {
    let with = ["--checkpoint", "job.checkpoint", "--checkpoint-every", "0.1"];
    let mut job = command_in(at, &[command, &with].concat()).spawn().expect("the program starts");
    let begun = Instant::now();
    while !at.join("job.checkpoint").exists() {
        assert!(job.try_wait().unwrap().is_none(), "the job ended before its checkpoint");
        assert!(begun.elapsed() < Duration::from_secs(100), "no checkpoint");
        sleep(Duration::from_millis(2));
    }
    job.kill().unwrap();
    job.wait().unwrap();
    success(&run_in(at, &["merge", "job.checkpoint", "--missing"])).0
}

#[test]
fn a_killed_job_goes_on_from_its_checkpoint() {
    let folder = folder();
    let at = folder.path();
    let command = ["shoot", "--scene", "fig2", "--photons", "3M", "--quiet", "--index", "bvh"];
    let left = killed(at, &[&command[..], &["--out", "job.npy", "--threads", "1"]].concat());
    assert!(left.ends_with("..3000000\n") && !left.starts_with("0.."), "{left}");
    let before = fs::read(at.join("job.checkpoint")).unwrap();
    // Another job does not go on from it.
    let with = ["--checkpoint", "job.checkpoint"];
    let said = failure(&run_in(at, &[&command[..], &with, &["--seed", "2"]].concat()));
    assert!(said.contains("checkpoint of another job: it has 1 as seed, not 2"), "{said}");
    let range = ["--photon-range", "5k..3M", "--part", "x.part"];
    let said = failure(&run_in(at, &[&command[..], &with, &range].concat()));
    assert!(said.contains("not the first of 5000..3000000"), "{said}");
    assert_eq!(fs::read(at.join("job.checkpoint")).unwrap(), before);

    let go_on = [&command[..], &with, &["--out", "job.npy"]].concat();
    let (shown, _) = success(&run_in(at, &go_on));
    let (whole, _) = success(&run_in(at, &[&command[..], &["--out", "whole.npy"]].concat()));
    assert_eq!(digest(&shown), digest(&whole));
    assert_eq!(fs::read(at.join("job.npy")).unwrap(), fs::read(at.join("whole.npy")).unwrap());
    // A job that is done has nothing left, and its checkpoint is a part.
    assert_eq!(digest(&success(&run_in(at, &go_on)).0), digest(&whole));
    assert_eq!(digest(&success(&run_in(at, &["merge", "job.checkpoint"])).0), digest(&whole));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_named() {
    let folder = folder();
    for option in ["--part", "--checkpoint"] {
        let line = [&SCENE[..], &[option, "/dev/full"]].concat();
        let said = failure(&run_in(folder.path(), &line));
        assert!(said.contains("cannot write /dev/full"), "{said}");
    }
}
