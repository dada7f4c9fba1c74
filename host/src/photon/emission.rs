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
//! A triangle is geometry, which a parallelogram is not. A photon departs from it as after a hit, so it does not hit the
//! triangle that emitted it.
//!
//! Only `+ - * / sqrt` are used on `f64`, so the bits are the same on every target.

use std::f64::consts::PI;

use arboleda::{Hit, Triangle, TriangleId, Vec3};

use super::hemisphere::cosine_direction;
use super::offset::{Departure, MARGIN, height, lifted};
use super::random::PhotonRandom;
use crate::scene::{AreaLight, FaceLight, LitSides, Model};
use crate::vector::Vector64;

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
        let choice = u64::from(random.bits());
        let at = self.sources.partition_point(|source| source.threshold <= choice);
        let source = self.sources.get(at)?;
        let (origin, direction) = match &source.shape {
            Shape::Parallelogram(shape) => shape.emit(random),
            Shape::Face(shape) => shape.emit(random)?,
        };
        Some(Emission { light: source.light, origin, direction, weight: source.weight })
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
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(Vector64::from);
        let normal = (b - a).cross(c - a);
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
struct Parallelogram {
    corner: Vector64,
    edge_u: Vector64,
    edge_v: Vector64,
    normal: Vector64,
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
        Some(Self { corner, edge_u, edge_v, normal, height, border_u, border_v })
    }

    /// Draws a point and a direction.
    fn emit(&self, random: &mut PhotonRandom) -> (Vec3, Vec3) {
        // A coordinate along an edge is clamped away from the border.
        let mut part = |border: f64| part(random).clamp(border, 1.0 - border);
        let (u, v) = (part(self.border_u), part(self.border_v));
        let point = self.corner + self.edge_u * u + self.edge_v * v;
        let origin = lifted(point, self.normal, self.height);
        (origin, cosine_direction(self.normal, random).rounded())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(corner: Vec3, edge_u: Vec3, edge_v: Vec3, flux: f32) -> AreaLight {
        AreaLight { corner, edge_u, edge_v, flux }
    }

    #[test]
    fn lights_are_chosen_in_proportion_to_their_flux() {
        let at = |x: f32, flux| light(Vec3::new(x, 0.0, 0.0), Vec3::X, Vec3::Y, flux);
        let dark = [at(1.0, 0.0), at(1.0, -1.0), at(1.0, f32::NAN), at(f32::NAN, 1.0)];
        let flat = light(Vec3::ZERO, Vec3::X, Vec3::X, 5.0);
        let lights =
            [dark[0], at(0.0, 1.0), dark[1], dark[2], at(2.0, 6.0), flat, dark[3], at(4.0, 3.0)];
        let emitter = Emitter::new(&lights);
        assert_eq!(emitter.total_flux(), 10.0);
        let count = 100_000;
        let mut counts = [0_u32; 8];
        for photon in 0..count {
            let emission = emitter.emit(&mut PhotonRandom::new(1, photon)).unwrap();
            counts[emission.light as usize] += 1;
        }
        for (light, share) in [(1, 0.1), (4, 0.6), (7, 0.3)] {
            let sigma = (count as f64 * share * (1.0 - share)).sqrt();
            assert!((f64::from(counts[light]) - count as f64 * share).abs() < 4.0 * sigma);
        }
        assert_eq!(u64::from(counts[1] + counts[4] + counts[7]), count);
    }

    #[test]
    fn photons_begin_inside_the_parallelogram_and_in_front_of_it() {
        for scale in [1e-30_f32, 1e-3, 1.0, 1e6, 1e30] {
            let corner = Vec3::new(3.0, -1.0, 0.5) * scale;
            let (edge_u, edge_v) =
                (Vec3::new(1.0, 2.0, 0.1) * scale, Vec3::new(-0.5, 1.0, 3.0) * scale);
            let emitter = Emitter::new(&[light(corner, edge_u, edge_v, 1.0)]);
            let [exact_u, exact_v] = [edge_u, edge_v].map(Vector64::from);
            let normal = exact_u.cross(exact_v);
            let mut cosines = 0.0;
            let count = 20_000_u32;
            for photon in 0..count {
                let emission = emitter.emit(&mut PhotonRandom::new(2, u64::from(photon))).unwrap();
                let from_corner = Vector64::from(emission.origin) - Vector64::from(corner);
                let square = normal.dot(normal);
                let u = from_corner.cross(exact_v).dot(normal) / square;
                let v = exact_u.cross(from_corner).dot(normal) / square;
                assert!((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v), "{u} {v}");
                assert!(from_corner.dot(normal) > 0.0);
                cosines += Vector64::from(emission.direction).dot(normal) / square.sqrt();
            }
            let sigma = (1.0 / 18.0 / f64::from(count)).sqrt();
            assert!((cosines / f64::from(count) - 2.0 / 3.0).abs() < 4.0 * sigma);
        }
    }

    #[test]
    fn without_a_light_nothing_is_emitted() {
        let emitter = Emitter::new(&[]);
        assert!(emitter.is_dark());
        assert_eq!(emitter.emit(&mut PhotonRandom::new(0, 0)), None);
    }

    #[test]
    fn emitting_triangles_have_the_flux_of_their_radiance_on_each_side() {
        let mut model = Model::default();
        let square = crate::photon::fixtures::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        model.add_object("square", square, 0.5);
        model.add_object("no area", [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::X)], 0.5);
        let face = |triangle, radiance| FaceLight { triangle, radiance, sides: LitSides::Front };
        let white = [1.0; 3];
        model.emitters = vec![face(0, white), face(1, white), face(2, white), face(9, white)];
        model.emitters.extend([
            face(0, [f32::NAN, 1.0, 1.0]),
            face(0, [-1.0, 1.0, 1.0]),
            face(0, [0.0; 3]),
        ]);
        let emitter = Emitter::of(&model);
        assert!((emitter.total_flux() - PI).abs() < 1e-12);
        let both = Emitter::of(&model.clone().with_two_sided_lights());
        assert!((both.total_flux() - 2.0 * PI).abs() < 1e-12);
        let (mut sum, mut up, count) = (Vector64::ZERO, 0, 20_000_u32);
        for photon in 0..count {
            let photon = u64::from(photon);
            let emission = emitter.emit(&mut PhotonRandom::new(3, photon)).unwrap();
            assert!(emission.origin.z > 0.0 && emission.direction.z > 0.0);
            assert_eq!(emission.weight, [1.0; 3]);
            sum = sum + emission.origin.into();
            let either = both.emit(&mut PhotonRandom::new(3, photon)).unwrap();
            assert!(either.origin.z * either.direction.z > 0.0);
            up += u32::from(either.direction.z > 0.0);
        }
        // A coordinate uniform in 0 to 1 has variance 1/12.
        let sigma = (f64::from(count) / 12.0).sqrt();
        let middle = 0.5 * f64::from(count);
        assert!((sum.x - middle).abs() < 4.0 * sigma && (sum.y - middle).abs() < 4.0 * sigma);
        assert!((f64::from(up) - middle).abs() < 4.0 * 0.5 * f64::from(count).sqrt());
    }

    #[test]
    fn points_are_uniform_in_a_triangle() {
        let mut model = Model::default();
        model.add_object("one", [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)], 0.5);
        let radiance = [17.0, 12.0, 4.0];
        model.emitters.push(FaceLight { triangle: 0, radiance, sides: LitSides::Front });
        let emitter = Emitter::of(&model);
        assert!((emitter.total_flux() - 5.5 * PI).abs() < 1e-12);
        // Of the four similar triangles of half the size, each gets a quarter.
        let (mut counts, count) = ([0_u32; 4], 20_000);
        for photon in 0..count {
            let emission = emitter.emit(&mut PhotonRandom::new(4, photon)).unwrap();
            let Vec3 { x, y, .. } = emission.origin;
            let part = if x > 0.5 {
                0
            } else if y > 0.5 {
                1
            } else {
                2 + usize::from(x + y > 0.5)
            };
            counts[part] += 1;
            let mean = emission.weight.iter().sum::<f32>() / 3.0;
            assert!((mean - 1.0).abs() < 1e-6 && emission.weight[0] > 1.5);
        }
        let sigma = (count as f64 * 0.25 * 0.75).sqrt();
        for part in counts {
            assert!((f64::from(part) - count as f64 / 4.0).abs() < 4.0 * sigma, "{counts:?}");
        }
    }
}
