//! OBJ files: triangles in the order of the file's faces.
//!
//! ```text
//! bytes -> text (checks every line, keeps what matters) -> tobj -> Model
//!                          materials (.mtl) ----------------/
//! ```
//! `tobj` names no line when it refuses a file, panics on some material files, takes a line of three
//! points for a triangle and divides coordinates by a fourth one. So the text is checked first, and
//! `tobj` reads a copy reduced to vertices, faces, names and materials.
//!
//! # Invariants
//! Triangle ids count the faces in the order of the file, polygons as fans from their first corner;
//! triangles without area are kept. Coordinates are the `f32` nearest to the decimals.
//!
//! # Source
//! Wavefront Technologies, *Advanced Visualizer manual*, appendix B1 (OBJ), and the material format MTL.
//! Not read: curves and free-form surfaces, texture coordinates, normals, colours of vertices.
//! Emission (`Ke`) does not make lights: a triangle is not a parallelogram.

mod materials;
mod text;

use std::cell::RefCell;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use arboleda::{Triangle, Vec3};
use tobj::{LoadError, LoadOptions};

use super::{Model, SceneError};
use text::Reduced;

/// The reflectance where no material says otherwise.
pub const DEFAULT_REFLECTANCE: f32 = 0.5;

/// A model, and what its file says that is not in it.
#[derive(Clone, Debug)]
pub struct Import {
    /// The model; without lights.
    pub model: Model,
    /// One line each: elements ignored, material files not found.
    pub warnings: Vec<String>,
}

/// Loads an OBJ file, and prints its warnings to the standard error.
///
/// Each `o`, and each `g` inside it, is an object; one that is opened again continues. Materials'
/// diffuse colours (`Kd`) give the reflectance, by their mean.
///
/// # Errors
/// [`SceneError::Unreadable`], [`SceneError::Line`], [`SceneError::NoFaces`].
pub fn load(path: &Path) -> Result<Model, SceneError> {
    let file = File::open(path).map_err(|source| unreadable(path, source))?;
    let import = load_from(file, path)?;
    for warning in &import.warnings {
        eprintln!("warning: {warning}");
    }
    Ok(import.model)
}

/// As [`load`], from any reader. `name` stands in messages, its last part names the model, and
/// material files are looked for beside it.
///
/// # Errors
/// As [`load`].
pub fn load_from(mut reader: impl Read, name: &Path) -> Result<Import, SceneError> {
    // 1. Check and reduce. Names in other encodings than UTF-8 lose letters, nothing else.
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).map_err(|source| unreadable(name, source))?;
    let source = String::from_utf8_lossy(&bytes);
    let reduced = text::reduce(&source).map_err(|(line, problem)| SceneError::Line {
        file: name.into(),
        line,
        problem,
    })?;
    let (vertex_count, ignored_count) = (reduced.vertex_count, reduced.ignored_count);
    if reduced.triangle_count == 0 {
        return Err(SceneError::NoFaces { file: name.into(), vertex_count, ignored_count });
    }

    // 2. Read. Only triangles and polygons are left in the text.
    let mut warnings = Vec::new();
    if ignored_count > 0 {
        warnings
            .push(format!("{}: {ignored_count} point and line elements ignored", name.display()));
    }
    let warnings = RefCell::new(warnings);
    let options = LoadOptions { triangulate: true, ..LoadOptions::default() };
    let read = tobj::load_obj_buf(&mut reduced.text.as_bytes(), &options, |library| {
        load_library(name, library, &mut warnings.borrow_mut())
    });
    let (parts, materials) =
        read.map_err(|source| SceneError::Refused { file: name.into(), source })?;
    let mut warnings = warnings.into_inner();
    let materials = materials.unwrap_or_default();
    let is_defined = |used: &&String| materials.iter().any(|material| material.name == **used);
    if !materials.is_empty() {
        for used in reduced.materials_used.iter().filter(|used| !is_defined(used)) {
            warnings.push(format!("{}: no material is called `{used}`", name.display()));
        }
    }

    // 3. One part after the other: `tobj` begins a new one, at the end of its list, wherever the name
    // or the material changes, so the order of the parts and inside them is that of the file.
    let title = name.file_stem().unwrap_or(name.as_os_str()).to_string_lossy();
    let model = assemble(title.into_owned(), reduced, &parts, &materials);
    Ok(Import { model, warnings })
}

