//! Files of the light on surfaces: `--triangles`, `--mesh-ply` and `--photons-ply` of `shoot`.
//!
//! PLY files are binary, little-endian. Comments name the scene, the photons, the seed and a photon's flux.

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

use crate::density::{PhotonHit, TriangleIrradiance};
use crate::files::output::{write_file, write_triangle_rows};
use crate::report::heat;
use crate::scene::Model;

/// Row of the file of triangles: by side, irradiance in W/m2, its standard error and photons.
#[derive(npyz::Serialize, npyz::AutoSerialize, Clone, Copy)]
struct TriangleRow {
    area: f64,
    front_irradiance: [f32; 3],
    back_irradiance: [f32; 3],
    front_error: f32,
    back_error: f32,
    front_photons: u32,
    back_photons: u32,
}

const COLUMNS: [&str; 12] = [
    "triangle",
    "area",
    "front_red",
    "front_green",
    "front_blue",
    "back_red",
    "back_green",
    "back_blue",
    "front_error",
    "back_error",
    "front_photons",
    "back_photons",
];

impl From<&TriangleIrradiance> for TriangleRow {
    fn from(light: &TriangleIrradiance) -> Self {
        Self {
            area: light.area,
            front_irradiance: light.front.irradiance,
            back_irradiance: light.back.irradiance,
            front_error: light.front.standard_error,
            back_error: light.back.standard_error,
            front_photons: light.front.count,
            back_photons: light.back.count,
        }
    }
}

/// Writes one row for each triangle, in the order of ids: as CSV if the name ends in .csv, else as a structured array.
///
/// # Errors
/// If the file cannot be written.
pub fn write_triangles(path: &Path, lights: &[TriangleIrradiance]) -> anyhow::Result<()> {
    write_triangle_rows(path, &COLUMNS, lights.iter().map(TriangleRow::from), |row| {
        let errors = (row.front_error, row.back_error);
        let photons = (row.front_photons, row.back_photons);
        (row.area, row.front_irradiance, row.back_irradiance, errors, photons)
    })
}

/// Writes the triangles as a mesh, each with the irradiance of both sides, and with false colours to look at.
///
/// # Errors
/// If the file cannot be written.
pub fn write_mesh(
    path: &Path,
    model: &Model,
    lights: &[TriangleIrradiance],
    comments: &[String],
) -> anyhow::Result<()> {
    // 1. Corners of the same bits are one vertex, in the order in which they occur.
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let mut vertices = Vec::new();
    let mut faces = Vec::with_capacity(model.triangles.len());
    for triangle in &model.triangles {
        faces.push([triangle.a, triangle.b, triangle.c].map(|corner| {
            let next = vertices.len() as u32;
            *numbers.entry(corner.to_array().map(f32::to_bits)).or_insert_with(|| {
                vertices.push(corner);
                next
            })
        }));
    }

    // 2. The brightest false colour is that of the 98th percentile of the lit triangles.
    let brightness = |light: &TriangleIrradiance| light.front.mean() + light.back.mean();
    let mut lit: Vec<f32> = lights.iter().map(brightness).filter(|&value| value > 0.0).collect();
    lit.sort_by(f32::total_cmp);
    let brightest = lit.get(lit.len() * 98 / 100).copied().unwrap_or(1.0);

    // 3. The file.
    let mut properties = vec!["list uchar uint vertex_indices".to_owned()];
    for side in ["front", "back"] {
        properties.extend(
            ["red", "green", "blue"].map(|colour| format!("float {side}_irradiance_{colour}")),
        );
    }
    properties.extend(["red", "green", "blue"].map(|colour| format!("uchar {colour}")));
    let elements = [
        ("vertex", vertices.len(), ["x", "y", "z"].map(|axis| format!("float {axis}")).to_vec()),
        ("face", faces.len(), properties),
    ];
    write_file(path, |file| {
        write_header(file, comments, &elements)?;
        for vertex in &vertices {
            write_floats(file, &vertex.to_array())?;
        }
        for (corners, light) in faces.iter().zip(lights) {
            file.write_all(&[3])?;
            corners.iter().try_for_each(|corner| file.write_all(&corner.to_le_bytes()))?;
            write_floats(file, &light.front.irradiance)?;
            write_floats(file, &light.back.irradiance)?;
            let colour = heat((brightness(light) / brightest).sqrt());
            file.write_all(&[colour.0, colour.1, colour.2].map(|part| (part * 255.0 + 0.5) as u8))?;
        }
        Ok(())
    })
}

/// Writes hits of photons as points with their directions.
///
/// # Errors
/// If the file cannot be written.
pub fn write_photons(path: &Path, hits: &[PhotonHit], comments: &[String]) -> anyhow::Result<()> {
    let floats = ["x", "y", "z", "dx", "dy", "dz", "weight_red", "weight_green", "weight_blue"];
    let mut properties: Vec<String> = floats.map(|name| format!("float {name}")).to_vec();
    properties.extend(["photon", "bounce", "triangle"].map(|name| format!("uint {name}")));
    write_file(path, |file| {
        write_header(file, comments, &[("vertex", hits.len(), properties)])?;
        for hit in hits {
            write_floats(file, &hit.position.to_array())?;
            write_floats(file, &hit.direction.to_array())?;
            write_floats(file, &hit.weight)?;
            // PLY has no numbers of 64 bits; the first hits are of far fewer photons.
            for number in [hit.photon as u32, hit.bounce, hit.triangle] {
                file.write_all(&number.to_le_bytes())?;
            }
        }
        Ok(())
    })
}

fn write_header(
    file: &mut dyn Write,
    comments: &[String],
    elements: &[(&str, usize, Vec<String>)],
) -> io::Result<()> {
    writeln!(file, "ply\nformat binary_little_endian 1.0")?;
    for comment in comments {
        // A comment ends with its line.
        writeln!(file, "comment {}", comment.replace(['\n', '\r'], " "))?;
    }
    for (name, count, properties) in elements {
        writeln!(file, "element {name} {count}")?;
        properties.iter().try_for_each(|property| writeln!(file, "property {property}"))?;
    }
    writeln!(file, "end_header")
}

fn write_floats(file: &mut dyn Write, values: &[f32]) -> io::Result<()> {
    values.iter().try_for_each(|value| file.write_all(&value.to_le_bytes()))
}
