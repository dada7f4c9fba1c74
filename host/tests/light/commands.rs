//! Tests of the light: `irradiance`, `render` and the files of `shoot`, with hostile input.

use std::fs;
use std::path::Path;

use crate::program::{failure, folder, names, run_in, success, write_rays};

/// A floor under the default lamp, and a sliver without area.
const SCENE: &str = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 1\nv 2 2 2\nf 1 2 3 4\nf 1 5 6\n";

fn arguments<'a>(words: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    words.split_whitespace().chain(more.iter().copied()).collect()
}

fn write_scene(folder: &Path) {
    fs::write(folder.join("s.obj"), SCENE).unwrap();
}

/// Reads the rows after the header of a `.npy` file of estimates: irradiance, count, radius, error.
fn estimates(path: &Path) -> Vec<([f32; 3], u32, f32, f32)> {
    let bytes = fs::read(path).unwrap();
    let header = String::from_utf8_lossy(&bytes[10..10 + usize::from(bytes[8])]).into_owned();
    for part in [
        "('irradiance', '<f4', (3,))",
        "('count', '<u4')",
        "('radius', '<f4')",
        "('standard_error', '<f4')",
    ] {
        assert!(header.replace("  ", " ").contains(part), "{part}: {header}");
    }
    let data = &bytes[10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]))..];
    let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
    let row = |row: &[u8]| {
        let irradiance = [0, 4, 8].map(|at| float(&row[at..at + 4]));
        let count = u32::from_le_bytes(row[12..16].try_into().unwrap());
        (irradiance, count, float(&row[16..20]), float(&row[20..24]))
    };
    assert_eq!(data.len() % 24, 0);
    data.chunks_exact(24).map(row).collect()
}

#[test]
fn irradiance_of_points_is_the_same_by_every_index_and_number_of_threads() {
    let folder = folder();
    write_scene(folder.path());
    let mut points: Vec<[f32; 6]> =
        (0..40).map(|at| [0.1 * at as f32, 2.0, 0.0, 0.0, 0.0, 2.0]).collect();
    // In mid-air, from below, off the scene; not valid: NaN, and a normal of 0.
    points.extend([
        [2.0, 2.0, 1.0, 0.0, 0.0, 1.0],
        [2.0, 2.0, 0.0, 0.0, 0.0, -1.0],
        [99.0, 2.0, 0.0, 0.0, 0.0, 1.0],
        [f32::NAN, 2.0, 0.0, 0.0, 0.0, 1.0],
        [2.0, 2.0, 0.0, 0.0, 0.0, 0.0],
    ]);
    write_rays(&folder.path().join("p.npy"), &points);
    let run = |more: &str| {
        let words = "irradiance s.obj --up z --points p.npy --out e.npy --photons 20000";
        let all = format!("{words} {more}");
        let (shown, said) = success(&run_in(folder.path(), &arguments(&all, &[])));
        assert!(shown.contains("45 points"), "{shown}");
        assert!(said.contains("2 of 45 points are not valid"), "{said}");
        (estimates(&folder.path().join("e.npy")), fs::read(folder.path().join("e.npy")).unwrap())
    };
    for estimator in
        ["--estimator detp --radius 0.2", "--estimator photon-map --k 30 --max-radius 0.5"]
    {
        let (rows, bytes) = run(&format!("{estimator} --index linear --threads 1"));
        assert!(rows[20].0[0] > 0.0 && rows[20].1 > 20 && rows[20].3 > 0.0, "{:?}", rows[20]);
        assert_eq!(rows[20].0, [rows[20].0[0]; 3]);
        for dark in &rows[41..] {
            assert_eq!((dark.0, dark.1), ([0.0; 3], 0));
        }
        let in_mid_air = rows[40].1;
        assert_eq!(in_mid_air > 0, estimator.contains("detp"), "{in_mid_air}");
        for more in ["--index octree --threads 2", "--index wide-bvh --threads 3", "--threads 8"] {
            assert_eq!(run(&format!("{estimator} {more}")).1, bytes, "{estimator} {more}");
        }
    }
    // Extremes: a dark scene, k above the number of hits, a radius larger than the scene, the smallest one.
    for (more, lit) in [
        ("--photons 0", false),
        ("--estimator photon-map --k 100000000 --max-radius 9", true),
        ("--radius 1e9", true),
        ("--radius 1e-44", false),
        ("--domain disc --kernel epanechnikov --bounces indirect --beyond 0.1", false),
    ] {
        let words = "irradiance s.obj --up z --points p.npy --out e.npy --photons 2000";
        let words: Vec<&str> = if more.contains("--photons") {
            words.split_whitespace().filter(|word| !["--photons", "2000"].contains(word)).collect()
        } else {
            words.split_whitespace().collect()
        };
        let all: Vec<&str> = words.into_iter().chain(more.split_whitespace()).collect();
        success(&run_in(folder.path(), &all));
        for row in estimates(&folder.path().join("e.npy")) {
            assert!(row.0.iter().all(|value| value.is_finite()) && row.3.is_finite(), "{more}");
        }
        let sum: u32 = estimates(&folder.path().join("e.npy")).iter().map(|row| row.1).sum();
        assert_eq!(sum > 0, lit, "{more}");
    }
}

