use super::*;
use crate::scene::formats::tests::nothing_beside;
use crate::scene::{Import, Model, Origin};
use arboleda::{Triangle, Vec3};
use std::fmt::Write;

fn place(text: &str, origin: Origin) -> Import {
    let surface = read(text.as_bytes(), Path::new("test.obj"), &nothing_beside);
    surface.and_then(|surface| surface.place(origin)).expect("a valid file")
}

fn import(text: &str) -> Import {
    place(text, Origin::Unchanged)
}

fn refusal(text: &str) -> String {
    let surface = read(text.as_bytes(), Path::new("bad.obj"), &nothing_beside);
    surface.and_then(|surface| surface.place(Origin::Unchanged)).unwrap_err().to_string()
}

/// Lines of four vertices.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Lists the x of each triangle's first corner, by which tests identify faces.
fn first_x(model: &Model) -> Vec<f32> {
    model.triangles.iter().map(|triangle| triangle.a.x).collect()
}

#[test]
fn ids_count_faces_in_file_order_where_objects_interleave() {
    let mut text = String::new();
    for x in 0..8 {
        writeln!(text, "v {x} 0 0\nv {x} 1 0\nv {x} 0 1").unwrap();
    }
    text += "f 1 2 3\no A\nf 4 5 6\nusemtl one\nf 7 8 9\no B\nf 10 11 12\no A\nusemtl two\n\
             f 13 14 15\ng wall\nf 16 17 18\no B\ng wall\nf 19 20 21\ng\nf -3 -2 -1\n";
    let model = import(&text).model;
    assert_eq!(first_x(&model), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(model.object_names, ["unnamed", "A", "B", "A/wall", "B/wall"]);
    assert_eq!(model.objects, [0, 1, 1, 2, 1, 3, 4, 2]);
    assert_eq!(model.reflectance, [0.5; 8]);
    assert_eq!(model.name, "test");
}

#[test]
fn polygons_become_fans_and_negative_indices_count_back() {
    // A pentagon, a quad with negative numbers before more vertices follow, and a reference to a later vertex.
    let text = format!("{SQUARE}v 0 2 0\nf 1 2 3 4 5\nf -5 -4 -3 -2\nv 7 7 7\nf 7 6 1\nv 8 8 8\n");
    let triangles = import(&text).model.triangles;
    let p = |x: u8, y: u8| Vec3::new(x.into(), y.into(), 0.0);
    let (a, b, c, d, e) = (p(0, 0), p(1, 0), p(1, 1), p(0, 1), p(0, 2));
    let expected = [
        [a, b, c],
        [a, c, d],
        [a, d, e],
        [a, b, c],
        [a, c, d],
        [Vec3::splat(8.0), Vec3::splat(7.0), a],
    ];
    assert_eq!(triangles, expected.map(|[a, b, c]| Triangle::new(a, b, c)));
}

#[test]
fn spellings_that_occur() {
    let plain = import(&format!("{SQUARE}f 1 2 3\n")).model.triangles;
    for text in [
        format!("\u{feff}{}f 1/1/1 2//5 3/7\r\n", SQUARE.replace('\n', "\r\n")),
        format!("{SQUARE}f 1 2 \\\n 3 # a comment"),
        format!("# v nan\n{SQUARE}vt nan\nvn 1\nxyz\ns off\n\tf\t1 2\t3\n"),
        "v 0 0 0 2\nv 1 0 0 1 1 1\nv 1 1 0 0.5 0.5 0.5 1\nf 1 2 3".into(),
    ] {
        assert_eq!(import(&text).model.triangles, plain, "{text}");
    }
}

#[test]
fn degenerate_triangles_keep_their_ids() {
    let model = import(&format!("{SQUARE}f 1 1 1\nf 1 2 2\nf 2 3 4\n")).model;
    assert_eq!(first_x(&model), [0.0, 0.0, 1.0]);
}

#[test]
fn coordinates_are_the_nearest_f32() {
    // Halfway between 1 and its successor, and just above. Rounding through f64 would round the second down.
    let text =
        "v 1.000000059604644775390625 1.0000000596046447753906251 0.1\nv 1e-46 -0 1e38\nf 1 2 1";
    let triangle = import(text).model.triangles[0];
    assert_eq!(triangle.a, Vec3::new(1.0, 1.0 + f32::EPSILON, 0.1));
    assert_eq!(triangle.b, Vec3::new(0.0, 0.0, 1e38));
}

#[test]
fn points_and_lines_are_counted() {
    let import = import(&format!("{SQUARE}p 1\nl 1 2 3\nl 1 2\nf 1 2\nf 1 2 3\n"));
    assert_eq!(import.model.triangles.len(), 1);
    let expected = [
        "test.obj: 3 point and line elements ignored",
        "test.obj: 1 faces of one or two corners ignored",
    ];
    assert_eq!(import.warnings, expected);
}

#[test]
fn errors_name_file_line_and_cause() {
    for (text, message) in [
        ("v 0 0 0\n\nv 0 a 0\n", "bad.obj, line 3: vertex coordinate `a` is not a number"),
        ("v 0 0\n", "bad.obj, line 1: a vertex needs 3 coordinates, but has 2"),
        (
            "v 0 0 0\nf 1 1 2\n",
            "bad.obj, line 2: a face names vertex 2, but there are 1 vertices in the file",
        ),
        (
            "v 0 0 0\nf 1 1 -2\nv 1 1 1",
            "bad.obj, line 2: a face names vertex -2, but there are 1 vertices above it",
        ),
        (
            "v 0 0 0\nf 1 0 1\n",
            "bad.obj, line 2: face corner `0` does not begin with a vertex number (1, 2, ... or -1, -2, ...)",
        ),
        (
            "v 0 0 0\nf 1 x/1 1\n",
            "bad.obj, line 2: face corner `x/1` does not begin with a vertex number (1, 2, ... or -1, -2, ...)",
        ),
        (
            "v 0 0 0\nf 1 1 9223372036854775808\n",
            "bad.obj, line 2: face corner `9223372036854775808` does not begin with a vertex number \
             (1, 2, ... or -1, -2, ...)",
        ),
        (
            "",
            "bad.obj: no faces of three or more corners found (0 vertices, 0 points, lines and shorter \
             faces); is it an OBJ file with `f` lines?",
        ),
        (
            "v 0 0 0\nl 1 1\n",
            "bad.obj: no faces of three or more corners found (1 vertices, 1 points, lines and shorter \
             faces); is it an OBJ file with `f` lines?",
        ),
    ] {
        assert_eq!(refusal(text), message);
    }
    // The message names the first of several bad lines. A number that is too high is known to be bad only at the end.
    assert!(refusal("v 0 0 0\nf 2 1 1\nf 3 1 1\nf 9 1 1\nv 0 0 0\n").contains("line 3"));
    assert!(refusal("v 0 0 0\nf 1 1 -9223372036854775808\n").contains("line 2"));
}

#[test]
fn materials_give_the_reflectance() {
    let mtl = "newmtl grey\nKd 0.25\nnewmtl warm\n Kd 0.9 0.6 0.3\nKe 5 5 5\nnewmtl plain\nd 1\n\
               newmtl bad\nKd spectral file\nnewmtl bright\nKd 2 2 2\n";
    let faces: String = ["grey", "warm", "plain", "bad", "bright", "none", ""]
        .map(|name| format!("usemtl {name}\nf 1 2 3\n"))
        .concat();
    // File names as programs write them: with spaces, in quotes, twice on a line, with the slashes of Windows.
    for written in [
        "my colours.mtl",
        "\"my colours.mtl\"",
        "\"my colours.mtl\" \"my colours.mtl\"",
        ".\\my colours.mtl",
        "\".\\my colours.mtl\"",
    ] {
        let text = format!("mtllib {written}\n{SQUARE}f 1 2 3\n{faces}");
        let beside = |path: &Path| {
            let found = path == Path::new("folder/my colours.mtl")
                || path == Path::new("folder/./my colours.mtl");
            if found { Ok(mtl.into()) } else { nothing_beside(path) }
        };
        let surface = read(text.as_bytes(), Path::new("folder/scene.obj"), &beside).unwrap();
        let import = surface.place(Origin::Unchanged).unwrap();
        assert_eq!(
            import.model.reflectance,
            [0.5, 0.25, 0.6, 0.5, 0.5, 1.0, 0.5, 0.5],
            "{written}"
        );
        assert!(import.warnings[0].contains("my colours.mtl, line 9: `Kd spectral file`"));
        assert!(import.warnings.last().unwrap().ends_with("no material is called `none`"));
    }
}

#[test]
fn a_missing_material_file_is_a_warning() {
    let import = import(&format!("mtllib no-such.mtl\n{SQUARE}usemtl x\nf 1 2 3\n"));
    assert_eq!(import.model.reflectance, [0.5]);
    assert_eq!(import.warnings.len(), 1, "{:?}", import.warnings);
    assert!(import.warnings[0].starts_with("test.obj: cannot read the material file no-such.mtl"));
}

#[test]
fn materials_without_a_library_are_a_warning() {
    let import = import(&format!("{SQUARE}usemtl x\nf 1 2 3\nusemtl y\nf 1 2 3\n"));
    let expected = "test.obj: 2 materials are used, but no material file is named (`mtllib`); \
                    reflectance 0.5 instead";
    assert_eq!(import.warnings, [expected]);
}

#[test]
fn names_and_comments_that_end_in_a_backslash_end_there() {
    for name in
        ["# made in C:\\models\\", "g C:\\", "o a\\", "usemtl tex\\", "mtllib C:\\m\\", "#\\"]
    {
        // If the name continued on the next line, the first vertex would be lost and the triangle another one.
        let text = format!("{name}\n{SQUARE}v 5 5 5\n{name} \nf 1 2 3 # {name}\nf 2 3 4\n");
        assert_eq!(first_x(&import(&text).model), [0.0, 1.0], "{name}");
    }
    let text = include_str!("../../../../tests/files/comment-ends-in-backslash.obj");
    assert_eq!(import(text).model.triangles, [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)]);
}

