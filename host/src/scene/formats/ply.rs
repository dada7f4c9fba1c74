//! Reader of PLY files, by the crate `ply-rs-bw`: text, and binary of either byte order.
//!
//! The file is read row by row into types of this module. A claimed number of rows therefore reserves no memory, and no
//! map of properties is allocated for a row.
//!
//! # Source
//! G. Turk, *The PLY polygon file format*, 1994. The elements `vertex` (`x`, `y`, `z`) and `face` (`vertex_indices` or
//! `vertex_index`) are read; colours, normals and strips are ignored.

use std::borrow::Cow;
use std::io::BufRead;
use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use crate::scene::SceneError;
use crate::scene::surface::{Material, Surface};

/// Reads the bytes of a PLY file; its faces are one object.
///
/// # Errors
/// [`SceneError::Malformed`], [`SceneError::NoFaces`].
pub fn read(bytes: &[u8], name: &Path) -> Result<Surface, SceneError> {
    let mut surface = Surface::new(name);
    let bytes = &*with_usual_lines(bytes);
    // 1. The header. Decimals that are declared as f32 are read as f64, because the origin is subtracted before
    //    rounding.
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader);
    let mut header = header.map_err(|error| surface.malformed("header", one_line(&error)))?;
    if header.encoding == Encoding::Ascii
        && let Some(vertex) = header.elements.get_mut("vertex")
    {
        for (_, property) in &mut vertex.properties {
            if property.data_type == PropertyType::Scalar(ScalarType::Float) {
                property.data_type = PropertyType::Scalar(ScalarType::Double);
            }
        }
    }

    // 2. The elements, in the order of the file.
    let object = surface.add_object("unnamed");
    surface.begin_part(object, Material::DEFAULT);
    let mut short_face_count = 0;
    for (_, element) in &header.elements {
        let mut rows = Rows { reader: &mut reader, header: &header, element };
        match element.name.as_str() {
            "vertex" => rows.each(&mut surface, |surface, row: VertexRow| {
                let position = [row.0[0], row.0[1], row.0[2]];
                let [Some(x), Some(y), Some(z)] = position else {
                    return Err("it has no coordinates `x`, `y`, `z`".into());
                };
                surface.add_vertex([x, y, z]);
                Ok(())
            })?,
            "face" => rows.each(&mut surface, |surface, row: FaceRow| {
                let Some(corners) = row.0 else {
                    return Err("it has no list `vertex_indices` of numbers from 0 up".into());
                };
                if corners.len() < 3 {
                    short_face_count += 1;
                } else {
                    surface.add_face(corners);
                }
                Ok(())
            })?,
            _ => rows.each(&mut surface, |_, _: Skipped| Ok(()))?,
        }
    }

    // 3. Checks of the whole file. Faces may precede the vertices, so corners are checked here.
    let rest = match header.encoding {
        Encoding::Ascii => reader.get_mut().trim_ascii(),
        _ => *reader.get_mut(),
    };
    if !rest.is_empty() {
        surface.warn(format_args!("{} bytes after the last element ignored", rest.len()));
    }
    if surface.face_count() == 0 {
        return Err(SceneError::NoFaces {
            file: name.into(),
            vertex_count: surface.vertex_count(),
            ignored_count: short_face_count,
            hint: "is it a mesh, not a cloud of points or strips?",
        });
    }
    if short_face_count > 0 {
        surface.warn(format_args!("{short_face_count} faces of one or two corners ignored"));
    }
    match surface.missing_corner() {
        Some((face, corner)) => {
            let count = surface.vertex_count();
            Err(surface.malformed(
                format!("face {face} of three or more corners, from 0"),
                format_args!("it names vertex {corner}, but there are {count} vertices"),
            ))
        }
        None => Ok(surface),
    }
}

/// Replaces the line ends of old Macintoshes, which the parser does not know, in a text file.
fn with_usual_lines(bytes: &[u8]) -> Cow<'_, [u8]> {
    const LONGEST_HEADING: usize = 1000;
    let heading = &bytes[..bytes.len().min(LONGEST_HEADING)];
    let is_text = heading.starts_with(b"ply\r")
        && !heading.starts_with(b"ply\r\n")
        && memchr::memmem::find(heading, b"\rformat ascii").is_some();
    let turned = |&byte: &u8| if byte == b'\r' { b'\n' } else { byte };
    if is_text { bytes.iter().map(turned).collect() } else { bytes.into() }
}

