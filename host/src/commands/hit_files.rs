//! The files that `cast` writes: hits, and the points, normals and object names that follow from hits and the model.

use std::path::Path;

use arboleda::Hit;
use npyz::WriterBuilder;
use serde::Serialize;

use crate::file_output::write_file;
use crate::photon::Vector64;
use crate::scene::Model;

/// One hit in a file; a miss is the largest id and an infinite `t`.
#[derive(npyz::Serialize, npyz::AutoSerialize, Clone, Copy)]
pub struct Record {
    triangle: u32,
    t: f32,
    u: f32,
    v: f32,
}

impl Record {
    /// A miss.
    pub const MISS: Self =
        Self { triangle: Hit::NONE.triangle.0, t: Hit::NONE.t, u: Hit::NONE.u, v: Hit::NONE.v };
    /// A hit of any triangle at any `t`.
    pub const SOME: Self = Self { triangle: 0, t: 0.0, u: 0.0, v: 0.0 };

    /// Tells whether the record is a hit.
    pub fn is_hit(&self) -> bool {
        self.triangle != Self::MISS.triangle
    }
}

impl From<Hit> for Record {
    fn from(hit: Hit) -> Self {
        Self { triangle: hit.triangle.0, t: hit.t, u: hit.u, v: hit.v }
    }
}

/// Computes the hit points, in the coordinates of the scene's file; NaN for a miss. They come from `u` and `v` in `f64`
/// and not from `t`, so that they lie on the triangle wherever the ray began.
pub fn points(model: &Model, records: &[Record]) -> Vec<f64> {
    let mut points = per_hit(model, records, |[a, b, c], record| {
        a + (b - a) * f64::from(record.u) + (c - a) * f64::from(record.v)
    });
    for (coordinate, origin) in points.iter_mut().zip(model.origin.iter().cycle()) {
        *coordinate += origin;
    }
    points
}

/// Writes the hit points: in `f32`, as the coordinates of the triangles are; or in `f64` if an origin was subtracted,
/// since `f32` cannot hold the file's coordinates then.
///
/// # Errors
/// If the file cannot be written.
pub fn write_points(path: &Path, model: &Model, records: &[Record]) -> anyhow::Result<()> {
    let (shape, points) = ([records.len(), 3], points(model, records));
    if model.origin == [0.0; 3] {
        let rounded: Vec<f32> = points.iter().map(|&coordinate| coordinate as f32).collect();
        write_npy(path, &shape, &rounded)
    } else {
        write_npy(path, &shape, &points)
    }
}

/// Computes the unit normals in `f64`; NaN for a miss. They point to the side from which the corners are seen
/// counter-clockwise.
pub fn normals(model: &Model, records: &[Record]) -> Vec<f32> {
    let normals = per_hit(model, records, |[a, b, c], _| {
        // Edges are multiples of 2^-149 below 2^129: the squares of their products are well within `f64`.
        let normal = (b - a).cross(c - a);
        normal / normal.length()
    });
    normals.iter().map(|&coordinate| coordinate as f32).collect()
}

fn per_hit(
    model: &Model,
    records: &[Record],
    vector: impl Fn([Vector64; 3], &Record) -> Vector64,
) -> Vec<f64> {
    let mut coordinates = Vec::with_capacity(3 * records.len());
    for record in records {
        let place = match model.triangles.get(record.triangle as usize) {
            Some(&triangle) => {
                let corners = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
                let Vector64 { x, y, z } = vector(corners, record);
                [x, y, z]
            }
            None => [f64::NAN; 3],
        };
        coordinates.extend(place);
    }
    coordinates
}

/// Writes values as an array; the product of `shape` is the number of values.
///
/// # Errors
/// If the file cannot be written.
pub fn write_npy<T: npyz::AutoSerialize + Copy>(
    path: &Path,
    shape: &[usize],
    values: &[T],
) -> anyhow::Result<()> {
    let shape: Vec<u64> = shape.iter().map(|&side| side as u64).collect();
    write_file(path, |file| {
        let mut writer =
            npyz::WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd()?;
        writer.extend(values.iter().copied())?;
        writer.finish()
    })
}

/// Triangles in a row that belong to one object.
#[derive(Serialize)]
struct Run<'m> {
    first_triangle: usize,
    triangle_count: usize,
    object: &'m str,
}

/// Writes which triangles belong to which object: a row for each run of ids, in the order of the ids.
///
/// # Errors
/// If the file cannot be written.
pub fn write_objects(path: &Path, model: &Model) -> anyhow::Result<()> {
    write_file(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        let mut first_triangle = 0;
        for run in model.objects.chunk_by(|a, b| a == b) {
            let object = run.first().and_then(|&object| model.object_names.get(object as usize));
            let object = object.map_or("", String::as_str);
            writer.serialize(Run { first_triangle, triangle_count: run.len(), object })?;
            first_triangle += run.len();
        }
        writer.flush()
    })
}

#[cfg(test)]
mod tests {
    use arboleda::{Triangle, TriangleId, Vec3};

    use super::*;

    #[test]
    fn points_and_normals_of_the_smallest_and_largest_triangles() {
        for scale in [1e-45_f32, 1e-38, 1e-20, 1.0, 1e20, 1e38] {
            let mut model = Model::named("one");
            let (x, y) = (Vec3::X * scale, Vec3::Y * scale);
            model.add_object("up", [Triangle::new(-x, x, y), Triangle::new(-x, y, x)], 0.5);
            let hit = |id| Hit { triangle: TriangleId(id), t: 1.0, u: 0.5, v: 0.0 };
            let records = [hit(0).into(), Record::MISS, hit(1).into()];
            let normals = normals(&model, &records);
            assert_eq!(normals[..3], [0.0, 0.0, 1.0], "{scale}");
            assert!(normals[3..6].iter().all(|coordinate| coordinate.is_nan()));
            assert_eq!(normals[6..], [0.0, 0.0, -1.0], "{scale}");
            let points = points(&model, &records);
            assert_eq!(points[..3], [0.0; 3], "{scale}");
            assert!(points[3..6].iter().all(|coordinate| coordinate.is_nan()));
        }
    }
}
