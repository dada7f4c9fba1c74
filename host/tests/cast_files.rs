//! Tests of the files of `arboleda cast` and `arboleda shoot --out`, read as `NumPy` reads them.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

mod program;

use program::{failure, folder, names, run_in, success, write_rays};
use tempfile::TempDir;

/// Scene file: a square at z = 1 of two triangles whose front is above, and a triangle at z = 0 whose front is below.
const SCENE: &str = "\
v 0 0 1\nv 2 0 1\nv 2 2 1\nv 0 2 1\nv 0 0 0\nv 2 0 0\nv 0 2 0\n\
o roof, new\nf 1 2 3 4\no floor\nf 5 7 6\n";

/// Rays: one hits the first triangle from above, one the second from below, beside the floor; one misses; one is not
/// valid.
const RAYS: [[f32; 6]; 4] = [
    [1.5, 0.5, 3.0, 0.0, 0.0, -2.0],
    [0.5, 1.75, -1.0, 0.0, 0.0, 1.0],
    [9.0, 9.0, 9.0, 0.0, 0.0, 1.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
];

/// Arguments that cast the rays through the scene.
const CAST: [&str; 4] = ["cast", "a.obj", "--rays", "rays.npy"];

#[derive(npyz::Deserialize, Debug, PartialEq)]
struct Hit {
    triangle: u32,
    t: f32,
    u: f32,
    v: f32,
}

#[derive(npyz::Deserialize, Debug, PartialEq)]
struct Received {
    front_photons: u64,
    back_photons: u64,
    front_flux: f64,
    back_flux: f64,
}

/// Makes a folder with the scene and the rays.
fn folder_with_scene() -> TempDir {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), SCENE).unwrap();
    write_rays(&folder.path().join("rays.npy"), &RAYS);
    folder
}

/// Runs `cast` with options; returns its stdout and stderr.
fn cast(folder: &TempDir, options: &[&str]) -> (String, String) {
    success(&run_in(folder.path(), &[&CAST, options].concat()))
}

fn read<T: npyz::Deserialize>(path: &Path) -> (Vec<u64>, Vec<T>) {
    let npy = npyz::NpyFile::new(fs::File::open(path).unwrap()).unwrap();
    (npy.shape().to_vec(), npy.into_vec().unwrap())
}

/// Reads rows of three numbers. NaN becomes `f32::MAX`, which can be compared.
fn read_rows(path: &Path) -> Vec<[f32; 3]> {
    let (shape, values) = read::<f32>(path);
    assert_eq!(shape[1..], [3]);
    let row =
        |row: &[f32]| std::array::from_fn(|at| if row[at].is_nan() { f32::MAX } else { row[at] });
    values.chunks_exact(3).map(row).collect()
}

/// Row of a miss, as [`read_rows`] reads it.
const MISS: [f32; 3] = [f32::MAX; 3];

#[test]
fn hits_points_normals_and_objects() {
    let folder = folder_with_scene();
    let at = |name: &str| folder.path().join(name);
    let outputs =
        ["--hits", "h.npy", "--points", "p.npy", "--normals", "n.npy", "--object-names", "o.csv"];
    let (shown, said) = cast(&folder, &outputs);
    assert_eq!(shown, "");
    assert!(said.contains("-> h.npy, p.npy, n.npy"), "{said}");

    let (_, hits) = read::<Hit>(&at("h.npy"));
    let miss = || Hit { triangle: u32::MAX, t: f32::INFINITY, u: 0.0, v: 0.0 };
    let [first, second, third, fourth] = &hits[..] else { panic!("{hits:?}") };
    assert_eq!((first.triangle, first.t), (0, 1.0));
    assert_eq!((second.triangle, second.t), (1, 2.0));
    assert_eq!([third, fourth], [&miss(); 2]);
    let points = read_rows(&at("p.npy"));
    assert_eq!(points, [[1.5, 0.5, 1.0], [0.5, 1.75, 1.0], MISS, MISS]);
    let normals = read_rows(&at("n.npy"));
    assert_eq!(normals, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], MISS, MISS]);
    let objects = fs::read_to_string(at("o.csv")).unwrap();
    assert_eq!(objects, "first_triangle,triangle_count,object\n0,2,\"roof, new\"\n2,1,floor\n");

    // With `--query all` each hit has a row. `--points` works without `--hits`.
    cast(&folder, &["--points", "all.npy", "--query", "all"]);
    let points = read_rows(&at("all.npy"));
    assert_eq!(points, [[1.5, 0.5, 1.0], [1.5, 0.5, 0.0], [0.5, 1.75, 1.0]]);
    assert_eq!(read::<u64>(&at("all.offsets.npy")).1, [0, 2, 3, 3, 3]);
}

