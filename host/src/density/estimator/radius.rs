//! Radius and number of photons of an estimate, chosen from a few photons.
//!
//! A disc that holds `n` photons has a relative deviation of `1 / sqrt(n)`, and a blur in proportion to `r^2`. With the
//! number of photons `N` the best radius falls as `N^(-1/6)`, so `n` grows as `N^(2/3)`: more photons give both less
//! noise and less blur.
//!
//! # Source
//! Silverman 1986, section 4.3, for the exponents.

use std::f64::consts::PI;

use crate::density::source::PhotonSource;
use crate::photon::{Balance, Segment, Visitor};
use crate::scene::vector::area_of;

/// Photons of the trial: enough to know the lit area to a few percent.
const TRIAL: u64 = 16_384;
/// Photons in an estimate if a million are shot: a deviation of 7%.
const WANTED_OF_A_MILLION: f64 = 200.0;
/// Radius over the scene's bounding sphere where no photon hits: a twentieth, as in Mitsuba's photon maps.
const SHARE_OF_BOUNDS: f64 = 0.05;

/// Computes how many photons an estimate should have: `200 (N / 10^6)^(2/3)`, at least 16.
pub fn wanted_photons(photons: u64) -> usize {
    let root = libm::cbrt(photons as f64 / 1e6);
    (WANTED_OF_A_MILLION * root * root).max(16.0) as usize
}

/// Estimates the radius of a disc that holds `wanted` photons, on average over the triangles that photons hit. `wanted`
/// may be a fraction. If no photon hits, a twentieth of the radius of the scene's bounding sphere.
pub fn automatic_radius(source: &PhotonSource<'_>, wanted: f64) -> f32 {
    let first = source.photons.start;
    let trial = PhotonSource {
        photons: first..source.photons.end.min(first.saturating_add(TRIAL)),
        ..source.clone()
    };
    // A list, because a table of all triangles may be far larger than the memory of the rest.
    let mut hit_ids = Vec::new();
    let Balance { emitted, .. } = trial.stream(&|_| {}, &HitTriangles { source: &trial }, |ids| {
        hit_ids.extend(ids);
    });
    let hits = hit_ids.len();
    // The area is summed in the order of ids.
    hit_ids.sort_unstable();
    hit_ids.dedup();
    let triangles = source.model.triangles.as_slice();
    let lit = hit_ids.iter().filter_map(|&id| triangles.get(id as usize));
    let area = lit.fold(0.0, |sum, triangle| sum + area_of(triangle));
    let radius = if hits == 0 || area <= 0.0 {
        0.5 * SHARE_OF_BOUNDS * source.model.bounds().diagonal_squared().sqrt()
    } else {
        let photons = (source.photons.end - first) as f64;
        let density = hits as f64 * (photons / emitted as f64) / area;
        (wanted / (PI * density)).sqrt()
    };
    (radius as f32).clamp(f32::MIN_POSITIVE, f32::MAX)
}

/// Collects the triangles that photons hit.
struct HitTriangles<'s> {
    source: &'s PhotonSource<'s>,
}

impl Visitor for HitTriangles<'_> {
    type State = Vec<u32>;

    fn begin(&self) -> Vec<u32> {
        Vec::new()
    }

    fn visit(&self, ids: &mut Vec<u32>, segment: &Segment) {
        ids.extend(self.source.counted_hit(segment).map(|(_, hit)| hit.triangle.0));
    }
}
