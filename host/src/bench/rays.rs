//! Rays to replay: found once, asked of every index.
//!
//! Emission and bouncing cost as much as a fast query and are the same for all, so benches do them
//! beforehand. A photon's path does not depend on the index, and neither do its rays.

use std::ops::Range;

use anyhow::{Context, ensure};
use arboleda::{Hit, IndexKind, Options, Ray};

use crate::OwnedIndex;
use crate::photon::{DEFAULT_MAX_BOUNCES, Tracer};
use crate::scene::Model;

/// The index that finds the rays, and the hits that others are compared with.
const GUIDE: IndexKind = IndexKind::WideBvh;

/// Photons whose rays indices are built and selected by.
pub const SAMPLE_PHOTONS: u64 = 512;

/// The rays of some photons in order, and what each hits.
///
/// Invariants: `hits` has one entry for each ray; `ends` ascends, and its last entry is the number of
/// rays.
pub struct RaySet {
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// How many rays the photons up to and with this one have.
    ends: Vec<usize>,
    seed: u64,
}

impl RaySet {
    /// Follows photons with the help of a bounding volume hierarchy.
    ///
    /// # Errors
    /// If the model cannot be indexed, or nothing in it emits.
    pub fn shoot(model: &Model, photons: u64, seed: u64) -> anyhow::Result<Self> {
        let owned = OwnedIndex::build(GUIDE, &model.scene(), &Options::default())
            .with_context(|| format!("cannot build an index of {}", model.name))?;
        let index = owned.index();
        let index = index.as_ray_index();
        let tracer = Tracer::new(model, seed, DEFAULT_MAX_BOUNCES);
        let (mut rays, mut ends) = (Vec::new(), Vec::new());
        for photon in 0..photons {
            tracer.rays(index, photon..photon + 1, |ray| rays.push(*ray));
            ends.push(rays.len());
        }
        ensure!(!rays.is_empty(), "nothing in {} emits photons", model.name);
        let hits = rays.iter().map(|ray| index.closest_hit(ray)).collect();
        Ok(Self { rays, hits, ends, seed })
    }

    /// How many photons there are.
    pub fn photon_count(&self) -> u64 {
        self.ends.len() as u64
    }

    /// What the photons were drawn with.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Those to build and select indices by.
    pub fn sample(&self) -> &[Ray] {
        self.of_first(SAMPLE_PHOTONS)
    }

    /// The rays of the first photons.
    pub fn of_first(&self, photons: u64) -> &[Ray] {
        &self.rays[self.range(photons)]
    }

    /// What these rays hit.
    pub fn hits_of_first(&self, photons: u64) -> &[Option<Hit>] {
        &self.hits[self.range(photons)]
    }

    fn range(&self, photons: u64) -> Range<usize> {
        let photons = photons.min(self.photon_count()) as usize;
        0..photons.checked_sub(1).map_or(0, |last| self.ends[last])
    }
}

/// Whether two answers are the same bit for bit; `==` would take -0.0 for 0.0.
pub fn same_bits(a: Option<Hit>, b: Option<Hit>) -> bool {
    a.map(bits) == b.map(bits)
}

/// A hit as four words.
pub fn bits(hit: Hit) -> [u32; 4] {
    [hit.triangle.0, hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::paper::fig2;

    #[test]
    fn prefixes_are_whole_photons() {
        let model = fig2();
        let (few, many) = (RaySet::shoot(&model, 20, 1), RaySet::shoot(&model, 50, 1));
        let (few, many) = (few.unwrap(), many.unwrap());
        assert_eq!(few.rays, many.of_first(20));
        assert_eq!(many.of_first(0), []);
        assert_eq!(many.of_first(9_999).len(), many.rays.len());
        assert_eq!(many.hits_of_first(50).len(), many.rays.len());
    }

    #[test]
    fn a_model_without_light_is_an_error() {
        let dark = Model { lights: Vec::new(), ..fig2() };
        assert!(RaySet::shoot(&dark, 10, 1).is_err());
    }
}