#[test]
fn continued_lines_take_linear_time() {
    // Each corner is on a line of its own, with blanks after every second backslash.
    // Measured: joining by a copy for each line took ten minutes.
    let count = 600_000;
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nf");
    for corner in 0..count {
        writeln!(text, " {}\\{}", corner % 3 + 1, if corner % 2 == 0 { "" } else { " \t" })
            .unwrap();
    }
    let surface = read(text.as_bytes(), Path::new("test.obj"), &nothing_beside).unwrap();
    assert_eq!(surface.face_count(), 1);
}

#[test]
fn lines_end_as_on_any_system() {
    let unix = format!("# a\n{SQUARE}f 1 2 \\\n3\n\nf 2 3 x\n");
    for ending in ["\r", "\r\n", "\n"] {
        let text = unix.replace('\n', ending);
        assert!(refusal(&text).starts_with("bad.obj, line 9:"), "{}", refusal(&text));
        let triangles = import(&text.replace('x', "4")).model.triangles;
        assert_eq!(triangles.len(), 2);
    }
}

#[test]
fn vertices_that_are_not_finite_spoil_only_their_faces() {
    for bad in ["nan 0 0", "0 inf 0", "0 0 -1e39", "1e400 0 0"] {
        let unused = import(&format!("{SQUARE}v {bad}\nf 1 2 3\n"));
        assert_eq!((unused.model.triangles.len(), unused.warnings.len()), (1, 0), "{bad}");
        let text = format!("{SQUARE}v {bad}\no a\nf 1 5 3\no b\nf 2 3 4\nf 1 2 3 5\n");
        let import = import(&text);
        assert_eq!(first_x(&import.model), [1.0]);
        assert_eq!((import.model.objects[0], import.model.object_names[1].as_str()), (1, "b"));
        assert_eq!(import.warnings.len(), 1);
        assert!(
            import.warnings[0].starts_with(
                "test.obj: 2 faces omitted because they have a vertex that is not finite as a \
                 32-bit number; the first is face 1, with vertex "
            ),
            "{}",
            import.warnings[0]
        );
        assert_eq!(
            refusal(&format!("{SQUARE}v {bad}\nf 1 2 5\n")),
            "bad.obj: all 1 faces have a vertex that is not finite as a 32-bit number"
        );
    }
}