/// Rows of an element.
struct Rows<'r, 'b> {
    reader: &'r mut Reader<&'b [u8]>,
    header: &'r Header,
    element: &'r ElementDef,
}

impl Rows<'_, '_> {
    /// Reads each row and passes it to `take`, which adds it to the surface or refuses it.
    fn each<E: PropertyAccess>(
        &mut self,
        surface: &mut Surface,
        mut take: impl FnMut(&mut Surface, E) -> Result<(), String>,
    ) -> Result<(), SceneError> {
        let Self { reader, header, element } = self;
        let name = &element.name;
        // A row of at least one byte ends a count that is too high at the end of the file. A row without properties
        // would not.
        if element.properties.is_empty() && element.count > 0 {
            return Err(surface.malformed(format!("element `{name}`"), "it has no properties"));
        }
        let parser = Parser::<E>::new();
        let mut line = String::new();
        for number in 0..element.count {
            let row = match header.encoding {
                Encoding::Ascii => next_line(reader.get_mut(), &mut line)
                    .and_then(|()| parser.read_ascii_element(&line, element).map_err(Into::into)),
                Encoding::BinaryBigEndian => {
                    parser.read_big_endian_element(reader.get_mut(), element).map_err(Into::into)
                }
                Encoding::BinaryLittleEndian => {
                    parser.read_little_endian_element(reader.get_mut(), element).map_err(Into::into)
                }
            };
            let taken = row.map_err(|error| {
                let is_end = error.kind() == std::io::ErrorKind::UnexpectedEof;
                if is_end { "the file ends before it".into() } else { one_line(&error) }
            });
            taken.and_then(|row| take(surface, row)).map_err(|problem| {
                surface.malformed(format!("{name} {number} of {}, from 0", element.count), problem)
            })?;
        }
        Ok(())
    }
}

