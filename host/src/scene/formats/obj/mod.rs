//! Reader of OBJ files.
//!
//! ```text
//! bytes -> text (checks and reduces every line) -> tobj -> Surface
//!                       materials (.mtl) -----------/
//! ```
//! The crate `tobj` has four defects:
//!
//! - It names no line when it refuses a file.
//! - It panics on some material files.
//! - It reads an `l` line of three points as a triangle.
//! - It divides coordinates by a fourth one.
//!
//! The text is therefore checked first, and `tobj` reads a copy that is reduced to vertices, faces, names and
//! materials.
//!
//! # Invariants
//! - Triangles are in the order of the file's faces, `n - 2` for a polygon of `n` corners.
//! - Triangles without area are kept.
//! - Without an origin, coordinates are the `f32` nearest to the decimals.
//!
//! # Source
//! Wavefront Technologies, *Advanced Visualizer manual*, appendix B1 (OBJ), and the material format MTL. Curves,
//! free-form surfaces, texture coordinates, normals and colours of vertices are ignored. Emission (`Ke`) is a radiance,
//! on the front of each face; highlights, transparency and textures are not simulated.

mod materials;
mod text;

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use tobj::{LoadError, LoadOptions};

use super::Companions;
use crate::scene::SceneError;
use crate::scene::surface::{DEFAULT_REFLECTANCE, Material, Surface};
use materials::Ignored;
use text::Reduced;

/// Reads the bytes of an OBJ file. Messages contain the path `name`; its last part names the model; material files are
/// read from its folder.
///
/// Each `o`, and each `g` inside an `o`, is an object. A name that occurs again continues its object. A surface
/// reflects the material's diffuse colour (`Kd`), and emits its radiance (`Ke`) on the front.
///
/// # Errors
/// [`SceneError::Line`], [`SceneError::NoFaces`].
pub fn read(bytes: &[u8], name: &Path, companions: &Companions) -> Result<Surface, SceneError> {
    // 1. Check and reduce. Bytes that are not UTF-8 occur in names only; their letters are replaced.
    let source = String::from_utf8_lossy(bytes);
    let reduced = text::reduce(&source).map_err(|(line, problem)| SceneError::Line {
        file: name.into(),
        line,
        problem,
    })?;
    if reduced.face_count == 0 {
        return Err(SceneError::NoFaces {
            file: name.into(),
            vertex_count: reduced.vertex_count,
            ignored_count: reduced.element_count + reduced.short_face_count,
            hint: "is it an OBJ file with `f` lines?",
        });
    }
    let mut surface = Surface::new(name);
    let ignored = [
        (reduced.element_count, "point and line elements"),
        (reduced.short_face_count, "faces of one or two corners"),
    ];
    for (count, what) in ignored.iter().filter(|(count, _)| *count > 0) {
        surface.warn(format_args!("{count} {what} ignored"));
    }

    // 2. Read the reduced text. All its faces have three corners or more.
    let surface = RefCell::new((surface, Ignored::default()));
    let read =
        tobj::load_obj_buf(&mut reduced.text.as_bytes(), &LoadOptions::default(), |library| {
            let (surface, ignored) = &mut *surface.borrow_mut();
            load_library(name, library, companions, surface, ignored)
        });
    let (parts, materials) =
        read.map_err(|source| SceneError::Refused { file: name.into(), source })?;
    let ((mut surface, ignored), materials) = (surface.into_inner(), materials.unwrap_or_default());
    ignored.warnings().for_each(|warning| surface.warn(warning));
    if !reduced.names_library && !reduced.materials_used.is_empty() {
        surface.warn(format_args!(
            "{} materials are used, but no material file is named (`mtllib`); \
             reflectance {DEFAULT_REFLECTANCE} instead",
            reduced.materials_used.len()
        ));
    }
    let is_defined = |used: &&String| materials.iter().any(|material| material.name == **used);
    if !materials.is_empty() {
        for used in reduced.materials_used.iter().filter(|used| !is_defined(used)) {
            surface.warn(format_args!("no material is called `{used}`"));
        }
    }

    // 3. Assemble the parts. `tobj` begins a new part wherever the name or the material changes, so parts and their
    //    faces
    // are in the order of the file.
    assemble(&mut surface, &reduced, parts, &materials);
    debug_assert_eq!(surface.face_count(), reduced.face_count);
    Ok(surface)
}

