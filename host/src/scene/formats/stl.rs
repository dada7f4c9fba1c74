//! Reader of STL files, text and binary: triangles, each with three vertices of its own.
//!
//! The crates `stl_io` 0.11 and `nom_stl` 4 are not used, for four reasons:
//!
//! - They round decimals to `f32` while reading, before `--origin` is subtracted.
//! - They refuse normals that are not finite.
//! - They stop after the first solid.
//! - They read binary files whose heading begins with `solid` as text.
//!
//! # Source
//! 3D Systems, *Stereolithography Interface Specification*, 1988. Normals and attributes are not read.

use std::path::Path;

use super::lines::lines;
use crate::scene::SceneError;
use crate::scene::surface::{Material, Surface};

/// Bytes before the first triangle of a binary file: a heading of 80 bytes, and the number of triangles.
const HEADING: usize = 84;
/// Bytes of a triangle: a normal, three corners, two bytes of attributes.
const RECORD: usize = 50;

/// Tells whether the bytes are a binary file: whether their length is exactly that of the claimed number of triangles,
/// and the number is above 0.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    claimed(bytes).is_some_and(|count| {
        count > 0 && (HEADING as u64 + u64::from(count) * RECORD as u64) == bytes.len() as u64
    })
}

/// Tells whether the bytes begin as a text file does.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let mut words = bytes
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .map(<[u8]>::to_ascii_lowercase);
    words.next().as_deref() == Some(b"solid")
        && words.take(64).any(|word| word == b"facet" || word == b"endsolid")
}

/// Reads the number of triangles that a binary file claims.
fn claimed(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(80..HEADING)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]))
}

/// Reads the bytes of an STL file. Each solid is an object.
///
/// # Errors
/// [`SceneError::Malformed`], [`SceneError::NoFaces`].
pub fn read(bytes: &[u8], name: &Path) -> Result<Surface, SceneError> {
    let mut surface = Surface::new(name);
    if !is_binary(bytes) && is_text(bytes) {
        read_text(&String::from_utf8_lossy(bytes), &mut surface)?;
    } else {
        read_binary(bytes, &mut surface)?;
    }
    if surface.face_count() == 0 {
        return Err(SceneError::NoFaces {
            file: name.into(),
            vertex_count: surface.vertex_count(),
            ignored_count: 0,
            hint: "is it an STL file with facets?",
        });
    }
    Ok(surface)
}

fn read_binary(bytes: &[u8], surface: &mut Surface) -> Result<(), SceneError> {
    let Some(count) = claimed(bytes) else {
        return Err(surface.malformed(
            "heading",
            format_args!("it is neither text that begins with `solid` nor {HEADING} bytes long"),
        ));
    };
    let records = bytes[HEADING..].chunks_exact(RECORD);
    if (records.len() as u64) < u64::from(count) {
        return Err(surface.malformed(
            "heading",
            format_args!("it claims {count} triangles, but there are only {}", records.len()),
        ));
    }
    if records.len() > count as usize || !records.remainder().is_empty() {
        let rest = bytes.len() - HEADING - count as usize * RECORD;
        surface.warn(format_args!("{rest} bytes after the last triangle ignored"));
    }
    let object = surface.add_object("unnamed");
    surface.begin_part(object, Material::DEFAULT);
    for record in records.take(count as usize) {
        let corner = |first: usize| {
            [0, 4, 8].map(|at| {
                let bytes = &record[first + at..first + at + 4];
                f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
            })
        };
        surface.add_triangle([12, 24, 36].map(corner));
    }
    Ok(())
}