/// Reads the next line that is not blank.
fn next_line(bytes: &mut &[u8], line: &mut String) -> std::io::Result<()> {
    loop {
        line.clear();
        if bytes.read_line(line)? == 0 {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        if !line.trim().is_empty() {
            return Ok(());
        }
    }
}

/// Shortens a message of the parser to one line. Messages span several lines and quote the whole input.
fn one_line(error: &dyn std::fmt::Display) -> String {
    const LONGEST: usize = 200;
    let text = error.to_string();
    let mut words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((end, _)) = words.char_indices().nth(LONGEST) {
        words.truncate(end);
        words.push_str("...");
    }
    words
}

/// Coordinates of a vertex; `None` for a coordinate that the row lacks.
struct VertexRow([Option<f64>; 3]);

impl PropertyAccess for VertexRow {
    fn new() -> Self {
        Self([None; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[axis] = match property {
            Property::Char(value) => Some(value.into()),
            Property::UChar(value) => Some(value.into()),
            Property::Short(value) => Some(value.into()),
            Property::UShort(value) => Some(value.into()),
            Property::Int(value) => Some(value.into()),
            Property::UInt(value) => Some(value.into()),
            Property::Float(value) => Some(value.into()),
            Property::Double(value) => Some(value),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// Corners of a face; `None` without a list, or if the list has a negative number.
struct FaceRow(Option<Vec<u32>>);

impl PropertyAccess for FaceRow {
    fn new() -> Self {
        Self(None)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListUInt(values) => Some(values),
            other => other.to_u32_list(),
        };
        PropertyAccessResult::Set
    }
}

/// Row of an element that is ignored.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Import, Origin};

    fn import(bytes: &[u8]) -> Result<Import, SceneError> {
        read(bytes, Path::new("test.ply"))?.place(Origin::Unchanged)
    }

    fn header(format: &str, number: &str, faces: usize) -> String {
        format!(
            "ply\nformat {format} 1.0\ncomment made by hand\nelement vertex 4\nproperty {number} x\n\
             property {number} y\nproperty {number} z\nproperty uchar red\nelement face {faces}\n\
             property list uchar int vertex_indices\nproperty float quality\nend_header\n"
        )
    }

    const ROWS: &str = "0 0 0 1\n4 2 0 2\n0 4 0 3\n1 2 0 4\n4 0 1 2 3 0.5\n3 0 1 2 0.5\n2 0 1 0\n";

    #[test]
    fn text_and_both_byte_orders_agree() {
        let text = header("ascii", "float", 3) + ROWS;
        let expected = import(text.as_bytes()).unwrap();
        assert_eq!(expected.warnings, ["test.ply: 1 faces of one or two corners ignored"]);
        // The areas of the dart, which is 6, and of a triangle.
        let areas: Vec<f32> = expected
            .model
            .triangles
            .iter()
            .map(|triangle| triangle.normal().length() / 2.0)
            .collect();
        assert_eq!((areas.len(), areas[0] + areas[1], areas[2]), (3, 6.0, 8.0));
        let longer = import((text.clone() + "3 0 1 2 0.5\n\n").as_bytes()).unwrap();
        assert_eq!(longer.model, expected.model);
        assert_eq!(longer.warnings[0], "test.ply: 11 bytes after the last element ignored");
        for ending in ["\r\n", "\r"] {
            let text = text.replace('\n', ending);
            assert_eq!(import(text.as_bytes()).unwrap().model, expected.model);
        }

        for big in [false, true] {
            let format = if big { "binary_big_endian" } else { "binary_little_endian" };
            let mut bytes = header(format, "double", 3).into_bytes();
            for row in ROWS.lines() {
                let numbers: Vec<f64> = row.split(' ').map(|word| word.parse().unwrap()).collect();
                if numbers.len() == 4 && row != "2 0 1 0" {
                    for x in &numbers[..3] {
                        bytes.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
                    }
                    bytes.push(numbers[3] as u8);
                } else {
                    let (quality, list) = numbers.split_last().unwrap();
                    bytes.push(list[0] as u8);
                    for &corner in &list[1..] {
                        let corner = corner as i32;
                        bytes.extend(if big { corner.to_be_bytes() } else { corner.to_le_bytes() });
                    }
                    let quality = *quality as f32;
                    bytes.extend(if big { quality.to_be_bytes() } else { quality.to_le_bytes() });
                }
            }
            let read = import(&bytes).unwrap();
            assert_eq!(
                (read.model, read.warnings),
                (expected.model.clone(), expected.warnings.clone())
            );
            let longer = import(&[&bytes[..], &[0]].concat()).unwrap();
            assert_eq!(longer.warnings[0], "test.ply: 1 bytes after the last element ignored");
            // A file cut off anywhere is an error.
            for end in 0..bytes.len() {
                assert!(import(&bytes[..end]).is_err());
            }
        }
    }

    #[test]
    fn decimals_keep_their_digits_until_the_origin_is_subtracted() {
        let text = header("ascii", "float", 3) + &ROWS.replacen("0 0 0 1", "4649776.1 0 0 1", 1);
        let surface = read(text.as_bytes(), Path::new("test.ply")).unwrap();
        let model = surface.place(Origin::At([4_649_776.0, 0.0, 0.0])).unwrap().model;
        assert!((model.triangles[2].a.x - 0.1).abs() < 1e-6, "{:?}", model.triangles);
    }

    #[test]
    fn errors_name_the_place() {
        let text = header("ascii", "float", 3) + ROWS;
        for (from, to, message) in [
            (
                "3 0 1 2 0.5",
                "3 0 1 9 0.5",
                "face 1 of three or more corners, from 0: it names vertex 9, but there are 4 vertices",
            ),
            (
                "3 0 1 2 0.5",
                "3 0 1 -2 0.5",
                "face 1 of 3, from 0: it has no list `vertex_indices` of numbers from 0 up",
            ),
            (
                "element face 3",
                "element face 999999999999",
                "face 3 of 999999999999, from 0: the file ends before it",
            ),
            (
                "element face 3",
                "element empty 999999999999\nelement face 3",
                "element `empty`: it has no properties",
            ),
            (
                "property float y",
                "property float w",
                "vertex 0 of 4, from 0: it has no coordinates `x`, `y`, `z`",
            ),
            ("4 2 0 2", "4 two 0 2", "vertex 1 of 4, from 0: "),
            ("format ascii", "format text", "header: "),
            (
                "element face",
                "element edge",
                "no faces of three or more corners found (4 vertices, ",
            ),
        ] {
            let error = import(text.replace(from, to).as_bytes()).unwrap_err().to_string();
            let (_, rest) = error.split_once("test.ply").unwrap();
            let rest = rest.trim_start_matches([',', ':']).trim_start();
            assert!(rest.starts_with(message), "{rest}");
            assert!(!rest.contains('\n') && rest.len() < 300, "{rest}");
        }
    }
}
