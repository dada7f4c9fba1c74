//! Model: a scene in memory, with lights and reflectances.

use arboleda::{Aabb, Scene, Triangle, Vec3};

/// Triangles with their objects, reflectances and lights.
///
/// # Invariants
/// `objects` and `reflectance` have one entry for each triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Name for headings: that of the built-in scene or of the file.
    pub name: String,
    /// All triangles. The id of a triangle is its index in this list.
    pub triangles: Vec<Triangle>,
    /// Object of each triangle, an index into `object_names`.
    pub objects: Vec<u32>,
    /// Names of objects and groups.
    pub object_names: Vec<String>,
    /// Share of light that each triangle reflects diffusely, 0 to 1.
    pub reflectance: Vec<f32>,
    /// Light sources of the photons.
    pub lights: Vec<AreaLight>,
    /// Point that was subtracted from the file's coordinates. A position plus `origin` is in the file's coordinates.
    pub origin: [f64; 3],
}

/// Parallelogram that emits light on the side of `edge_u x edge_v`, with a cosine distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// One corner.
    pub corner: Vec3,
    /// Edge from the corner along one side.
    pub edge_u: Vec3,
    /// Edge from the corner along the other side.
    pub edge_v: Vec3,
    /// Emitted power in watts.
    pub flux: f32,
}

impl Model {
    /// Makes the scene for index builds. Clusters are found among triangles.
    pub fn scene(&self) -> Scene<'_> {
        Scene::new(&self.triangles)
    }

    /// Makes the scene for index builds. Clusters are found among whole objects.
    pub fn scene_of_objects(&self) -> Scene<'_> {
        Scene::with_objects(&self.triangles, &self.objects)
    }

    /// Creates a model without triangles.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// Appends an object whose triangles have the same reflectance.
    pub fn add_object(
        &mut self,
        name: impl Into<String>,
        triangles: impl IntoIterator<Item = Triangle>,
        reflectance: f32,
    ) {
        let object = self.object_names.len() as u32;
        self.object_names.push(name.into());
        self.triangles.extend(triangles);
        self.objects.resize(self.triangles.len(), object);
        self.reflectance.resize(self.triangles.len(), reflectance);
    }

    /// Computes the bounding box of all triangles.
    pub fn bounds(&self) -> Aabb {
        self.triangles.iter().fold(Aabb::EMPTY, |all, triangle| all.union(triangle.bounds()))
    }
}
