//! Well-formed OBJ files, and the division of their polygons.
//!
//! Workload: up to 16 vertices on a lattice of a plane, upright or slanted, and up to three faces of up to 16 corners,
//! by positive and negative numbers. Many faces are simple, few convex. Spellings vary as the format allows: line ends,
//! comments and names that end in a backslash, continuations, texture coordinates, groups, lines that are ignored. Each
//! byte of the input is one choice.
//!
//! Constraints: every file must be read, with the same corners in the same order and `n - 2` triangles a face. The
//! triangles of a simple polygon cover it once; exact integers decide whether a polygon is simple.
#![no_main]

use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::path::Path;

use arbitrary::{Arbitrary, Unstructured};
use arboleda::{Triangle, Vec3};
use arboleda_fuzz::surfaces::becomes_triangles;
use arboleda_host::scene::Origin;
use arboleda_host::scene::formats::obj;
use arboleda_tests::oracle::polygon::{Point, doubled_area, is_simple, untangle};
use libfuzzer_sys::fuzz_target;

#[derive(Debug)]
struct Case {
    text: String,
    /// Vertices in coordinates of the plane.
    points: Vec<Point>,
    /// Vertices in space.
    positions: Vec<[i64; 3]>,
    faces: Vec<Vec<usize>>,
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(input: &mut Unstructured<'a>) -> arbitrary::Result<Self> {
        let mut text = String::new();
        // 1. Vertices in a plane, which is that of two axes, or slanted.
        let plane = input.int_in_range(0..=5_u8)?;
        let (mut points, mut positions) = (Vec::new(), Vec::new());
        for _ in 0..input.int_in_range(3..=16_u8)? {
            let mut whole = || input.int_in_range(0..=6_u8).map(i64::from);
            let [x, y] = [whole()?, whole()?];
            let position = match plane {
                0 => [x, y, 0],
                1 => [5, x, y],
                2 => [y, -3, x],
                3 => [y, x, x + y],
                4 => [x, 3 * x - y, y],
                _ => [x - y, x + y, 1000 - 7 * x],
            };
            points.push([x, y]);
            positions.push(position);
            let [x, y, z] = position;
            let weight = *input.choose(&["", " 1.0", "  1 0.5 0.25", "\t# here"])?;
            write!(text, "v {x} {y}.0 {z}e0{weight}{}", end(input)?).expect("a string");
        }
        // 2. Faces, and lines between them.
        let mut faces = Vec::new();
        for _ in 0..input.int_in_range(1..=3_u8)? {
            text.push_str(input.choose(&[
                "",
                "# made in C:\\models\\",
                "g C:\\",
                "usemtl tex\\",
                "o a thing",
                "s off",
                "l 1 2",
                "f 1 2",
                "vn 0 0 1 # \\",
            ])?);
            text.push_str(end(input)?);
            text.push('f');
            let face = face(input, &points)?;
            for &place in &face {
                text.push_str(input.choose(&[" ", " ", " ", "  ", "\t", " \\\n", " \\ \r\n "])?);
                if input.int_in_range(0..=1_u8)? == 0 {
                    write!(text, "{}", place + 1).expect("a string");
                } else {
                    write!(text, "-{}", points.len() - place).expect("a string");
                }
                text.push_str(input.choose(&["", "", "", "/1", "//1", "/7/9", "/-1/"])?);
            }
            text.push_str(input.choose(&["", "", " # a face", " # \\"])?);
            text.push_str(end(input)?);
            faces.push(face);
        }
        Ok(Self { text, points, positions, faces })
    }
}

/// Draws the corners of a face: any corners, or distinct corners in an order in which few sides cross.
fn face(input: &mut Unstructured<'_>, points: &[Point]) -> arbitrary::Result<Vec<usize>> {
    let is_untangled = input.int_in_range(0..=2_u8)? > 0;
    let mut corners = Vec::new();
    for _ in 0..input.int_in_range(3..=16_u8)? {
        corners.push(input.choose_index(points.len())?);
    }
    let mut seen = HashSet::new();
    let mut distinct: Vec<Point> = corners.iter().map(|&place| points[place]).collect();
    distinct.retain(|&point| seen.insert(point));
    if !is_untangled || distinct.len() < 3 {
        return Ok(corners);
    }
    untangle(&mut distinct, 100);
    let place = |point: &Point| points.iter().position(|other| other == point);
    Ok(distinct.iter().filter_map(place).collect())
}

fn end(input: &mut Unstructured<'_>) -> arbitrary::Result<&'static str> {
    input.choose(&["\n", "\n", "\n", "\r\n", "\r", "\n\n", " \n"]).copied()
}

fuzz_target!(|case: Case| {
    let Case { text, points, positions, faces } = case;
    let companions = |_: &Path| Err(std::io::ErrorKind::NotFound.into());
    let surface = match obj::read(text.as_bytes(), Path::new("input.obj"), &companions) {
        Ok(surface) => surface,
        Err(error) => panic!("{error}, in\n{text}"),
    };

    // 1. The surface has the same corners.
    let written: Vec<Vec<[f64; 3]>> = faces
        .iter()
        .map(|face| face.iter().map(|&at| positions[at].map(|x| x as f64)).collect())
        .collect();
    let read: Vec<Vec<[f64; 3]>> = surface
        .faces()
        .map(|face| face.iter().map(|&at| surface.vertices()[at as usize]).collect())
        .collect();
    assert_eq!(read, written, "in\n{text}");
    becomes_triangles(&surface);

    // 2. Simple polygons are covered once: all triangles have the polygon's orientation and, together, its area.
    let import = surface.place(Origin::Unchanged).expect("finite");
    let key = |position: [f32; 3]| position.map(|x| (x + 0.0).to_bits());
    let place_of: HashMap<[u32; 3], Point> =
        positions.iter().map(|p| key(p.map(|x| x as f32))).zip(points.iter().copied()).collect();
    let at = |corner: Vec3| place_of[&key(corner.to_array())];
    let mut rest = import.model.triangles.as_slice();
    let mut all_simple = true;
    for face in &faces {
        let polygon: Vec<Point> = face.iter().map(|&place| points[place]).collect();
        let (triangles, after) = rest.split_at(face.len() - 2);
        rest = after;
        if !is_simple(&polygon) {
            all_simple = false;
            continue;
        }
        let area = doubled_area(&polygon);
        let area_of = |t: &Triangle| doubled_area(&[at(t.a), at(t.b), at(t.c)]);
        let covered: i64 = triangles.iter().map(|t| area_of(t).abs()).sum();
        assert_eq!(covered, area.abs(), "{polygon:?} became {triangles:?}");
        assert!(triangles.iter().all(|t| area_of(t).signum() * area.signum() >= 0), "{polygon:?}");
    }
    let crossing = import.warnings.iter().find(|warning| warning.contains("cross themselves"));
    assert!(!all_simple || crossing.is_none(), "{crossing:?}, in\n{text}");
});