#[test]
fn concave_and_crossing_polygons() {
    let import = import(
        "v 0 0 0\nv 4 2 0\nv 0 4 0\nv 1 2 0\nv 4 4 0\nf 1 2 3 4\nf 2 3 4 1\nf 1 5 2 3\nf 1 2 4\n",
    );
    let areas: Vec<f32> =
        import.model.triangles.iter().map(|triangle| triangle.normal().length() / 2.0).collect();
    // The dart has area 6 from two of its corners; each face has n - 2 triangles.
    assert_eq!(areas.len(), 7);
    assert_eq!((areas[0] + areas[1], areas[2] + areas[3], areas[6]), (6.0, 6.0, 3.0));
    let expected =
        "test.obj: 1 polygons cross themselves; each was divided into a fan from its first corner";
    assert_eq!(import.warnings, [expected]);
}

/// Coordinates on the earth's ellipsoid in metres, which 32 bits round to a quarter of a metre.
const FAR: &str = "v -2487002.881739342 -4684683.676570751 3529638.9835389843\n\
                   v -2487004.0341807394 -4684683.789984506 3529638.299934322\n\
                   v -2487003.1884904536 -4684683.513722925 3529638.9835389843\nf 1 2 3\n";

#[test]
fn coordinates_that_lose_their_digits_are_told_of_and_cured() {
    let lossy = import(FAR);
    assert_eq!(lossy.warnings.len(), 1);
    assert!(
        lossy.warnings[0]
            .contains("3 of 3 vertices move by up to 2.10e-1, 18.72% of the median edge"),
        "{}",
        lossy.warnings[0]
    );
    assert!(
        lossy.warnings[0]
            .contains("`--origin auto`, or `--origin -2487003.5,-4684683.7,3529638.6`, keeps"),
        "{}",
        lossy.warnings[0]
    );
    for origin in ["auto", "-2487003.5,-4684683.7,3529638.6"] {
        let cured = place(FAR, origin.parse().unwrap());
        assert_eq!(cured.warnings, [""; 0]);
        assert_eq!(cured.model.origin, [-2_487_003.5, -4_684_683.7, 3_529_638.6]);
        let a = cured.model.triangles[0].a;
        let exact = [0.618_260_658, 0.023_429_249, 0.383_538_984];
        for (got, exact) in a.to_array().into_iter().zip(exact) {
            assert!((f64::from(got) - exact).abs() < 1e-7, "{got} {exact}");
        }
    }
    // An origin far from the scene leaves the loss, and the warning.
    assert_eq!(place(FAR, Origin::At([1e6; 3])).warnings.len(), 1);
}

