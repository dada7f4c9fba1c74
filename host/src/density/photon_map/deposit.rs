//! Deposit of photons: the hits of a source, in the order of (photon, bounce).

use crate::density::PhotonSource;
use crate::density::receiver::hit_point;
use crate::photon::{Segment, Side, Visitor};

use super::{MOST_PHOTONS, MapError, Photon, PhotonMap, build, normals_of, tint};

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
    const CHUNKS_AT_ONCE: u64 = 256;

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
        let grey = source.model.is_grey();
        let (mut photons, mut tints) = (Vec::new(), Vec::new());
        let mut hits = 0;
        let balance = source.stream(progress, &Collector { source }, |deposits| {
            hits += deposits.len();
            if hits > MOST_PHOTONS {
                photons = Vec::new();
                return;
            }
            for mut deposit in deposits {
                let rank = photons.len() as u32;
                deposit.photon.rank = rank;
                photons.push(deposit.photon);
                if !grey {
                    tints.push(tint::encoded(deposit.weight, rank));
                }
            }
        });
        if hits > MOST_PHOTONS {
            return Err(MapError::TooManyHits { hits });
        }
        build::order(&mut photons);
        if !tints.is_empty() {
            tints = photons.iter().map(|photon| tints[photon.rank() as usize]).collect();
        }
        Ok(Self { photons, tints, normals: normals_of(source.model), balance })
    }
}