fn assemble(
    surface: &mut Surface,
    reduced: &Reduced,
    parts: Vec<tobj::Model>,
    materials: &[tobj::Material],
) {
    for name in &reduced.names {
        surface.add_object(name);
    }
    for part in parts {
        // In the reduced text, the name of an object is its number.
        let object = part.name.parse().unwrap_or(0);
        let material = part.mesh.material_id.and_then(|id| materials.get(id));
        surface.begin_part(object, material.map_or(Material::DEFAULT, converted));
        let first = surface.vertex_count() as u32;
        for position in part.mesh.positions.chunks_exact(3) {
            surface.add_vertex([position[0], position[1], position[2]]);
        }
        // `face_arities` is empty if all faces are triangles.
        let mut arities = part.mesh.face_arities.iter();
        let mut corners = part.mesh.indices.as_slice();
        while !corners.is_empty() {
            let arity = arities.next().map_or(3, |&arity| arity as usize);
            let (face, rest) = corners.split_at(arity);
            surface.add_face(face.iter().map(|&corner| first + corner));
            corners = rest;
        }
    }
}

fn converted(material: &tobj::Material) -> Material {
    let rounded = |colour: [f64; 3]| colour.map(|component| component as f32);
    let reflecting = material.diffuse.map(rounded).map(Material::of_colour);
    let radiance = material.emissive.map_or([0.0; 3], rounded);
    Material { radiance, ..reflecting.unwrap_or(Material::DEFAULT) }
}

/// Reads the material files of an `mtllib` line: one file whose name may contain spaces, or several files, separated by
/// spaces, each in quotes or not.
fn load_library(
    model: &Path,
    library: &Path,
    companions: &Companions,
    surface: &mut Surface,
    ignored: &mut Ignored,
) -> tobj::MTLLoadResult {
    let beside = |name: &str| model.parent().unwrap_or(Path::new("")).join(name);
    // Tries the name as written, then with `/` for `\`.
    let open = |name: &str| -> Result<(PathBuf, Vec<u8>), (PathBuf, std::io::Error)> {
        let path = beside(name);
        companions(&path).map(|bytes| (path.clone(), bytes)).or_else(|error| {
            let turned = beside(&name.replace('\\', "/"));
            companions(&turned).map(|bytes| (turned, bytes)).map_err(|_| (path, error))
        })
    };
    let written = library.to_string_lossy();
    let files = match open(&written) {
        Ok(file) => vec![Ok(file)],
        Err(_) => words(&written).map(open).collect(),
    };
    let (mut reduced, mut warnings) = (String::new(), Vec::new());
    for file in files {
        match file {
            Ok((file, bytes)) => {
                let text = String::from_utf8_lossy(&bytes);
                ignored.join(&materials::reduce(&text, &file, &mut reduced, &mut warnings));
            }
            Err((file, error)) => warnings.push(format!(
                "cannot read the material file {}: {error}; \
                 reflectance {DEFAULT_REFLECTANCE} instead",
                file.display()
            )),
        }
    }
    for warning in warnings {
        surface.warn(warning);
    }
    if reduced.is_empty() {
        return Err(LoadError::OpenFileFailed);
    }
    tobj::load_mtl_buf(&mut reduced.as_bytes())
}

/// Splits a line into words. Text in quotes is one word.
fn words(line: &str) -> impl Iterator<Item = &str> {
    let mut rest = line;
    std::iter::from_fn(move || {
        rest = rest.trim_start();
        let (word, after) = match rest.strip_prefix('"').and_then(|rest| rest.split_once('"')) {
            Some(quoted) => quoted,
            None => rest.split_once(char::is_whitespace).unwrap_or((rest, "")),
        };
        rest = after;
        (!word.is_empty()).then_some(word)
    })
}

#[cfg(test)]
mod tests;
