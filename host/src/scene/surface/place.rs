//! Conversion of a surface to a model.

use arboleda::{Triangle, Vec3};

use super::Material;
use super::origin::{Origin, Written};
use super::polygon::{Divider, PolygonDivision};
use super::rounding::RoundingLoss;
use super::{Surface, precision};
use crate::scene::vector::Vector64;
use crate::scene::{FaceLight, LitSides, Model, SceneError};

/// Model of a scene file, with warnings about contents that the model lacks.
#[derive(Clone, Debug)]
pub struct Import {
    /// Model with the emitting triangles of the file, and without other lights.
    pub model: Model,
    /// Warnings, one line each: ignored elements, omitted faces, missing material files, coordinates that lose digits.
    pub warnings: Vec<String>,
}

impl Surface {
    /// Converts the surface to a model: subtracts the origin in `f64`, rounds to `f32`, and divides the polygons in the
    /// order of the faces. Faces with a vertex that is not finite are omitted.
    ///
    /// # Errors
    /// [`SceneError::NoFiniteFaces`] if all faces are omitted.
    pub fn place(self, origin: Origin) -> Result<Import, SceneError> {
        let point = origin.point(|| self.extent());
        self.place_at(point, None)
    }

    /// Converts one of several files of a scene, as [`place`](Self::place) does, with the origin of the scene. What is
    /// lost by rounding is gathered, to be judged for the whole scene.
    ///
    /// # Errors
    /// [`SceneError::NoFiniteFaces`] if all faces of the file are omitted.
    pub(in crate::scene) fn place_part(
        self,
        origin: [f64; 3],
        loss: &mut RoundingLoss,
    ) -> Result<Import, SceneError> {
        self.place_at(origin, Some(loss))
    }

    fn place_at(
        mut self,
        origin: [f64; 3],
        loss: Option<&mut RoundingLoss>,
    ) -> Result<Import, SceneError> {
        let title = self.file.file_stem().unwrap_or(self.file.as_os_str()).to_string_lossy();
        let mut model = Model::named(title);
        model.object_names = std::mem::take(&mut self.object_names);
        model.origin = origin;

        // 1. Vertices.
        let vertices: Vec<Vec3> = self
            .positions
            .iter()
            .map(|position| round([0, 1, 2].map(|axis| position[axis] - model.origin[axis])))
            .collect();

        // 2. Faces, in order, with the object and material of their part.
        let (mut not_finite, mut crossing, mut dark) = (0, 0, 0);
        let mut first_not_finite = None;
        let mut divider = Divider::default();
        let mut corners = Vec::new();
        let mut parts = self.parts.iter().peekable();
        let (mut object, mut material) = (0, Material::DEFAULT);
        let coloured = !self.parts.iter().all(|part| part.material.is_grey());
        model.triangles.to_mut().reserve(self.corners.len() - 2 * self.arities.len());
        for (number, face) in self.faces().enumerate() {
            while let Some(part) = parts.next_if(|part| part.first_face <= number) {
                (object, material) = (part.object, part.material);
            }
            corners.clear();
            corners.extend(face.iter().map(|&corner| vertices[corner as usize]));
            if let Some(at) = corners.iter().position(|corner| !corner.is_finite()) {
                not_finite += 1;
                first_not_finite.get_or_insert((number, self.positions[face[at] as usize]));
                continue;
            }
            let (triangles, division) = divider.divide(&corners);
            crossing += usize::from(division == PolygonDivision::Crossing);
            for ids in triangles {
                let [a, b, c] = ids.map(|id| corners[id]);
                let triangle = Triangle::new(a, b, c);
                // A triangle without area emits nothing.
                let is_lamp = material.emits();
                dark += u32::from(is_lamp && !has_area(&triangle));
                if is_lamp && has_area(&triangle) {
                    let id = model.triangles.len() as u32;
                    let radiance = material.radiance;
                    model.emitters.push(FaceLight {
                        triangle: id,
                        radiance,
                        sides: LitSides::Front,
                    });
                }
                model.triangles.to_mut().push(triangle);
            }
            model.objects.to_mut().resize(model.triangles.len(), object);
            model.reflectance.to_mut().resize(model.triangles.len(), material.reflectance);
            if coloured {
                model.colours.to_mut().resize(model.triangles.len(), material.colour);
            }
        }

        // 3. Warnings.
        if let Some((face, vertex)) = first_not_finite {
            if model.triangles.is_empty() {
                return Err(SceneError::NoFiniteFaces { file: self.file, faces: not_finite });
            }
            let first = Written(vertex);
            self.warn(format_args!(
                "{not_finite} faces omitted because they have a vertex that is not finite as a 32-bit number; \
                 the first is face {}, with vertex {first}",
                face + 1
            ));
        }
        if crossing > 0 {
            self.warn(format_args!(
                "{crossing} polygons cross themselves; each was divided into a fan from its first corner"
            ));
        }
        if dark > 0 {
            self.warn(format_args!("{dark} triangles of lamps have no area, and emit nothing"));
        }
        if let Some(loss) = loss {
            loss.add(&self, model.origin);
        } else if let Some(warning) = precision::warning(&self, model.origin) {
            self.warn(warning);
        }
        Ok(Import { model, warnings: self.warnings })
    }
}

fn has_area(triangle: &Triangle) -> bool {
    Vector64::normal_of(triangle).length() > 0.0
}

/// Rounds each coordinate to the nearest `f32`. Coordinates beyond the largest `f32` become infinite.
fn round(point: [f64; 3]) -> Vec3 {
    Vec3::from_array(point.map(|x| x as f32))
}