/// Reads a text file. Keywords are case-insensitive, and a line may hold several.
fn read_text(text: &str, surface: &mut Surface) -> Result<(), SceneError> {
    let mut corners: Vec<[f64; 3]> = Vec::with_capacity(3);
    let mut name = String::new();
    let mut is_begun = false;
    let mut is_ended = false;
    for (number, line) in (1..).zip(lines(text)) {
        let wrong = |surface: &Surface, problem: &dyn std::fmt::Display| {
            surface.malformed(format!("line {number}"), problem)
        };
        let mut words = line.split_whitespace();
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_str() {
                "solid" => {
                    name = words.by_ref().collect::<Vec<_>>().join(" ");
                    (is_begun, is_ended) = (false, false);
                }
                "endsolid" => {
                    words.by_ref().for_each(drop);
                    is_ended = true;
                }
                "vertex" => {
                    let mut corner = [0.0; 3];
                    for coordinate in &mut corner {
                        let text = words.next().unwrap_or_default();
                        *coordinate = text.parse().map_err(|_| {
                            wrong(surface, &format_args!("coordinate `{text}` is not a number"))
                        })?;
                    }
                    corners.push(corner);
                }
                "endfacet" => {
                    let &[a, b, c] = corners.as_slice() else {
                        let count = corners.len();
                        return Err(wrong(
                            surface,
                            &format_args!("a facet needs 3 vertices, but has {count}"),
                        ));
                    };
                    // The object begins with its first facet, because a solid without facets is not an object.
                    if !is_begun {
                        let name = if name.is_empty() { "unnamed" } else { &name };
                        let object = surface.add_object(name);
                        surface.begin_part(object, Material::DEFAULT);
                        is_begun = true;
                    }
                    surface.add_triangle([a, b, c]);
                    corners.clear();
                }
                // The normal is skipped, so it may have any value.
                "facet" => words.by_ref().take(4).for_each(drop),
                "outer" | "loop" | "endloop" => {}
                _ => return Err(wrong(surface, &format_args!("`{word}` is not a keyword of STL"))),
            }
        }
    }
    if !corners.is_empty() {
        return Err(surface.malformed("end of the file", "a facet is not ended"));
    }
    if !is_ended {
        surface.warn(format_args!("there is no `endsolid` at its end: is it cut off?"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Import, Origin};

    fn import(bytes: &[u8]) -> Result<Import, SceneError> {
        read(bytes, Path::new("test.stl"))?.place(Origin::Unchanged)
    }

    const TEXT: &str = "solid a part\nfacet normal nan 0 0\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n \
                        vertex 0 1e0 0\n endloop\nendfacet\nendsolid a part\nSOLID\r\nFACET NORMAL 0 0 1 \
                        OUTER LOOP VERTEX 0 0 1 VERTEX 1 0 1 VERTEX 0 1 1 ENDLOOP ENDFACET\nENDSOLID\n";

    fn binary(heading: &str, triangles: &[[f32; 9]]) -> Vec<u8> {
        let mut bytes = heading.as_bytes().to_vec();
        bytes.resize(80, 0);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([7; 2]);
        }
        bytes
    }

    #[test]
    fn text_and_binary() {
        let Import { model, warnings, .. } = import(TEXT.as_bytes()).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(model.object_names, ["a part", "unnamed"]);
        assert_eq!((model.objects.as_slice(), model.triangles[1].b.z), (&[0, 1][..], 1.0));
        let macintosh = import(TEXT.replace('\n', "\r").as_bytes()).unwrap().model;
        assert_eq!(macintosh, model);
        let (whole, _) = TEXT.rsplit_once("ENDSOLID").unwrap();
        let cut = import(whole.as_bytes()).unwrap();
        assert_eq!(cut.model, model);
        assert_eq!(cut.warnings, ["test.stl: there is no `endsolid` at its end: is it cut off?"]);
        // The second heading looks like text.
        for heading in ["", "solid facet"] {
            let triangle = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
            let bytes = binary(heading, &[triangle; 2]);
            let import = import(&bytes).unwrap();
            assert_eq!(import.model.triangles, [model.triangles[0]; 2]);
            assert!(import.warnings.is_empty());
        }
    }

    #[test]
    fn decimals_keep_their_digits_until_the_origin_is_subtracted() {
        let text = TEXT.replace("vertex 0 0 0", "vertex 4649776.1 0 0");
        let surface = read(text.as_bytes(), Path::new("test.stl")).unwrap();
        let model = surface.place(Origin::At([4_649_776.0, 0.0, 0.0])).unwrap().model;
        assert!((model.triangles[0].a.x - 0.1).abs() < 1e-6);
    }

    #[test]
    fn errors_name_the_place() {
        let mut many = binary("", &[[0.0; 9]]);
        many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        for (bytes, message) in [
            (many, "heading: it claims 4294967295 triangles, but there are only 1"),
            (TEXT.replace("1e0", "x").into(), "line 6: coordinate `x` is not a number"),
            (
                TEXT.replace("vertex 1 0 0", "").into(),
                "line 8: a facet needs 3 vertices, but has 2",
            ),
            (
                TEXT.replacen("endfacet", "", 1).into(),
                "line 11: a facet needs 3 vertices, but has 6",
            ),
            (TEXT.replace("ENDFACET", "").into(), "end of the file: a facet is not ended"),
            (TEXT.replace("OUTER", "inner").into(), "line 11: `inner` is not a keyword of STL"),
            (
                b"soli".to_vec(),
                "heading: it is neither text that begins with `solid` nor 84 bytes long",
            ),
            (
                b"solid\nendsolid\n".to_vec(),
                "no faces of three or more corners found (0 vertices, 0 points, lines and shorter faces); \
                 is it an STL file with facets?",
            ),
        ] {
            let error = import(&bytes).unwrap_err().to_string();
            let (_, rest) = error.split_once("test.stl").unwrap();
            assert_eq!(rest.trim_start_matches([',', ':']).trim_start(), message);
        }
    }
}
