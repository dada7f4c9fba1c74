//! Emission of photons from lights, with a cosine distribution.
//!
//! Each photon carries the same flux: the total flux divided by the number of photons. Three choices make a photon:
//!
//! 1. a light, with probability in proportion to its flux, the mean of its colours;
//! 2. a point, uniform in the light's parallelogram or triangle;
//! 3. a direction, with a cosine distribution.
//!
//! The first choice compares 32 random bits with integer thresholds that are computed once:
//!
//! ```text
//! 0 ........ flux 0 ........ flux 0+1 ........ total      in watts, f64
//! 0 ....... threshold 0 .... threshold 1 ..... 2^32       rounded down
//! ```
//!
//! A triangle is geometry, which a parallelogram is not. A photon departs from it as after a hit, so it does not hit
//! the triangle that emitted it.
//!
//! Only `+ - * / sqrt` are used on `f64`, so the bits are the same on every target.

#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use arboleda::{Hit, Triangle, TriangleId, Vec3};

use crate::photon::random::PhotonRandom;
use crate::photon::surface::hemisphere::{Frame, cosine_direction, later_direction};
use crate::photon::surface::offset::{Departure, MARGIN, height, lifted};
use crate::scene::vector::Vector64;
use crate::scene::{AreaLight, FaceLight, LitSides, Model};

/// Photon at its emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Index of the light: the model's lights, then its emitting triangles.
    pub light: u32,
    /// Origin of the photon, a point just in front of the light.
    pub origin: Vec3,
    /// Direction into the half-space in front of the light, of unit length up to rounding.
    pub direction: Vec3,
    /// Factors of red, green and blue; their mean is 1.
    pub weight: [f32; 3],
}

/// Emitter of photons: the lights of a model that can emit.
///
/// Lights whose flux is not finite or not above 0, and lights without area, are omitted. They emit nothing, and
/// `total_flux` does not include them.
#[derive(Clone, Debug)]
pub struct Emitter {
    sources: Vec<Source>,
    total_flux: f64,
}

/// Light that can emit.
#[derive(Clone, Debug)]
struct Source {
    light: u32,
    /// Power in watts: the mean of the colours.
    flux: f64,
    weight: [f32; 3],
    /// Threshold of the choice: the light is chosen by 32 random bits below its threshold that are not below the
    /// previous light's threshold. The last threshold is 2^32.
    threshold: u64,
    shape: Shape,
}

/// Surface of a light.
#[derive(Clone, Debug)]
enum Shape {
    Parallelogram(Parallelogram),
    Face(Face),
}

impl Emitter {
    /// Creates an emitter of area lights. Cost: linear in the lights.
    pub fn new(lights: &[AreaLight]) -> Self {
        Self::of_sources(sources_of(lights).collect())
    }

    /// Creates an emitter of all lights of a model. Cost: linear in the lights.
    pub fn of(model: &Model) -> Self {
        let faces = (model.lights.len() as u32..).zip(&model.emitters).flat_map(|(light, face)| {
            let sides: &[f64] = if face.sides == LitSides::Both { &[1.0, -1.0] } else { &[1.0] };
            sides.iter().filter_map(move |&side| {
                let triangle = model.triangles.get(face.triangle as usize)?;
                Source::of_face(light, face, triangle, side)
            })
        });
        Self::of_sources(sources_of(&model.lights).chain(faces).collect())
    }

    fn of_sources(mut sources: Vec<Source>) -> Self {
        let total_flux = sources.iter().map(|source| source.flux).fold(0.0, |sum, flux| sum + flux);
        let mut reached = 0.0;
        for source in &mut sources {
            reached += source.flux;
            source.threshold = (reached / total_flux * TWO_TO_32) as u64;
        }
        // Both sums are formed in the same order, so the last quotient is 1 already. This line makes it certain.
        if let Some(last) = sources.last_mut() {
            last.threshold = 1 << 32;
        }
        Self { sources, total_flux }
    }

