//! Files that `cast` writes: hits, hit points, normals, and the objects of the triangles.

use std::path::Path;

use arboleda::Hit;
use serde::Serialize;

use crate::files::output::{write_file, write_npy};
use crate::scene::Model;
use crate::scene::vector::Vector64;

/// Row of a file of hits. A miss has the largest id and an infinite `t`.
#[derive(npyz::Serialize, npyz::AutoSerialize, Clone, Copy)]
pub struct HitRecord {
    triangle: u32,
    t: f32,
    u: f32,
    v: f32,
}

impl HitRecord {
    /// The row of a miss.
    pub const MISS: Self =
        Self { triangle: Hit::NONE.triangle.0, t: Hit::NONE.t, u: Hit::NONE.u, v: Hit::NONE.v };
    /// The row of an occluded ray; its numbers are not those of a triangle that was hit.
    pub const OCCLUDED: Self = Self { triangle: 0, t: 0.0, u: 0.0, v: 0.0 };

    /// Tells whether the record is a hit.
    pub fn is_hit(&self) -> bool {
        self.triangle != Self::MISS.triangle
    }
}

impl From<Hit> for HitRecord {
    fn from(hit: Hit) -> Self {
        Self { triangle: hit.triangle.0, t: hit.t, u: hit.u, v: hit.v }
    }
}

/// Computes the hit points in the coordinates of the scene's file; NaN for a miss.
///
/// A point is interpolated between the corners by `u` and `v`, in `f64`. A point from `t` would lie off the triangle if
/// the ray begins far away.
pub fn points(model: &Model, records: &[HitRecord]) -> Vec<f64> {
    let mut points = per_hit(model, records, |[a, b, c], record| {
        a + (b - a) * f64::from(record.u) + (c - a) * f64::from(record.v)
    });
    for (coordinate, origin) in points.iter_mut().zip(model.origin.iter().cycle()) {
        *coordinate += origin;
    }
    points
}

/// Writes the hit points: in `f32`, the precision of the triangles, or in `f64` if an origin was subtracted.
///
/// `f32` would lose the digits that the origin saved.
///
/// # Errors
/// If the file cannot be written.
pub fn write_points(path: &Path, model: &Model, records: &[HitRecord]) -> anyhow::Result<()> {
    let (shape, points) = ([records.len(), 3], points(model, records));
    if model.origin == [0.0; 3] {
        let rounded: Vec<f32> = points.iter().map(|&coordinate| coordinate as f32).collect();
        write_npy(path, &shape, &rounded)
    } else {
        write_npy(path, &shape, &points)
    }
}

/// Computes the unit normals in `f64`; NaN for a miss.
///
/// A normal points to the side from which the corners are seen counter-clockwise.
pub fn normals(model: &Model, records: &[HitRecord]) -> Vec<f32> {
    let normals = per_hit(model, records, |[a, b, c], _| {
        // Components of edges are multiples of 2^-149 below 2^129, so squares of their products neither overflow nor
        // underflow in `f64`.
        let normal = (b - a).cross(c - a);
        normal / normal.length()
    });
    normals.iter().map(|&coordinate| coordinate as f32).collect()
}

fn per_hit(
    model: &Model,
    records: &[HitRecord],
    vector: impl Fn([Vector64; 3], &HitRecord) -> Vector64,
) -> Vec<f64> {
    let mut coordinates = Vec::with_capacity(3 * records.len());
    for record in records {
        let values = match model.triangles.get(record.triangle as usize) {
            Some(&triangle) => {
                let corners = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
                vector(corners, record).to_array()
            }
            None => [f64::NAN; 3],
        };
        coordinates.extend(values);
    }
    coordinates
}

/// Consecutive triangles of one object.
#[derive(Serialize)]
struct ObjectRun<'m> {
    first_triangle: usize,
    triangle_count: usize,
    object: &'m str,
}

/// Writes the object of each triangle as CSV: one row for each run of consecutive ids, in the order of the ids.
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
            writer.serialize(ObjectRun { first_triangle, triangle_count: run.len(), object })?;
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
            let records = [hit(0).into(), HitRecord::MISS, hit(1).into()];
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
