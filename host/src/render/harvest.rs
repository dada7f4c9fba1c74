//! What a range of a picture's photons leaves behind: the light of its passes, before it is put into pixels.

use std::ops::Range;

use super::gather::Gathering;
use super::passes::{Pass, Passes, bands};
use super::samples::TileSamples;
use crate::density::{
    Estimator, EstimatorError, Harvest, LightField, LightPiece, LightSums, PhotonSource,
    TangentPlane,
};

impl Passes<'_> {
    /// Shoots a range of the photons of all passes, in the caller's pool. `progress` is called from any thread with
    /// numbers of photons; a photon counts as often as it is shot.
    ///
    /// # Errors
    /// [`EstimatorError`].
    pub fn harvest(
        &self,
        photons: &Range<u64>,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<LightSums, EstimatorError> {
        let mut sums = LightSums::default();
        for pass in self.each() {
            let own = &pass.source.photons;
            let photons = own.start.max(photons.start)..own.end.min(photons.end);
            if photons.is_empty() {
                continue;
            }
            let source = PhotonSource { photons: photons.clone(), ..pass.source.clone() };
            let [all, direct] = match pass.estimator {
                Estimator::TangentPlane(plane) => self.crossings(source, &pass, plane, progress)?,
                Estimator::PhotonMap(..) => {
                    let all = Harvest::of_hits(&source, progress)?;
                    let direct = match self.final_gather {
                        0 => None,
                        _ => Some(Harvest::of_hits(&Gathering::direct(&source), progress)?),
                    };
                    [Some(all), direct]
                }
            };
            let all = all.unwrap_or_default();
            let piece = LightPiece { pass: pass.number, photons, all, direct };
            // The photons of a pass follow those of the one before.
            let follows = sums.join(LightSums::of(piece));
            debug_assert!(follows, "passes in their order");
        }
        Ok(sums)
    }

    /// Counts the photons of a source that cross the discs of a pass.
    fn crossings(
        &self,
        source: PhotonSource<'_>,
        pass: &Pass<'_>,
        plane: TangentPlane,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<[Option<Harvest>; 2], EstimatorError> {
        let model = source.model;
        let field = LightField::keeping(source, plane, self.disc_kind)?;
        let mut gathering = None;
        if self.final_gather > 0 {
            let source = Gathering::direct(field.source());
            let direct = LightField::keeping(source, plane, self.disc_kind)?;
            gathering = Some(Gathering::new(direct, self.final_gather, pass.first_point()));
        }
        for band in bands(&self.camera, self.sampling) {
            let index = field.source().index;
            let samples = TileSamples::of_rows(&self.camera, self.sampling, model, index, band);
            let receivers = &samples.receivers;
            match &mut gathering {
                None => field.estimates(receivers, progress, &|_| {})?,
                Some(gathering) => gathering.estimates(&field, receivers, progress, &|_| {})?,
            };
        }
        let direct = gathering.map(|gathering| gathering.into_direct().into_harvest());
        Ok([Some(field.into_harvest()), direct])
    }
}