    /// Tells whether no light can emit.
    pub fn is_dark(&self) -> bool {
        self.sources.is_empty()
    }

    /// Returns the power of all lights that can emit, in watts. The power of a coloured light is the mean of its
    /// colours.
    pub fn total_flux(&self) -> f64 {
        self.total_flux
    }

    /// Emits a photon; `None` if the emitter is dark.
    pub fn emit(&self, random: &mut PhotonRandom) -> Option<Emission> {
        let source = self.sources.get(self.choose(random.bits()))?;
        let (origin, direction) = match &source.shape {
            Shape::Parallelogram(shape) => shape.emit(random),
            Shape::Face(shape) => shape.emit(random)?,
        };
        Some(Emission { light: source.light, origin, direction, weight: source.weight })
    }

    /// Chooses a source by 32 random bits.
    #[inline]
    pub(super) fn choose(&self, bits: u32) -> usize {
        match self.sources.len() {
            1 => 0,
            _ => self.sources.partition_point(|source| source.threshold <= u64::from(bits)),
        }
    }

    /// Returns the shape of a source; `None` if it is not a parallelogram.
    #[inline]
    pub(super) fn parallelogram(&self, source: usize) -> Option<&Parallelogram> {
        match self.sources.get(source).map(|source| &source.shape) {
            Some(Shape::Parallelogram(shape)) => Some(shape),
            _ => None,
        }
    }

    /// Returns the weight of a source's photons.
    #[inline]
    pub(super) fn weight(&self, source: usize) -> [f32; 3] {
        self.sources.get(source).map_or([1.0; 3], |source| source.weight)
    }
}

const TWO_TO_32: f64 = 4_294_967_296.0;
/// Half of the step between two uniform draws: 2^-25.
const HALF_A_STEP: f64 = 0.5 / (1 << 24) as f64;

/// Draws the middle of one of 2^24 equal parts of 0 to 1.
fn part(random: &mut PhotonRandom) -> f64 {
    f64::from(random.uniform()) + HALF_A_STEP
}

fn sources_of(lights: &[AreaLight]) -> impl Iterator<Item = Source> {
    (0_u32..).zip(lights).filter_map(|(light, area_light)| {
        let shape = Parallelogram::new(area_light)?;
        let flux = f64::from(area_light.flux);
        let weight = [1.0; 3];
        Some(Source { light, flux, weight, threshold: 0, shape: Shape::Parallelogram(shape) })
    })
}

impl Source {
    /// Creates the source of one side of a triangle: the front at `side` 1, the back at -1. `None` if it cannot emit.
    fn of_face(light: u32, face: &FaceLight, triangle: &Triangle, side: f64) -> Option<Self> {
        let radiance = face.radiance.map(f64::from);
        let sum = radiance[0] + radiance[1] + radiance[2];
        let sensible = radiance.iter().all(|&part| part >= 0.0) && sum > 0.0 && sum.is_finite();
        if !sensible || !triangle.is_finite() {
            return None;
        }
        let shape = Face::new(triangle, side)?;
        // A Lambertian surface of radiance L has the exitance pi L.
        let flux = PI * (sum / 3.0) * shape.area;
        let weight = radiance.map(|part| (3.0 * part / sum) as f32);
        // The largest triangles and radiances overflow f64 only together with the total.
        flux.is_finite().then_some(Self {
            light,
            flux,
            weight,
            threshold: 0,
            shape: Shape::Face(shape),
        })
    }
}

/// Emitting side of a triangle.
#[derive(Clone, Debug)]
struct Face {
    triangle: Triangle,
    area: f64,
    /// Direction from which a photon would come to depart from the emitting side.
    incoming: Vec3,
}

impl Face {
    /// Creates a face; `None` if photons cannot depart from it: it has no area, or its side is in doubt.
    fn new(triangle: &Triangle, side: f64) -> Option<Self> {
        let normal = Vector64::normal_of(triangle);
        let length = normal.length();
        if length <= 0.0 {
            return None;
        }
        let incoming = (normal * (-side / length)).rounded();
        let face = Self { triangle: *triangle, area: 0.5 * length, incoming };
        Departure::new(triangle, &Self::hit(0.25, 0.25), incoming).map(|_| face)
    }