fn unreadable(path: &Path, source: io::Error) -> SceneError {
    SceneError::Unreadable { file: path.into(), source }
}

fn assemble(
    name: String,
    reduced: Reduced,
    parts: &[tobj::Model],
    materials: &[tobj::Material],
) -> Model {
    let mut model = Model::named(name);
    model.object_names = reduced.names;
    for part in parts {
        // The reduced text gives each object's number for its name.
        let object = part.name.parse().unwrap_or(0);
        let diffuse = part.mesh.material_id.and_then(|id| materials.get(id)?.diffuse);
        let reflectance = diffuse.map_or(DEFAULT_REFLECTANCE, materials::mean);
        let corner = |index: u32| {
            let first = index as usize * 3;
            Vec3::from_slice(&part.mesh.positions[first..first + 3])
        };
        for corners in part.mesh.indices.chunks_exact(3) {
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(corner);
            model.triangles.push(Triangle::new(a, b, c));
        }
        model.objects.resize(model.triangles.len(), object);
        model.reflectance.resize(model.triangles.len(), reflectance);
    }
    debug_assert_eq!(model.triangles.len(), reduced.triangle_count);
    model
}

/// Reads the material files that an `mtllib` line names: one whose name may hold spaces or, where
/// there is none such, several separated by spaces.
fn load_library(model: &Path, library: &Path, warnings: &mut Vec<String>) -> tobj::MTLLoadResult {
    let beside = |name: &Path| model.parent().unwrap_or(Path::new("")).join(name);
    let whole = beside(library);
    let several = library.to_string_lossy();
    let files: Vec<PathBuf> = if whole.is_file() {
        vec![whole]
    } else {
        several.split_whitespace().map(|name| beside(Path::new(name))).collect()
    };
    let mut reduced = String::new();
    for file in files {
        match fs::read(&file) {
            Ok(bytes) => {
                let text = String::from_utf8_lossy(&bytes);
                materials::reduce(&text, &file, &mut reduced, warnings);
            }
            Err(error) => warnings.push(format!(
                "{}: cannot read its material file {}: {error}; \
                 reflectance {DEFAULT_REFLECTANCE} instead",
                model.display(),
                file.display()
            )),
        }
    }
    if reduced.is_empty() {
        return Err(LoadError::OpenFileFailed);
    }
    tobj::load_mtl_buf(&mut reduced.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    fn import(text: &str) -> Import {
        load_from(text.as_bytes(), Path::new("test.obj")).expect("a valid file")
    }

    fn refusal(text: &str) -> String {
        load_from(text.as_bytes(), Path::new("bad.obj")).expect_err("an invalid file").to_string()
    }

    /// Four vertices.
    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    /// The x of each triangle's first corner, where the n-th face starts at vertex n.
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
        // A pentagon, a quad named backwards before more vertices follow, and a reference ahead.
        let text =
            format!("{SQUARE}v 0 2 0\nf 1 2 3 4 5\nf -5 -4 -3 -2\nv 7 7 7\nf 7 6 1\nv 8 8 8\n");
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
        // Halfway between 1 and its successor, and just above: rounding through f64 gets the
        // second wrong.
        let text = "v 1.000000059604644775390625 1.0000000596046447753906251 0.1\nv 1e-46 -0 1e38\nf 1 2 1";
        let triangle = import(text).model.triangles[0];
        assert_eq!(triangle.a, Vec3::new(1.0, 1.0 + f32::EPSILON, 0.1));
        assert_eq!(triangle.b, Vec3::new(0.0, 0.0, 1e38));
    }

    #[test]
    fn points_and_lines_are_counted() {
        let import = import(&format!("{SQUARE}p 1\nl 1 2 3\nl 1 2\nf 1 2\nf 1 2 3\n"));
        assert_eq!(import.model.triangles.len(), 1);
        assert_eq!(import.warnings, ["test.obj: 4 point and line elements ignored"]);
    }

    #[test]
    fn errors_name_file_line_and_cause() {
        for (text, message) in [
            (
                "v 0 0 0\nv nan 0 0\n",
                "bad.obj, line 2: vertex coordinate `nan` is not finite as a 32-bit number",
            ),
            (
                "v 0 1e39 0\n",
                "bad.obj, line 1: vertex coordinate `1e39` is not finite as a 32-bit number",
            ),
            ("v 0 0 0\n\nv 0 a 0\n", "bad.obj, line 3: vertex coordinate `a` is not a number"),
            ("v 0 0\n", "bad.obj, line 1: a vertex needs 3 coordinates, here are 2"),
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
                "bad.obj, line 2: face corner `9223372036854775808` does not begin with a vertex number (1, 2, ... or -1, -2, ...)",
            ),
            (
                "",
                "bad.obj: no faces found (0 vertices, 0 point and line elements); is it an OBJ file with `f` lines?",
            ),
            (
                "v 0 0 0\nl 1 1\n",
                "bad.obj: no faces found (1 vertices, 1 point and line elements); is it an OBJ file with `f` lines?",
            ),
        ] {
            assert_eq!(refusal(text), message);
        }
        // The first of several bad lines is the one named, also where the number is only too high.
        assert!(refusal("v 0 0 0\nf 2 1 1\nf 3 1 1\nf 9 1 1\nv 0 0 0\n").contains("line 3"));
        assert!(refusal("v 0 0 0\nf 1 1 -9223372036854775808\n").contains("line 2"));
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = load(Path::new("no-such-file.obj")).unwrap_err();
        assert!(error.to_string().starts_with("cannot read no-such-file.obj: "), "{error}");
    }

    #[test]
    fn materials_give_the_reflectance() {
        let folder =
            std::env::temp_dir().join(format!("arboleda-materials-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let mtl = "newmtl grey\nKd 0.25\nnewmtl warm\n Kd 0.9 0.6 0.3\nKe 5 5 5\nnewmtl plain\nd 1\n\
                   newmtl bad\nKd spectral file\nnewmtl bright\nKd 2 2 2\n";
        fs::write(folder.join("my colours.mtl"), mtl).unwrap();
        let faces: String = ["grey", "warm", "plain", "bad", "bright", "none", ""]
            .map(|name| format!("usemtl {name}\nf 1 2 3\n"))
            .concat();
        let text = format!("mtllib my colours.mtl\n{SQUARE}f 1 2 3\n{faces}");
        let path = folder.join("scene.obj");
        let import = load_from(text.as_bytes(), &path).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(import.model.reflectance, [0.5, 0.25, 0.6, 0.5, 0.5, 1.0, 0.5, 0.5]);
        assert_eq!(import.warnings.len(), 2, "{:?}", import.warnings);
        assert!(import.warnings[0].contains("my colours.mtl, line 9: `Kd spectral file`"));
        assert!(import.warnings[1].ends_with("no material is called `none`"));
    }

    #[test]
    fn a_missing_material_file_is_a_warning() {
        let import = import(&format!("mtllib no-such.mtl\n{SQUARE}usemtl x\nf 1 2 3\n"));
        assert_eq!(import.model.reflectance, [0.5]);
        assert_eq!(import.warnings.len(), 1, "{:?}", import.warnings);
        assert!(
            import.warnings[0].starts_with("test.obj: cannot read its material file no-such.mtl")
        );
    }
}