#[test]
fn usual_coordinates_lose_nothing_worth_a_word() {
    // Tenths, a tiny model, a vast model, and large coordinates that 32 bits hold exactly.
    for text in [
        "v 0.1 0.2 0.3\nv 10.7 0.1 0\nv 3.3 9.9 0.1\nf 1 2 3\n",
        "v 1e-30 2e-30 3e-30\nv 7e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n",
        "v 1e30 2e30 3e30\nv 7e30 0 0\nv 0 1e30 0\nf 1 2 3\n",
        "v 4649776 500000 0\nv 4649777 500000 0\nv 4649776 500001 0.5\nf 1 2 3\n",
    ] {
        assert_eq!(import(text).warnings, [""; 0], "{text}");
    }
    // A triangle of ten centimetres at these coordinates.
    let small = "v 4649776.1 500000 0\nv 4649776.2 500000 0\nv 4649776.1 500000.1 0\nf 1 2 3\n";
    assert_eq!(import(small).warnings.len(), 1);
    // A scene too large for its edges.
    let vast = format!("{small}v -4649776.1 0 0\nv -4649776.2 0 0\nv -4649776.2 0.1 0\nf 4 5 6\n");
    assert!(
        import(&vast).warnings[0]
            .ends_with("no `--origin` helps: the scene is too large for its edges")
    );
}

