//! `arboleda compare peers` as a person calls it.

use std::process::{Command, Output};

fn arboleda(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_arboleda"))
        .args(arguments)
        .env("EMBREE4_LIBRARY", "/there/is/no/such/library.so")
        .output()
        .expect("the program starts")
}

#[cfg(not(feature = "peers"))]
#[test]
fn a_build_without_the_libraries_says_how_to_get_them() {
    let output = arboleda(&["compare", "peers", "--out", "DIR"]);
    assert!(!output.status.success());
    let message = String::from_utf8(output.stderr).unwrap();
    let command =
        "cargo run --release -p arboleda-host --features peers -- compare peers --out DIR";
    assert!(message.contains(command), "{message}");
}

#[cfg(feature = "peers")]
#[test]
fn a_missing_library_is_absent_and_the_rest_is_written() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("compare-peers");
    let output = arboleda(&[
        "compare",
        "peers",
        "--scenes",
        "fig2,mesh-300",
        "--rays",
        "300",
        "--leak-rays",
        "300",
        "--repetitions",
        "1",
        "--index",
        "bvh,octree",
        "--growth",
        "1000",
        "--out",
        folder.to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    // 1. What is absent, and how to get it; at the end too.
    let shown = String::from_utf8(output.stdout).unwrap();
    let missing = "without embree4-medium, embree4-high, embree4-robust, embree4-compact: Embree 4 was not found";
    assert_eq!(shown.matches(missing).count(), 2, "{shown}");
    assert!(shown.contains("Python package `embreex`") && shown.contains("EMBREE4_LIBRARY"));

    // 2. The rows: of ours three modes, of the crates at least two; none of Embree.
    let rows = std::fs::read_to_string(folder.join("compare.csv")).unwrap();
    let mut lines = rows.lines();
    assert_eq!(
        lines.next(),
        Some(
            "scene,contender,mode,triangles,build_ms,bytes,mrays_median,mrays_min,mrays_max,\
             disagreements,leaks"
        )
    );
    for start in [
        "fig2,arboleda-bvh,single,",
        "fig2,octree,batch,",
        "mesh-300,arboleda-bvh,occluded,300,",
        "mesh-300,obvhs,single,300,",
        "mesh-300,parry3d,occluded,300,",
        "mesh-300,bvh,single,300,",
        "mesh-1000,arboleda-bvh,batch,",
        "city-1000,arboleda-bvh,single,",
    ] {
        assert_eq!(rows.lines().filter(|line| line.starts_with(start)).count(), 1, "{start}");
    }
    assert!(!rows.contains("embree"));
    // Leaks are counted where a mesh is closed, and ours has none; wrong answers neither.
    let ours = |line: &&str| [",arboleda-bvh,", ",octree,"].iter().any(|name| line.contains(name));
    for line in lines.filter(ours) {
        let end = if line.starts_with("mesh-300,") { ",0,0" } else { ",0," };
        assert!(line.ends_with(end), "{line}");
    }

    // 3. The page: every goal, every scene.
    let page = std::fs::read_to_string(folder.join("peers.md")).unwrap();
    for start in [
        "## `arboleda-bvh` against the others",
        "|  | fig2 | mesh-300 |",
        "| closest hit, batch / fastest Embree |",
        "| closest hit, single / fastest Embree, single |",
        "| occluded / fastest Embree |",
        "| closest hit, single / tinybvh |",
        "| closest hit, single / obvhs |",
        "| closest hit, single / parry3d |",
        "| closest hit, single / bvh |",
        "| triangles a second of the build / Embree medium |",
        "| bytes a triangle, and those of Embree medium |",
        "| wrong answers, and those of the fastest Embree |",
        "| leaks, and those of the fastest Embree and of Embree robust |",
        "### fig2, ",
        "### mesh-300, 300 triangles",
        "## Growth",
        "| city-1000 | arboleda-bvh |",
        "## Absent",
        "- without embree4-medium, ",
    ] {
        assert!(page.lines().any(|line| line.starts_with(start)), "{start}\n{page}");
    }
    assert!(page.contains("compare peers --scenes fig2,mesh-300"), "the command");
}

#[cfg(feature = "peers")]
#[test]
fn unknown_names_are_answered_with_the_names() {
    for (arguments, answer) in [
        (["--against", "raytracer"], "there are: embree4-medium, embree4-high"),
        (["--index", "raytracer"], "there are linear, octree,"),
    ] {
        let output = arboleda(&[&["compare", "peers"], &arguments[..]].concat());
        assert!(!output.status.success());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(answer), "{message}");
    }
}
