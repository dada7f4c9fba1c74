//! Tests of every command: help, option values, outputs, silence.

use std::fs;

mod program;

use program::{command_in, failure, folder, names, run_in, success};

/// Arguments that name the scene that loads the fastest.
const SCENE: [&str; 2] = ["--scene", "fig2"];

fn with_scene<'a>(command: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[command], &SCENE[..], more].concat()
}

#[test]
fn help_tells_layouts_ranges_and_indices() {
    let folder = folder();
    for (command, parts) in [
        (
            "cast",
            &[
                "float32 or float64 of shape (N, 6)",
                "('triangle','<u4')",
                "0xFFFFFFFF",
                "counter-clockwise",
            ][..],
        ),
        ("shoot", &["('front_photons','<u8')", "('back_flux','<f8')", "1e6", "in watts"]),
        ("inspect", &["64 to 8192", "with --picture, paint the clusters"]),
        (
            "irradiance",
            &[
                "('irradiance','<f4',(3,))",
                "('standard_error','<f4')",
                "float32 or float64 of shape (N, 6)",
                "mid-air",
            ],
        ),
        ("render", &["64 to 8192", "stderr", "the paper's rule", "--two-sided-lights"]),
        ("compare", &["--studies", "growth", "separation"]),
        ("paper", &["figure 3"]),
        ("separation", &["10,000 times"]),
    ] {
        let (shown, _) = success(&run_in(folder.path(), &[command, "--help"]));
        // Help is wrapped at any word, so white space is normalised.
        let flat = shown.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in parts {
            assert!(flat.contains(part), "{command}: {part}\n{shown}");
        }
    }
    for command in ["cast", "shoot", "inspect", "irradiance", "render"] {
        let (shown, _) = success(&run_in(folder.path(), &[command, "--help"]));
        for name in arboleda_host::kind_names().chain(["auto", "all"]) {
            assert!(shown.contains(&format!("- {name}:")), "{command}: {name}\n{shown}");
        }
    }
}

#[test]
fn values_out_of_range_are_refused_with_the_range() {
    let folder = folder();
    for (arguments, message) in [
        (with_scene("shoot", &["--photons", "0"]), "must be 1 to 1000000000000000"),
        (with_scene("shoot", &["--photons", "-5"]), "invalid value '-5' for '--photons <N>'"),
        (with_scene("shoot", &["--photons", "1e99"]), "must be 1 to 1000000000000000"),
        (with_scene("shoot", &["--photons", "lots"]), "write it as 1000000, 1_000_000, 1e6 or 1M"),
        (with_scene("shoot", &["--threads", "5000"]), "must be 1 to "),
        (with_scene("shoot", &["--threads", "0"]), "must be 1 to "),
        (with_scene("shoot", &["--level", "21"]), "must be 0 to 20"),
        (with_scene("shoot", &["--level", "-1"]), "invalid value '-1' for '--level <N>'"),
        (with_scene("shoot", &["--leaf-capacity", "0"]), "must be 1 to 4294967295"),
        (with_scene("shoot", &["--proximity", "nan"]), "must be 0 to 1000000"),
        (with_scene("shoot", &["--proximity", "-0.5"]), "must be 0 to 1000000"),
        (with_scene("shoot", &["--size-classes", "5"]), "must be 1 to 4"),
        (with_scene("shoot", &["--cells-per-triangle", "inf"]), "must be 0.001 to 1024"),
        (with_scene("shoot", &["--index", "octre"]), "a similar value exists: 'octree'"),
        (with_scene("shoot", &["--seed", "-1"]), "invalid value '-1' for '--seed <N>'"),
        (with_scene("inspect", &["--size", "0", "0"]), "must be 64 to 8192"),
        (with_scene("inspect", &["--size", "100000", "100000"]), "must be 64 to 8192"),
        (with_scene("inspect", &["--picture", "x.jpg"]), "the name must end in .png"),
        (with_scene("shoot", &["--picture", "x"]), "the name must end in .png"),
        (with_scene("shoot", &["--out", "hits.txt"]), "the name must end in .npy or .csv"),
        (vec!["--photons", "0"], "must be 1 to "),
        (vec!["--picture", "x.jpg"], "the name must end in .png"),
        (vec!["compare", "--repetitions", "0"], "must be 1 to 10000"),
        (vec!["compare", "--photons", "0"], "must be 1 to 10000000"),
        (vec!["compare", "peers", "--rays", "0"], "must be 1 to 100000000"),
        (vec!["paper", "--repetitions", "0"], "must be 1 to 10000"),
        (vec!["separation", "--repetitions", "0"], "must be 1 to 10000"),
    ] {
        let said = failure(&run_in(folder.path(), &arguments));
        assert!(said.contains(message), "{arguments:?}\n{said}");
        assert!(!said.contains("to pass '-"), "a tip that does not help: {said}");
    }
    assert!(names(folder.path()).is_empty());
}