#[test]
fn wrong_options_of_estimates_are_refused_by_name() {
    let folder = folder();
    write_scene(folder.path());
    write_rays(&folder.path().join("p.npy"), &[[0.0_f32, 0.0, 0.0, 0.0, 0.0, 1.0]]);
    for (more, message) in [
        ("--radius 0", "must be finite and above 0"),
        ("--radius nan", "must be finite and above 0"),
        ("--radius inf", "must be finite and above 0"),
        ("--radius -1", "must be finite and above 0"),
        ("--radius big", "not a number"),
        ("--estimator photon-map --k 2", "must be 3 to 100000000"),
        ("--estimator photon-map --k 9 --radius 1", "cannot be used with"),
        ("--estimator photon-map --k 9 --domain visible", "give --radius instead of --k"),
        ("--estimator photon-map --beyond 1", "--beyond is for --estimator detp"),
        ("--k 9", "--k is for photon maps"),
        ("--max-radius 9", "--max-radius is for the k nearest"),
        ("--save-map m", "detp stores no photons"),
        ("--normal-angle 91", "must be 0 to 90"),
        ("--normal-angle 9", "--normal-angle is for photon maps"),
        ("--beyond nan", "must be 0 to 1000"),
        ("--index all", "--index all is for comparisons"),
        ("--light 0,0,1,1,0,0,0,1,0,0", "FLUX is 0"),
    ] {
        let words = format!("irradiance s.obj --points p.npy --out e.npy --photons 100 {more}");
        let said = failure(&run_in(folder.path(), &arguments(&words, &[])));
        assert!(said.contains(message), "{more}\n{said}");
    }
    write_rays(&folder.path().join("q.npy"), &[[0.0_f64; 6]; 0]);
    fs::write(folder.path().join("text.npy"), "1 2 3").unwrap();
    for (points, message) in
        [("none.npy", "cannot be read"), ("text.npy", "it is not a .npy file; save the points")]
    {
        let words = format!("irradiance s.obj --points {points} --out e.npy");
        let said = failure(&run_in(folder.path(), &arguments(&words, &[])));
        assert!(said.contains(message), "{said}");
    }
    let words = "irradiance s.obj --points q.npy --out e.npy --photons 100";
    let (shown, _) = success(&run_in(folder.path(), &arguments(words, &[])));
    assert!(shown.contains("0 points"), "{shown}");
}

#[test]
fn photon_maps_are_kept_and_used_again() {
    let folder = folder();
    write_scene(folder.path());
    write_rays(&folder.path().join("p.npy"), &[[2.0_f32, 2.0, 0.0, 0.0, 0.0, 1.0]]);
    let words =
        "irradiance s.obj --up z --points p.npy --estimator photon-map --k 50 --photons 5000";
    let run = |more: &str| {
        let all = format!("{words} --out e.npy {more}");
        success(&run_in(folder.path(), &arguments(&all, &[])));
        fs::read(folder.path().join("e.npy")).unwrap()
    };
    let (plain, saved) = (run(""), run("--save-map m.map"));
    assert_eq!((&plain, &plain), (&saved, &run("--load-map m.map")));
    let all = format!("{words} --out e.npy --load-map p.npy");
    let said = failure(&run_in(folder.path(), &arguments(&all, &[])));
    assert!(said.contains("it is not a photon map"), "{said}");
    let all = words.replace("s.obj --up z", "--scene fig2") + " --out e.npy --load-map m.map";
    let said = failure(&run_in(folder.path(), &arguments(&all, &[])));
    assert!(said.contains("those of another scene"), "{said}");
    let all = words.replace("--photons 5000", "") + " --out e.npy --load-map m.map";
    let said = failure(&run_in(folder.path(), &arguments(&all, &[])));
    assert!(said.contains("m.map was shot with 5000 photons, not 1000000"), "{said}");
}

