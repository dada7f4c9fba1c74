//! Model: a scene in memory, with lights and reflectances.
//!
//! ```text
//! triangles, objects, reflectances, ..: a column each   |   light (one above a model that has none)
//! census (vertices, degenerate triangles, duplicates), closed (has it an inside?)
//! ```

mod census;
pub mod closed;
mod column;
mod light;

use arboleda::{Aabb, Scene, Triangle, Vec3};
use blake3::Hasher;
use bytemuck::Pod;

pub use census::Census;
pub use column::Column;
pub(in crate::scene) use light::DEFAULT_FLUX;
pub use light::UpAxis;

/// Triangles with their objects, reflectances and lights.
///
/// # Invariants
/// - `objects` and `reflectance` have one entry for each triangle, and so has `colours` unless it is empty.
/// - `reflectance` is the mean of the triangle's colour as the file has it, clamped to 0 to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Name for headings: that of the built-in scene or of the file.
    pub name: String,
    /// All triangles. The id of a triangle is its index in this list.
    pub triangles: Column<Triangle>,
    /// Object of each triangle, an index into `object_names`.
    pub objects: Column<u32>,
    /// Names of objects and groups.
    pub object_names: Vec<String>,
    /// Share of light that each triangle reflects diffusely, 0 to 1.
    pub reflectance: Column<f32>,
    /// Share of red, green and blue that each triangle reflects, 0 to 1. Empty if every surface is grey; then each
    /// share is the triangle's reflectance.
    pub colours: Column<[f32; 3]>,
    /// Light sources of the photons that are not triangles.
    pub lights: Vec<AreaLight>,
    /// Triangles that emit light. They also reflect, and block light.
    pub emitters: Vec<FaceLight>,
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

/// Triangle that emits light, with a cosine distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceLight {
    /// Id of the triangle.
    pub triangle: u32,
    /// Radiance of red, green and blue, in W/(m2 sr).
    pub radiance: [f32; 3],
    /// Sides that emit.
    pub sides: LitSides,
}

/// Sides on which a triangle emits light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LitSides {
    /// The side from which the corners are seen counter-clockwise.
    #[default]
    Front,
    /// Both sides, each with the same radiance.
    Both,
}

/// Hashes values of 32-bit words, each little-endian, on all threads of the caller's pool.
fn add_words<T: Pod>(hasher: &mut Hasher, values: &[T]) {
    /// Words that are converted at once.
    const SOME: usize = 1 << 16;
    if cfg!(target_endian = "little") {
        hasher.update_rayon(bytemuck::cast_slice(values));
        return;
    }
    for words in bytemuck::cast_slice::<T, u32>(values).chunks(SOME) {
        let words: Vec<u32> = words.iter().map(|word| word.to_le()).collect();
        hasher.update(bytemuck::cast_slice(&words));
    }
}

impl Model {
    /// Hashes what photons depend on: triangles, reflectances, colours and lights.
    pub(crate) fn digest(&self) -> blake3::Hash {
        let mut hasher = Hasher::new();
        add_words(&mut hasher, &self.triangles);
        add_words(&mut hasher, &self.reflectance);
        add_words(&mut hasher, &self.colours);
        let mut add = |values: &[f32]| add_words(&mut hasher, values);
        for light in &self.lights {
            for vector in [light.corner, light.edge_u, light.edge_v] {
                add(&vector.to_array());
            }
            add(&[light.flux]);
        }
        for light in &self.emitters {
            add(&light.radiance);
            add(&[
                f32::from_bits(light.triangle),
                if light.sides == LitSides::Both { 1.0 } else { 0.0 },
            ]);
        }
        hasher.finalize()
    }

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
        self.triangles.to_mut().extend(triangles);
        self.objects.to_mut().resize(self.triangles.len(), object);
        self.reflectance.to_mut().resize(self.triangles.len(), reflectance);
        if !self.colours.is_empty() {
            self.colours.to_mut().resize(self.triangles.len(), [reflectance; 3]);
        }
    }

    /// Appends all triangles, objects and lights of another model, whose ids and numbers follow those of this one. The
    /// other's name and origin are dropped.
    pub fn append(&mut self, other: Self) {
        let (triangle, object) = (self.triangles.len() as u32, self.object_names.len() as u32);
        let grey = |shares: &[f32]| shares.iter().map(|&share| [share; 3]).collect::<Column<_>>();
        if !(self.colours.is_empty() && other.colours.is_empty()) {
            if self.colours.is_empty() {
                self.colours = grey(&self.reflectance);
            }
            let is_grey = other.colours.is_empty();
            let colours = if is_grey { grey(&other.reflectance) } else { other.colours };
            self.colours.to_mut().extend_from_slice(&colours);
        }
        self.triangles.to_mut().extend_from_slice(&other.triangles);
        self.objects.to_mut().extend(other.objects.iter().map(|number| object + number));
        self.object_names.extend(other.object_names);
        self.reflectance.to_mut().extend_from_slice(&other.reflectance);
        self.lights.extend(other.lights);
        let emitters = other.emitters.into_iter();
        self.emitters.extend(
            emitters.map(|light| FaceLight { triangle: triangle + light.triangle, ..light }),
        );
    }

    /// Returns the shares of red, green and blue that a triangle reflects; 0 if no triangle has this id.
    pub fn colour(&self, id: u32) -> [f32; 3] {
        let grey = || self.reflectance.get(id as usize).map_or([0.0; 3], |&share| [share; 3]);
        self.colours.get(id as usize).copied().unwrap_or_else(grey)
    }

    /// Tells whether all photons stay as white as their lights: every surface and every emitter is grey.
    pub fn is_grey(&self) -> bool {
        let grey = |light: &FaceLight| light.radiance == [light.radiance[0]; 3];
        self.colours.is_empty() && self.emitters.iter().all(grey)
    }

    /// Lets every emitting triangle emit on both sides.
    #[must_use]
    pub fn with_two_sided_lights(mut self) -> Self {
        for light in &mut self.emitters {
            light.sides = LitSides::Both;
        }
        self
    }

    /// Replaces all lights, also the emitting triangles.
    pub fn replace_lights(&mut self, lights: Vec<AreaLight>) {
        self.lights = lights;
        self.emitters.clear();
    }

    /// Computes the bounding box of all triangles.
    pub fn bounds(&self) -> Aabb {
        self.triangles.iter().fold(Aabb::EMPTY, |all, triangle| all.union(triangle.bounds()))
    }
}