#[test]
fn options_that_would_do_nothing_are_refused() {
    let folder = folder();
    let light = "0,0,9,1,0,0,0,1,0,5";
    for (arguments, message) in [
        (&["--ply-limit", "5"][..], "required arguments were not provided:\n  --photons-ply"),
        (&["--two-sided-lights", "--light", light], "cannot be used with"),
    ] {
        let said = failure(&run_in(folder.path(), &with_scene("shoot", arguments)));
        assert!(said.contains(message), "{arguments:?}\n{said}");
    }
}

#[test]
fn a_light_that_cannot_shine_is_refused_by_name() {
    let folder = folder();
    for (light, message) in [
        ("0,0,9,1,0,0,0,1,0", "ten numbers are needed, 9 were given"),
        ("0,0,9,1,0,0,0,1,0,nan", "FLUX is `nan`, which is not finite"),
        ("0,0,9,1,0,0,0,-inf,0,5", "VY is `-inf`, which is not finite"),
        ("-1e39,0,9,1,0,0,0,1,0,5", "CX is `-1e39`, which is not finite"),
        ("0,0,nine,1,0,0,0,1,0,5", "CZ is `nine`, which is not a number"),
        ("0,0,9,1,0,0,0,1,0,-5", "FLUX is -5; it must be above 0"),
        ("0,0,9,1,0,0,0,1,0,0", "FLUX is 0; it must be above 0"),
        ("0,0,9,1,2,3,-2,-4,-6,5", "the light has no area"),
        ("0,0,9,0,0,0,0,1,0,5", "the light has no area"),
    ] {
        let said = failure(&run_in(folder.path(), &with_scene("shoot", &["--light", light])));
        assert!(said.contains(message) && said.contains("--light"), "{light}\n{said}");
    }
}

#[test]
fn counts_are_read_as_people_write_them() {
    let folder = folder();
    for photons in ["2e3", "2_000", "2k", "2000"] {
        let arguments = with_scene("shoot", &["--index", "bvh", "--photons", photons]);
        let (shown, _) = success(&run_in(folder.path(), &arguments));
        assert!(shown.contains("2,000 photons"), "{photons}\n{shown}");
    }
}

#[test]
fn outputs_are_checked_before_the_work() {
    let folder = folder();
    fs::create_dir(folder.path().join("taken.png")).unwrap();
    // The scene takes minutes to make, so the test ends quickly only if a missing folder is reported before loading.
    let large = ["--scene", "mesh-100000000"];
    for (arguments, message) in [
        (["shoot", "--picture", "no/x.png"], "cannot write no/x.png: there is no folder no"),
        (["shoot", "--out", "no/x.npy"], "cannot write no/x.npy: there is no folder no"),
        (["inspect", "--picture", "taken.png"], "cannot write taken.png: it is a folder"),
    ] {
        let said = failure(&run_in(folder.path(), &[&arguments, &large[..]].concat()));
        assert!(said.contains(message), "{arguments:?}\n{said}");
    }
    let said = failure(&run_in(folder.path(), &["separation", "--csv", "no/x.csv"]));
    assert!(said.contains("there is no folder no"), "{said}");
    fs::write(folder.path().join("plain"), "no folder").unwrap();
    for command in ["compare", "paper"] {
        let said = failure(&run_in(folder.path(), &[command, "--out", "plain"]));
        assert!(said.contains("cannot write into the folder plain"), "{command}\n{said}");
    }
}

