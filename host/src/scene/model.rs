//! A scene in memory.

use arboleda::{Aabb, Scene, Triangle, Vec3};

/// Triangles with what light needs to know of them.
///
/// `objects` and `reflectance` have one entry per triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// For headings: the built-in scene's name or the file's.
    pub name: String,
    /// All triangles; ids count from 0 in this order.
    pub triangles: Vec<Triangle>,
    /// Which object each triangle belongs to, an index into `object_names`.
    pub objects: Vec<u32>,
    /// The names of objects and groups.
    pub object_names: Vec<String>,
    /// The share of light that each triangle reflects, diffusely, 0 to 1.
    pub reflectance: Vec<f32>,
    /// Where the photons come from.
    pub lights: Vec<AreaLight>,
    /// The point that was subtracted from the file's coordinates. Add it to a position to get the file's.
    pub origin: [f64; 3],
}

/// A parallelogram that emits light on the side of `edge_u x edge_v`, with a cosine distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// One corner.
    pub corner: Vec3,
    /// From the corner along one side.
    pub edge_u: Vec3,
    /// From the corner along the other side.
    pub edge_v: Vec3,
    /// The power that it emits, in watts.
    pub flux: f32,
}

impl Model {
    /// What the core builds indices from; clusters are found among triangles.
    pub fn scene(&self) -> Scene<'_> {
        Scene::new(&self.triangles)
    }

    /// As `scene`, but clusters are found among whole objects.
    pub fn scene_of_objects(&self) -> Scene<'_> {
        Scene::with_objects(&self.triangles, &self.objects)
    }

    /// A model without triangles yet.
    pub fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// Appends an object whose triangles all reflect alike.
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

    /// The smallest box around all triangles.
    pub fn bounds(&self) -> Aabb {
        self.triangles.iter().fold(Aabb::EMPTY, |all, triangle| all.union(triangle.bounds()))
    }
}