#[test]
fn pictures_have_one_digest_and_values() {
    let folder = folder();
    let run = |more: &str| {
        let words = "render --scene fig2 --out p.png --values v.pfm --photons 3000 --size 96 64";
        let all = format!("{words} {more}");
        let (shown, said) = success(&run_in(folder.path(), &arguments(&all, &[])));
        assert!(shown.contains("emitted =") && shown.contains("estimates/s"), "{shown}");
        let png = fs::read(folder.path().join("p.png")).unwrap();
        assert!(png.starts_with(b"\x89PNG"));
        (fs::read(folder.path().join("v.pfm")).unwrap(), png, said)
    };
    for estimator in ["", "--estimator photon-map"] {
        let (first, png, _) = run(&format!("{estimator} --threads 1 --index octree"));
        assert!(first.starts_with(b"PF\n96 64\n-1.0\n") && first.len() == 14 + 96 * 64 * 12);
        for more in
            ["--threads 2 --index grid-hierarchy", "--threads 3", "--threads 8 --index kd-tree"]
        {
            let (again, same, _) = run(&format!("{estimator} {more}"));
            assert!(again == first && same == png, "{estimator} {more}");
        }
    }
    let (_, _, said) = run("--passes 3");
    assert!(said.contains("pass 3 of 3"), "{said}");
    run("--quantity irradiance --false-colour --unit lux --log 2 --scale 5 --passes 2");
    run("--eye 0,-9,3 --look-at 0,0,0 --fov 50 --exposure 2 --samples 1 --radius 0.5");
    let words = "render --scene fig2 --out p.png --values v.exr --photons 1000 --size 64 64";
    success(&run_in(folder.path(), &arguments(words, &[])));
    let exr = fs::read(folder.path().join("v.exr")).unwrap();
    assert!(exr.starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    for channel in
        ["R\0", "irradiance.G\0", "count\0", "radius\0", "depth.Z\0", "triangle\0", "stderr\0"]
    {
        assert!(exr.windows(channel.len()).any(|part| part == channel.as_bytes()), "{channel}");
    }
}

#[test]
fn wrong_options_of_pictures_are_refused_by_name() {
    let folder = folder();
    for (more, message) in [
        ("--eye 1,2 --size 64 64", "three finite numbers are needed"),
        ("--eye 1,2,nan", "three finite numbers are needed"),
        ("--look-at 0,0,0", "--eye"),
        ("--eye 0,0,0 --look-at 0,0,0", "the camera has no direction"),
        ("--eye 0,0,9 --look-at 0,0,0 --up z", "straight above or below"),
        ("--eye 0,0,1e30 --look-at 0,9,0", "or too far away"),
        ("--eye 0,0,9 --fov 180", "must be 1 to 170"),
        ("--exposure 0", "must be finite and above 0"),
        ("--log 2", "--false-colour"),
        ("--exposure 2 --false-colour", "cannot be used with"),
        ("--efficacy 100", "--unit"),
        ("--values v.tif", "the name must end in .exr or .pfm"),
        ("--size 63 64", "must be 64 to 8192"),
        ("--passes 0", "must be 1 to"),
        ("--samples 17", "must be 1 to 16"),
        ("--photons -1", "invalid value '-1'"),
    ] {
        let words = format!("render --scene fig2 --out p.png --photons 10 {more}");
        let words =
            if more.contains("--photons") { words.replace("--photons 10 ", "") } else { words };
        let said = failure(&run_in(folder.path(), &arguments(&words, &[])));
        assert!(said.contains(message), "{more}\n{said}");
    }
    assert!(names(folder.path()).is_empty());
    // Its diagonal is no f32.
    let large = "v -3e38 0 0\nv 3e38 0 0\nv 0 3e38 0\nf 1 2 3\n";
    fs::write(folder.path().join("large.obj"), large).unwrap();
    let words = "render large.obj --out p.png --photons 10 --size 64 64";
    let said = failure(&run_in(folder.path(), &arguments(words, &[])));
    assert!(said.contains("too large for a camera"), "{said}");
    let words = "render --scene fig2 --out p.png --photons 0 --size 64 64";
    let (_, said) = success(&run_in(folder.path(), &arguments(words, &[])));
    assert!(said.contains("no photons: the scene is dark"), "{said}");
}

#[test]
fn lights_come_from_the_command_line_else_the_file_else_above() {
    let folder = folder();
    write_scene(folder.path());
    let scene = format!("mtllib m.mtl\nusemtl lamp\n{SCENE}");
    fs::write(folder.path().join("lit.obj"), scene).unwrap();
    fs::write(folder.path().join("m.mtl"), "newmtl lamp\nKd 0.5 0.25 0.75\nKe 1 1 1\n").unwrap();
    let flux = |words: &str| {
        let all = format!("render {words} --up z --out p.png --photons 1000 --size 64 64");
        let (shown, _) = success(&run_in(folder.path(), &arguments(&all, &[])));
        let line = shown.lines().find(|line| line.starts_with("energy: ")).unwrap().to_owned();
        line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
    };
    let face = 16.0 * std::f64::consts::PI;
    assert!((flux("lit.obj") - face).abs() < 1e-3);
    assert!((flux("lit.obj --two-sided-lights") - 2.0 * face).abs() < 1e-3);
    assert_eq!(flux("lit.obj --light 0,0,3,0,1,0,1,0,0,7"), 7.0);
    assert_eq!(flux("s.obj"), 100.0);
    // Radiances that are none are warnings with their line.
    for (colour, warned) in
        [("1", false), ("1 2", true), ("nan", true), ("-1", true), ("1e99", true)]
    {
        let mtl = format!("newmtl lamp\nKd 0.5\nKs 1 1 1\nd 0.1\nmap_Kd x.png\nKe {colour}\n");
        fs::write(folder.path().join("m.mtl"), mtl).unwrap();
        let words = "render lit.obj --up z --out p.png --photons 1000 --size 64 64";
        let (_, said) = success(&run_in(folder.path(), &arguments(words, &[])));
        assert_eq!(said.contains("m.mtl, line 6"), warned, "{said}");
        assert_eq!(said.matches("1 material has").count(), 3, "{said}");
    }
}

#[test]
fn shoot_writes_triangles_meshes_and_photons() {
    let folder = folder();
    write_scene(folder.path());
    let files = ["t.npy", "t.csv", "m.ply", "p.ply"];
    let run = |more: &str| {
        let words = "shoot s.obj --up z --photons 5000 --mesh-ply m.ply --photons-ply p.ply --ply-limit 100";
        for triangles in ["t.npy", "t.csv"] {
            let all = format!("{words} --triangles {triangles} {more}");
            success(&run_in(folder.path(), &arguments(&all, &[])));
        }
        files.map(|file| fs::read(folder.path().join(file)).unwrap())
    };
    let first = run("--threads 1 --index linear");
    for more in ["--threads 2", "--threads 3 --index octree", "--threads 8 --index bvh"] {
        assert!(run(more) == first, "{more}");
    }
    let table = String::from_utf8(first[1].clone()).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].starts_with("triangle,area,front_red,"));
    assert_eq!(rows.len(), 4);
    // The floor of 16 m2 in two triangles; the sliver has no area and no light.
    assert!(rows[1].starts_with("0,8.0,") && rows[3].starts_with("2,0.0,0.0,0.0,"), "{table}");
    let irradiance: f64 = rows[1].split(',').nth(2).unwrap().parse().unwrap();
    assert!(irradiance > 1.0 && irradiance < 7.0, "{table}");
    for (at, parts) in [
        (
            2,
            ["element face 3", "property float front_irradiance_red", "comment photon flux 2e-2 W"],
        ),
        (3, ["element vertex 100", "property uint bounce", "comment seed 1"]),
    ] {
        let text = String::from_utf8_lossy(&first[at]);
        assert!(text.starts_with("ply\nformat binary_little_endian 1.0\n"));
        parts.iter().for_each(|part| assert!(text.contains(part), "{part}"));
    }
    // The mesh is read back by the program.
    success(&run_in(folder.path(), &["inspect", "m.ply"]));
}