#[test]
fn outputs_are_other_files_than_inputs_and_each_other() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("in")).unwrap();
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    fs::write(at("in/s.ply"), text).unwrap();
    program::write_rays(&at("r.npy"), &[[0.2_f32, 0.2, 1.0, 0.0, 0.0, -1.0]]);
    let rays = fs::read(at("r.npy")).unwrap();
    let read = "the command reads it";
    let twice = "two outputs would be written to";
    for (line, message) in [
        ("shoot in/s.ply --mesh-ply in/s.ply", read),
        ("shoot in --mesh-ply in/../in/s.ply", read),
        ("shoot in/s.ply --out a.npy --triangles ./a.npy", twice),
        ("shoot in/s.ply --mesh-ply a.ply --photons-ply in/../a.ply", twice),
        ("shoot in/s.ply --part in/s.ply", read),
        ("cast in/s.ply --rays r.npy --hits ./r.npy", read),
        ("cast in/s.ply --rays r.npy --hits a.npy --points a.offsets.npy --query all", twice),
        ("irradiance in/s.ply --points r.npy --out r.npy", read),
        ("irradiance in/s.ply --points r.npy --out a.npy --checkpoint a.npy", twice),
        ("render in/s.ply --out a.png --estimator photon-map --save-map a.png", twice),
        ("render in/s.ply --out a.png --checkpoint in/s.ply", read),
        ("merge r.npy --out a.npy --save-map a.npy", twice),
        ("merge r.npy --out r.npy", read),
    ] {
        let said = failure(&program::command_line(folder.path(), line).output().unwrap());
        assert!(said.contains(message), "{line}\n{said}");
    }
    assert_eq!(names(folder.path()), ["in", "r.npy"]);
    assert_eq!(fs::read_to_string(at("in/s.ply")).unwrap(), text);
    assert_eq!(fs::read(at("r.npy")).unwrap(), rays);
}

#[test]
fn a_range_of_photons_is_for_a_part() {
    let folder = folder();
    program::write_rays(&folder.path().join("p.npy"), &[[0.0_f32, 0.0, 0.0, 0.0, 0.0, 1.0]]);
    for line in [
        "shoot --scene fig2",
        "shoot --scene fig2 --out a.npy",
        "irradiance --scene fig2 --points p.npy --out a.npy",
        "render --scene fig2 --out a.png",
    ] {
        let line = format!("{line} --photons 10 --photon-range 0..5");
        let said = failure(&program::command_line(folder.path(), &line).output().unwrap());
        assert!(said.contains("--part"), "{line}\n{said}");
    }
    assert_eq!(names(folder.path()), ["p.npy"]);
}

#[test]
fn files_are_written_only_where_asked() {
    let folder = folder();
    let (_, said) = success(&run_in(folder.path(), &with_scene("inspect", &["--index", "bvh"])));
    assert!(said.contains("--picture"), "says how to get one: {said}");
    assert!(names(folder.path()).is_empty());
    let arguments = ["--index", "bvh", "--picture", "a.png", "--size", "320", "200"];
    let (_, said) = success(&run_in(folder.path(), &with_scene("inspect", &arguments)));
    assert!(said.contains("picture: a.png"), "{said}");
    assert_eq!(names(folder.path()), ["a.png"]);
    let png = fs::read(folder.path().join("a.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG") && png.ends_with(b"IEND\xaeB`\x82"), "a whole file");
    assert_eq!(png[16..24], [0, 0, 1, 64, 0, 0, 0, 200]);
}

