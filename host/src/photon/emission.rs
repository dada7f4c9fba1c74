//! Emission of photons from area lights, with a cosine distribution.
//!
//! Each photon carries the same flux: the total flux divided by the number of photons. Three choices make a photon:
//!
//! 1. a light, with probability in proportion to its flux;
//! 2. a point, uniform in the light's parallelogram;
//! 3. a direction, with a cosine distribution.
//!
//! The first choice compares 32 random bits with integer thresholds that are computed once:
//!
//! ```text
//! 0 ........ flux 0 ........ flux 0+1 ........ total      in watts, f64
//! 0 ....... threshold 0 .... threshold 1 ..... 2^32       rounded down
//! ```
//!
//! Only `+ - * / sqrt` are used on `f64`, so the bits are the same on every target.

use arboleda::Vec3;

use super::hemisphere::cosine_direction;
use super::offset::{MARGIN, height, lifted};
use super::random::PhotonRandom;
use crate::scene::AreaLight;
use crate::vector::Vector64;

/// Photon at its emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Index of the light in the model's lights.
    pub light: u32,
    /// Origin of the photon, a point just in front of the light.
    pub origin: Vec3,
    /// Direction into the half-space in front of the light, of unit length up to rounding.
    pub direction: Vec3,
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
    /// Threshold of the choice: the light is chosen by 32 random bits below its threshold that are not below the
    /// previous light's threshold. The last threshold is 2^32.
    threshold: u64,
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

impl Emitter {
    /// Creates an emitter. Cost: linear in the lights.
    pub fn new(lights: &[AreaLight]) -> Self {
        let usable = || {
            (0_u32..).zip(lights).filter_map(|(light, area_light)| Source::new(light, area_light))
        };
        let flux_of = |source: &Source| f64::from(lights[source.light as usize].flux);
        let total_flux = usable().map(|source| flux_of(&source)).fold(0.0, |sum, flux| sum + flux);
        let mut sources: Vec<Source> = usable().collect();
        let mut reached = 0.0;
        for source in &mut sources {
            reached += flux_of(source);
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

    /// Returns the power of all lights that can emit, in watts.
    pub fn total_flux(&self) -> f64 {
        self.total_flux
    }

    /// Emits a photon; `None` if the emitter is dark.
    pub fn emit(&self, random: &mut PhotonRandom) -> Option<Emission> {
        let choice = u64::from(random.bits());
        let at = self.sources.partition_point(|source| source.threshold <= choice);
        let source = self.sources.get(at)?;

        // A coordinate along an edge is the middle of one of 2^24 equal parts, clamped away from the border.
        let mut part = |border: f64| {
            let part = f64::from(random.uniform()) + HALF_A_STEP;
            part.clamp(border, 1.0 - border)
        };
        let (u, v) = (part(source.border_u), part(source.border_v));
        let point = source.corner + source.edge_u * u + source.edge_v * v;
        Some(Emission {
            light: source.light,
            origin: lifted(point, source.normal, source.height),
            direction: cosine_direction(source.normal, random).rounded(),
        })
    }
}

const TWO_TO_32: f64 = 4_294_967_296.0;
/// Half of the step between two uniform draws: 2^-25.
const HALF_A_STEP: f64 = 0.5 / (1 << 24) as f64;

impl Source {
    /// Creates a source; `None` if the light cannot emit. The caller sets the threshold.
    fn new(light: u32, area_light: &AreaLight) -> Option<Self> {
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
        Some(Self {
            light,
            threshold: 0,
            corner,
            edge_u,
            edge_v,
            normal,
            height,
            border_u,
            border_v,
        })
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
}