#[test]
fn every_index_writes_the_same_bytes() {
    let folder = folder_with_scene();
    cast(&folder, &["--hits", "h.npy", "--normals", "n.npy", "--index", "all"]);
    for stem in ["h", "n"] {
        let files = arboleda_host::kind_names().map(|kind| format!("{stem}.{kind}.npy"));
        let mut contents = files.map(|name| fs::read(folder.path().join(name)).unwrap());
        let first = contents.next().unwrap();
        assert!(contents.all(|other| other == first));
    }
}

#[test]
fn wrong_options_are_refused_before_anything_is_written() {
    let folder = folder_with_scene();
    let before = names(folder.path());
    for (more, message) in [
        (&[][..], "--hits"),
        (&["--hits", "h.npy", "--points", "h.npy"], "two outputs would be written to h.npy"),
        (&["--points", "p.npy", "--query", "occluded"], "--query occluded finds no hit points"),
        (&["--hits", "h.npy", "--object-names", "o.json"], "the name must end in .csv"),
        (&["--hits", "h.txt"], "the name must end in .npy"),
        (&["--points", "p.csv"], "the name must end in .npy"),
        (&["--hits", "h.npy", "--normals", "no/n.npy"], "there is no folder no"),
    ] {
        let said = failure(&run_in(folder.path(), &[&CAST, more].concat()));
        assert!(said.contains(message), "{more:?}\n{said}");
    }
    assert_eq!(names(folder.path()), before);
}

#[test]
fn a_name_without_an_ending_is_taken() {
    let folder = folder_with_scene();
    success(&run_in(folder.path(), &[&CAST[..], &["--hits", "h"]].concat()));
    assert!(names(folder.path()).contains(&"h".to_owned()));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_a_failure() {
    let folder = folder_with_scene();
    for option in ["--hits", "--points", "--normals"] {
        let said = failure(&run_in(folder.path(), &[&CAST[..], &[option, "/dev/full"]].concat()));
        assert!(said.contains("error: cannot write /dev/full: No space left"), "{said}");
    }
}

#[test]
fn photons_and_flux_are_told_by_side() {
    let folder = folder_with_scene();
    let at = |name: &str| folder.path().join(name);
    // The light shines up from between the floor, whose front is below, and the roof, whose front is above.
    let light = "0.5,0.5,0.5,0.1,0,0,0,0.1,0,8";
    let arguments = |out| ["shoot", "a.obj", "--light", light, "--photons", "1000", "--out", out];
    success(&run_in(folder.path(), &arguments("f.npy")));
    success(&run_in(folder.path(), &arguments("f.csv")));
    let (shape, rows) = read::<Received>(&at("f.npy"));
    assert_eq!(shape, [3]);
    let [first, second, floor] = &rows[..] else { panic!("{rows:?}") };
    for roof in [first, second] {
        assert_eq!(roof.front_photons, 0);
        assert!(roof.back_photons > 100, "{roof:?}");
        assert_eq!(roof.back_flux, roof.back_photons as f64 * (8.0 / 1000.0));
    }
    assert_eq!(floor.front_photons, 0);
    assert!(floor.back_photons > 10 && floor.front_flux == 0.0, "{floor:?}");

    let table = fs::read_to_string(at("f.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("triangle,front_photons,back_photons,front_flux,back_flux"));
    for (triangle, row) in rows.iter().enumerate() {
        let cells: Vec<f64> =
            lines.next().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
        let counts = [row.front_photons as f64, row.back_photons as f64];
        let [front, back] = counts;
        assert_eq!(cells, [triangle as f64, front, back, row.front_flux, row.back_flux]);
    }
}

/// Runs the Python example of the package's page, if Python and `NumPy` are installed.
#[test]
fn the_example_in_python_runs() {
    let page = include_str!("../README.md");
    let (_, after) = page.split_once("```python\n").expect("an example in Python");
    let (example, _) = after.split_once("```").expect("its end");
    let python = |code: &str, folder: &Path| {
        let program = Path::new(env!("CARGO_BIN_EXE_arboleda"));
        let path = std::env::join_paths(
            std::iter::once(program.parent().unwrap().to_path_buf())
                .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
        );
        let mut command = Command::new("python3");
        command.args(["-c", code]).current_dir(folder).env("PATH", path.unwrap());
        command.stdin(Stdio::null()).output()
    };
    let folder = folder();
    if !python("import numpy", folder.path()).is_ok_and(|output| output.status.success()) {
        println!("not run: there is no python3 with numpy");
        return;
    }
    let (shown, _) = success(&python(example, folder.path()).unwrap());
    assert!(shown.starts_with("10000 rays, "), "{shown}");
}