#[cfg(target_os = "linux")]
#[test]
fn names_of_files_need_not_be_unicode() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = folder();
    let name = OsStr::from_bytes(b"caf\xe9.png");
    let arguments = with_scene("inspect", &["--index", "bvh", "--picture"]);
    let output = command_in(folder.path(), &arguments).arg(name).output().unwrap();
    success(&output);
    assert!(folder.path().join(name).is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_a_failure() {
    let folder = folder();
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for arguments in [with_scene("shoot", &["--photons", "10"]), vec!["--help"], vec!["--version"]]
    {
        let output = command_in(folder.path(), &arguments).stdout(full()).output().unwrap();
        let _ = failure(&output);
    }
    let output = command_in(folder.path(), &with_scene("inspect", &[])).stdout(full()).output();
    let said = failure(&output.unwrap());
    assert!(said.contains("cannot write the results: No space left on device"), "{said}");
}

#[test]
fn quiet_leaves_results_and_errors() {
    let folder = folder();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n";
    fs::write(folder.path().join("a.obj"), obj).unwrap();
    let shoot = ["shoot", "a.obj", "--photons", "100", "--picture", "a.png", "--out", "a.csv"];
    let (loud_shown, loud) = success(&run_in(folder.path(), &shoot));
    for part in ["warning: ", "estimated", "picture: a.png", "a.csv"] {
        assert!(loud.contains(part), "{part}\n{loud}");
    }
    let (shown, said) = success(&run_in(folder.path(), &[&shoot[..], &["--quiet"]].concat()));
    assert_eq!(said, "");
    let digest =
        |text: &str| text.lines().find(|line| line.starts_with("digest")).map(str::to_owned);
    assert!(digest(&shown).is_some());
    assert_eq!(digest(&shown), digest(&loud_shown));
    let said = failure(&run_in(folder.path(), &["inspect", "--quiet", "no-such.obj"]));
    assert_eq!(said.matches("No such file or directory").count(), 1, "{said}");
}

#[test]
fn options_before_a_command_are_for_all_commands_or_refused() {
    let folder = folder();
    let arguments = ["--quiet", "shoot", "--scene", "fig2", "--photons", "100"];
    let (_, said) = success(&run_in(folder.path(), &arguments));
    assert_eq!(said, "");
    let arguments = ["--photons", "100", "shoot", "--scene", "fig2"];
    let said = failure(&run_in(folder.path(), &arguments));
    assert!(said.contains("--photons before `shoot`"), "{said}");
    for (arguments, message) in [
        (["compare", "--photons=100", "levels"], "--photons before `levels`"),
        (["compare", "a.obj", "peers"], "SCENE before `peers`"),
    ] {
        let said = failure(&run_in(folder.path(), &arguments));
        assert!(said.contains(message), "{arguments:?}\n{said}");
    }
}

#[test]
fn all_indices_share_one_digest_and_the_linear_scan_says_what_it_shot() {
    let folder = folder();
    let arguments = with_scene("shoot", &["--index", "all", "--photons", "1000"]);
    let (shown, said) = success(&run_in(folder.path(), &arguments));
    assert!(said.contains("linear shoots only the first 256 photons"), "{said}");
    let digests: Vec<&str> = shown.lines().filter(|line| line.starts_with("digest")).collect();
    let others = arboleda_host::kind_names().count() - 1;
    let [whole, part] = digests[..] else { panic!("{shown}") };
    let starts = whole.starts_with("digest of 1,000 photons: ");
    assert!(starts && whole.ends_with(&format!("the same by all {others} indices")), "{whole}");
    assert!(part.starts_with("digest of the first 256: "), "{part}");
    assert!(part.ends_with(&format!("the same by all {others} and linear")), "{part}");
}

#[test]
fn a_comparison_page_has_only_what_is_asked_for() {
    let folder = folder();
    let compare = ["compare", "--scenes", "fig2", "--photons", "50", "--repetitions", "1"];
    let (_, said) = success(&run_in(folder.path(), &[&compare[..], &["--out", "page"]].concat()));
    assert!(said.contains("page: page/index.html"), "{said}");
    let files = names(&folder.path().join("page"));
    assert_eq!(files, ["compare.csv", "fig2.clusters.png", "index.html"]);
    let page = fs::read_to_string(folder.path().join("page/index.html")).unwrap();
    assert!(page.contains("--photons 50 --repetitions 1 --seed 1 --out DIR. "), "the command");
    assert!(page.contains("Photons per second") && !page.contains("Cost against triangle count"));
    let said = failure(&run_in(folder.path(), &[&compare[..], &["--studies", "growth"]].concat()));
    assert!(said.contains("--out"), "{said}");
}