    fn hit(u: f32, v: f32) -> Hit {
        Hit { triangle: TriangleId(0), t: 0.0, u, v }
    }

    /// Draws a point and a direction; `None` only for a triangle that [`Face::new`] refuses.
    ///
    /// # Source
    /// G. Turk, *Generating Random Points in Triangles*, Graphics Gems 1990.
    fn emit(&self, random: &mut PhotonRandom) -> Option<(Vec3, Vec3)> {
        let (root, share) = (part(random).sqrt(), part(random));
        let hit = Self::hit((root * (1.0 - share)) as f32, (root * share) as f32);
        let departure = Departure::new(&self.triangle, &hit, self.incoming)?;
        let normal = departure.unit_normal();
        let drawn = departure.ray(cosine_direction(normal, random).rounded());
        // On a sliver, a direction near its plane may be in doubt; the normal is not.
        let ray = drawn.or_else(|| departure.ray(normal.rounded()))?;
        Some((ray.origin(), ray.direction()))
    }
}

/// Emitting parallelogram.
#[derive(Clone, Debug)]
pub(super) struct Parallelogram {
    corner: Vector64,
    edge_u: Vector64,
    edge_v: Vector64,
    normal: Vector64,
    frame: Frame,
    /// Distance of the photons' origins from the plane of the light.
    height: f64,
    /// Distance of the photons' origins from the border, as a share of each edge; at most 0.5.
    border_u: f64,
    border_v: f64,
}

impl Parallelogram {
    /// Creates the shape of a light; `None` if the light cannot emit.
    fn new(area_light: &AreaLight) -> Option<Self> {
        let AreaLight { corner, edge_u, edge_v, flux } = *area_light;
        let emits = flux.is_finite() && flux > 0.0 && corner.is_finite();
        let [corner, edge_u, edge_v] = [corner, edge_u, edge_v].map(Vector64::from);
        let normal = edge_u.cross(edge_v);
        let length = normal.length();
        // The comparison is false for NaN too.
        if !(emits && length > 0.0 && length.is_finite()) {
            return None;
        }
        let corners = [corner, corner + edge_u, corner + edge_v, corner + edge_u + edge_v];
        let scale = corners.into_iter().map(Vector64::largest).fold(0.0, f64::max);
        let height = height(scale, scale);
        // The parallelogram is length / |edge_v| wide along u, so this share of edge_u is MARGIN heights from the
        // border.
        let border = |other: Vector64| (MARGIN * height * other.length() / length).min(0.5);
        let (border_u, border_v) = (border(edge_v), border(edge_u));
        let normal = normal / length;
        let frame = Frame::around(normal);
        Some(Self { corner, edge_u, edge_v, normal, frame, height, border_u, border_v })
    }

    /// Draws a point and a direction.
    fn emit(&self, random: &mut PhotonRandom) -> (Vec3, Vec3) {
        let (u, v) = (part(random), part(random));
        (self.origin(u, v), self.direction(random, 0))
    }

    /// Draws a direction, after `tried` points that lie outside the disc.
    pub(super) fn direction(&self, random: &mut PhotonRandom, tried: u32) -> Vec3 {
        later_direction(self.normal, random, tried).rounded()
    }

    /// Returns the frame around the normal.
    #[inline(always)]
    pub(super) fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Computes the origin of a photon at a point of the unit square, which is clamped away from the border.
    #[inline(always)]
    pub(super) fn origin(&self, u: f64, v: f64) -> Vec3 {
        let clamped = |part: f64, border: f64| {
            let part = if part < border { border } else { part };
            if part > 1.0 - border { 1.0 - border } else { part }
        };
        let (u, v) = (clamped(u, self.border_u), clamped(v, self.border_v));
        let point = self.corner + self.edge_u * u + self.edge_v * v;
        lifted(point, self.normal, self.height)
    }
}
