//! What a range of a picture's photons leaves behind: the light of its passes, before it is put into pixels.

use std::ops::Range;

use super::gather::Gathering;
use super::passes::{Pass, Passes, bands};
use super::samples::TileSamples;
use crate::density::{
    DiscCounter, Estimator, EstimatorError, Fan, Harvest, LightField, LightPiece, LightSums,
    PhotonSource, Receiver, TangentPlane,
};

/// What is the same for all ranges of a picture's photons: with DETP, its receivers.
pub struct PictureGround {
    /// All receivers, if they are counted at once.
    receivers: Option<Vec<Receiver>>,
    fan: Fan,
}

impl PictureGround {
    /// Returns the counter of all receivers, if they are counted at once.
    pub fn counter(&self) -> Option<DiscCounter<'_>> {
        self.receivers.as_ref().map(|receivers| DiscCounter::new(receivers, &self.fan))
    }
}

impl Passes<'_> {
    /// Finds what is the same for all ranges of the photons, in the caller's pool.
    pub fn ground(&self) -> PictureGround {
        let mut bands = bands(&self.camera, self.sampling);
        let (first, more) = (bands.next(), bands.next());
        let is_detp = matches!(self.estimator, Estimator::TangentPlane(_));
        let at_once = is_detp && self.final_gather == 0 && more.is_none();
        let PhotonSource { model, index, .. } = self.source;
        let receivers = first.filter(|_| at_once).map(|band| {
            TileSamples::of_rows(&self.camera, self.sampling, model, index, band).receivers
        });
        PictureGround { receivers, fan: Fan::default() }
    }

    /// Shoots a range of the photons of all passes, in the caller's pool. `counter` is that of the picture's
    /// [`ground`](Self::ground). `progress` is called from any thread with
    /// numbers of photons; a photon counts as often as it is shot.
    ///
    /// # Errors
    /// [`EstimatorError`].
    pub fn harvest(
        &self,
        counter: Option<&DiscCounter<'_>>,
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
                Estimator::TangentPlane(plane) => match counter {
                    Some(counter) => {
                        let kind = self.disc_kind;
                        [Some(counter.harvest(&source, plane, kind, progress)?), None]
                    }
                    None => self.crossings(source, &pass, plane, progress)?,
                },
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

    /// Counts the photons of a source that cross the discs of a pass, band by band.
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