/// The Cornell box with the walls' colours and the lamp's radiance of the data by `McGuire`.
const CORNELL: &str = "newmtl white\nKd 0.725 0.71 0.68\nnewmtl red\nKd 0.63 0.065 0.05\n\
                       newmtl green\nKd 0.14 0.45 0.091\n\
                       newmtl light\nKd 0.78 0.78 0.78\nKe 17 12 4\n";

fn with_materials(text: &str, mtl: &'static str) -> Import {
    let beside = |_: &Path| Ok(mtl.into());
    let surface = read(text.as_bytes(), Path::new("test.obj"), &beside).unwrap();
    surface.place(Origin::Unchanged).unwrap()
}

#[test]
fn emitting_faces_have_the_flux_of_their_radiance() {
    let flux = |text: &str, mtl| {
        let model = with_materials(text, mtl).model;
        (crate::photon::Emitter::of(&model).total_flux(), model)
    };
    let (square, model) =
        flux(&format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3 4\n"), "newmtl a\nKe 1 1 1\n");
    assert!((square - std::f64::consts::PI).abs() < 1e-5, "{square}");
    assert_eq!((model.emitters.len(), model.colours.len()), (2, 0));
    let lamp = "mtllib a.mtl\nv -0.24 1.98 0.16\nv -0.24 1.98 -0.22\nv 0.23 1.98 -0.22\nv 0.23 1.98 0.16\n\
                usemtl light\nf 1 2 3 4\nusemtl red\nf 4 3 2\nusemtl white\nf 1 1 2\n";
    let (lamp, model) = flux(lamp, CORNELL);
    assert!((lamp - 6.171_973).abs() < 1e-5, "{lamp}");
    assert_eq!(model.colours[2], [0.63, 0.065, 0.05]);
    assert_eq!(model.colour(0), [0.78; 3]);
    // The winding faces down.
    assert!(model.triangles[0].normal().y < 0.0);
    // A face without area emits nothing, and leaves the scene to the default lamp.
    let none =
        with_materials(&format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 1 2\n"), "newmtl a\nKe 9\n");
    assert!(none.model.emitters.is_empty());
    assert_eq!(none.warnings, ["test.obj: 1 triangles of lamps have no area, and emit nothing"]);
    assert_eq!(none.model.with_default_light(crate::scene::UpAxis::Y).lights.len(), 1);
}

#[test]
fn properties_that_are_not_simulated_give_one_warning_each() {
    let text = format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3 4\n");
    let import =
        with_materials(&text, "newmtl a\nKs 1\nd 0\nmap_Kd x.png\nKe nan\nnewmtl b\nKs 1 1 1\n");
    assert_eq!(import.warnings.len(), 4, "{:?}", import.warnings);
    assert!(import.warnings[0].contains("line 5: `Ke nan` is not a radiance"));
    assert!(import.warnings[1].contains("2 materials have a highlight"));
}
