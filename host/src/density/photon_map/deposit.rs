//! Deposit of photons: the hits of a source, in the order of (photon, bounce).

use serde::{Deserialize, Serialize};

use crate::density::PhotonSource;
use crate::density::receiver::hit_point;
use crate::photon::{Balance, Segment, Side, Visitor};
use crate::scene::Model;

use super::{MOST_PHOTONS, MapError, Normals, Photon, PhotonMap, TOP, build, tint};

/// Hit of a photon, before it has a rank.
struct Deposit {
    number: u64,
    photon: Photon,
    weight: [f32; 3],
}

/// Collects the hits of each chunk.
struct Collector<'m> {
    source: &'m PhotonSource<'m>,
}

impl Visitor for Collector<'_> {
    type State = Vec<Deposit>;

    /// A chunk has some 2,000 hits of 40 bytes: 20 MB.
    fn chunks_at_once(&self) -> u64 {
        256
    }

    fn begin(&self) -> Vec<Deposit> {
        Vec::new()
    }

    fn visit(&self, deposits: &mut Vec<Deposit>, segment: &Segment) {
        if let Some((triangle, hit)) = self.source.counted_hit(segment) {
            let side = Side::hit(triangle, &segment.ray, &hit);
            let photon = Photon::new(hit_point(triangle, &hit), hit.triangle.0, side);
            deposits.push(Deposit { number: segment.photon, photon, weight: segment.weight });
        }
    }

    fn finish(&self, deposits: &mut Vec<Deposit>) {
        // Waves come in the order of bounces, so a stable sort by photon gives (photon, bounce).
        deposits.sort_by_key(|deposit| deposit.number);
    }
}

/// Hits of a range of photons, in the order of (photon, bounce), as they go into a photon map. A hit takes 16 bytes, 28
/// in a model of colours.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Deposits {
    positions: Vec<[f32; 3]>,
    /// Twice the triangle's id, plus 1 for its back.
    surfaces: Vec<u32>,
    /// Weights of red, green and blue; empty in a grey model.
    weights: Vec<[f32; 3]>,
}

impl Deposits {
    /// Shoots the photons of a source and keeps their hits, in the caller's pool.
    ///
    /// # Errors
    /// [`MapError::TooManyHits`], before more hits than a map holds are kept.
    pub fn shoot(
        source: &PhotonSource<'_>,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<(Self, Balance), MapError> {
        let (grey, mut all) = (source.model.is_grey(), Self::default());
        let balance = each_hit(source, progress, |deposit| {
            all.positions.push(deposit.photon.position);
            all.surfaces.push(deposit.photon.surface);
            if !grey {
                all.weights.push(deposit.weight);
            }
        })?;
        Ok((all, balance))
    }

    /// Appends the hits of the photons that follow.
    pub fn join(&mut self, next: Self) {
        self.positions.extend(next.positions);
        self.surfaces.extend(next.surfaces);
        self.weights.extend(next.weights);
    }

    /// Returns the number of hits.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Tells whether there are no hits.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Tells whether these may be hits of a model of `triangles` triangles.
    pub fn are_of(&self, triangles: u64) -> bool {
        let finite = |numbers: &[f32; 3]| numbers.iter().all(|number| number.is_finite());
        self.surfaces.len() == self.len()
            && (self.weights.is_empty() || self.weights.len() == self.len())
            && self.surfaces.iter().all(|&surface| u64::from(surface / 2) < triangles)
            && self.positions.iter().chain(&self.weights).all(finite)
    }
}

/// Shoots the photons of a source and hands on their hits, in the order of (photon, bounce).
fn each_hit(
    source: &PhotonSource<'_>,
    progress: &(impl Fn(u64) + Sync),
    mut take: impl FnMut(Deposit),
) -> Result<Balance, MapError> {
    let mut hits = 0;
    let balance = source.stream(progress, &Collector { source }, |deposits| {
        hits += deposits.len();
        if hits <= MOST_PHOTONS {
            deposits.into_iter().for_each(&mut take);
        }
    });
    if hits > MOST_PHOTONS { Err(MapError::TooManyHits { hits }) } else { Ok(balance) }
}

/// Hits on their way into a map. They get their ranks.
struct RankedHits {
    grey: bool,
    photons: Vec<Photon>,
    tints: Vec<u32>,
}

impl RankedHits {
    fn of(model: &Model) -> Self {
        Self { grey: model.is_grey(), photons: Vec::new(), tints: Vec::new() }
    }

    fn push(&mut self, photon: Photon, weight: [f32; 3]) {
        let rank = self.photons.len() as u32;
        self.photons.push(Photon { rank, ..photon });
        if !self.grey {
            self.tints.push(tint::encoded(weight, rank));
        }
    }

    fn into_map(self, model: &Model, balance: Balance) -> PhotonMap {
        let Self { mut photons, mut tints, .. } = self;
        build::order(&mut photons);
        if !tints.is_empty() {
            tints = photons.iter().map(|photon| tints[photon.rank() as usize]).collect();
        }
        PhotonMap { photons, tints, normals: Normals::of(model), balance }
    }
}

impl PhotonMap {
    /// Shoots the photons of a source and makes the map of their hits, in the caller's pool.
    ///
    /// `progress` is called from any thread with numbers of photons. Cost: tracing, and `n log n` for `n` hits.
    ///
    /// # Errors
    /// [`MapError::TooManyHits`], before more hits than that are kept.
    pub fn shoot(
        source: &PhotonSource<'_>,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<Self, MapError> {
        let mut hits = RankedHits::of(source.model);
        let balance =
            each_hit(source, progress, |deposit| hits.push(deposit.photon, deposit.weight))?;
        Ok(hits.into_map(source.model, balance))
    }

    /// Makes the map of hits, as [`PhotonMap::shoot`] makes it of the same photons, in the caller's pool.
    ///
    /// # Errors
    /// [`MapError::TooManyHits`].
    pub fn of_deposits(
        deposits: &Deposits,
        model: &Model,
        balance: Balance,
    ) -> Result<Self, MapError> {
        if deposits.len() > MOST_PHOTONS {
            return Err(MapError::TooManyHits { hits: deposits.len() });
        }
        let mut hits = RankedHits::of(model);
        let places = deposits.positions.iter().zip(&deposits.surfaces).enumerate();
        for (at, (&position, &surface)) in places {
            let weight = deposits.weights.get(at).copied().unwrap_or([1.0; 3]);
            hits.push(Photon { position, surface: surface & !TOP, rank: 0 }, weight);
        }
        Ok(hits.into_map(model, balance))
    }
}
