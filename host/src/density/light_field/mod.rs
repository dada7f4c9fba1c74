//! Light field: estimates at many receivers, from photons that are shot, from a photon map, or from what photons left
//! behind.

mod disc_counter;
mod harvest;

use std::sync::{Mutex, PoisonError};

use arboleda::{IndexKind, RayIndex};
use rayon::prelude::*;

use super::estimate::{Estimate, Sums};
use super::estimator::{Estimator, EstimatorError};
use super::photon_map::PhotonMap;
use super::receiver::Receiver;
use super::receiver::visible::Fan;
use super::source::PhotonSource;
use super::tangent_plane::{Discs, Domain, TangentPlane};
use crate::photon::Balance;
pub use disc_counter::DiscCounter;
pub use harvest::{CountsOf, Harvest, LightPiece, LightSums};

/// Where the light of a field comes from.
pub enum Light {
    /// Photons are shot.
    Shot,
    /// A photon map that is there already.
    Map(PhotonMap),
    /// What photons left behind.
    Harvest(Harvest),
}

/// Light of a scene, ready for estimates.
pub struct LightField<'s> {
    estimator: Estimator,
    source: PhotonSource<'s>,
    /// Kind of the index over the discs.
    disc_kind: IndexKind,
    map: Option<PhotonMap>,
    fan: Fan,
    /// Sums of DETP that photons left behind, or that are kept, and how many of them were used.
    log: Option<Mutex<SumLog>>,
}

/// Sums of DETP, in the order in which receivers are asked for.
#[derive(Default)]
struct SumLog {
    balance: Balance,
    sums: Vec<Sums>,
    /// Number of sums that were read; `None` if sums are kept.
    read: Option<usize>,
}

impl<'s> LightField<'s> {
    /// Prepares the light of a source, in the caller's pool: a photon map is made, unless it is there already; for DETP
    /// nothing is done yet.
    ///
    /// `progress` is called from any thread with numbers of photons.
    ///
    /// # Errors
    /// [`EstimatorError`].
    pub fn new(
        source: PhotonSource<'s>,
        estimator: Estimator,
        disc_kind: IndexKind,
        light: Light,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<Self, EstimatorError> {
        estimator.check()?;
        let (mut map, mut log) = (None, None);
        match (estimator, light) {
            (Estimator::TangentPlane(_), Light::Harvest(Harvest { balance, sums, .. })) => {
                log = Some(Mutex::new(SumLog { balance, sums, read: Some(0) }));
            }
            (Estimator::TangentPlane(_), _) => {}
            (Estimator::PhotonMap(..), Light::Map(given)) => map = Some(given),
            (Estimator::PhotonMap(..), Light::Harvest(Harvest { balance, deposits, .. })) => {
                map = Some(PhotonMap::of_deposits(&deposits, source.model, balance)?);
            }
            (Estimator::PhotonMap(..), Light::Shot) => {
                map = Some(PhotonMap::shoot(&source, progress)?);
            }
        }
        Ok(Self { estimator, source, disc_kind, map, fan: Fan::default(), log })
    }

    /// Prepares a field of DETP that keeps what its photons leave behind, for [`LightField::into_harvest`].
    ///
    /// # Errors
    /// [`EstimatorError`].
    pub fn keeping(
        source: PhotonSource<'s>,
        options: TangentPlane,
        disc_kind: IndexKind,
    ) -> Result<Self, EstimatorError> {
        let estimator = Estimator::TangentPlane(options);
        let field = Self::new(source, estimator, disc_kind, Light::Shot, &|_| {})?;
        Ok(Self { log: Some(Mutex::default()), ..field })
    }

    /// Returns what the photons of all estimates left behind, if it was kept.
    pub fn into_harvest(self) -> Harvest {
        let log = self.log.map(|log| log.into_inner().unwrap_or_else(PoisonError::into_inner));
        let SumLog { balance, sums, .. } = log.unwrap_or_default();
        Harvest { balance, sums, ..Harvest::default() }
    }

    /// Tells whether there are sums that no receiver asked for: then they are those of other receivers.
    ///
    /// # Errors
    /// [`EstimatorError::OtherReceivers`].
    pub fn check_used(&self) -> Result<(), EstimatorError> {
        let Some(log) = &self.log else { return Ok(()) };
        let log = log.lock().unwrap_or_else(PoisonError::into_inner);
        match log.read {
            Some(read) if read < log.sums.len() => Err(EstimatorError::OtherReceivers),
            _ => Ok(()),
        }
    }

    /// Returns the photon map, if there is one.
    pub fn map(&self) -> Option<&PhotonMap> {
        self.map.as_ref()
    }

    /// Returns the source of the photons.
    pub fn source(&self) -> &PhotonSource<'s> {
        &self.source
    }

    /// Returns the kind of the index over discs.
    pub fn disc_kind(&self) -> IndexKind {
        self.disc_kind
    }

    /// Returns the estimator.
    pub fn estimator(&self) -> &Estimator {
        &self.estimator
    }

    /// Estimates the irradiance at receivers, in their order, in the caller's pool.
    ///
    /// `photons` is called with numbers of photons that were streamed, `estimates` with numbers of estimates, both from
    /// any thread.
    ///
    /// # Errors
    /// [`EstimatorError::Disc`].
    pub fn estimates(
        &self,
        receivers: &[Receiver],
        photons: &(impl Fn(u64) + Sync),
        estimates: &(impl Fn(u64) + Sync),
    ) -> Result<(Vec<Estimate>, EstimateWork), EstimatorError> {
        /// Receivers between two calls of `estimates`.
        const SOME: usize = 1024;
        match (&self.estimator, &self.map) {
            (Estimator::PhotonMap(estimator, domain), Some(map)) => {
                let scene: &(dyn RayIndex + Sync) = self.source.index;
                let of_some = |some: &[Receiver]| {
                    let mut found = Vec::new();
                    let mut estimate = |receiver: &Receiver| {
                        let radius = f64::from(self.estimator.radius());
                        let polygon = (*domain == Domain::Visible)
                            .then(|| self.fan.polygon(receiver, radius, 0.0, scene));
                        estimator.estimate(map, receiver, polygon.as_ref(), &mut found)
                    };
                    let some: Vec<Estimate> = some.iter().map(&mut estimate).collect();
                    estimates(some.len() as u64);
                    some
                };
                let all = receivers.par_chunks(SOME).flat_map_iter(of_some).collect();
                Ok((all, EstimateWork { balance: *map.balance(), streamed: 0, bytes: map.bytes() }))
            }
            (Estimator::TangentPlane(options), _) => {
                let (sums, areas, work) = self.sums(receivers, options, photons)?;
                let flux = work.balance.photon_flux();
                let counted = sums.par_iter().zip(&areas);
                let all = counted.map(|(sums, &area)| options.estimate(sums, area, flux)).collect();
                estimates(receivers.len() as u64);
                Ok((all, work))
            }
            // A photon map is made with the field.
            (Estimator::PhotonMap(..), None) => Ok((Vec::new(), EstimateWork::default())),
        }
    }

    /// Returns the sums of DETP at receivers, and the areas in which photons count. The sums are those that photons left
    /// behind, else of photons that are shot.
    fn sums(
        &self,
        receivers: &[Receiver],
        options: &TangentPlane,
        photons: &(impl Fn(u64) + Sync),
    ) -> Result<(Vec<Sums>, Vec<f64>, EstimateWork), EstimatorError> {
        let (kind, scene) = (self.disc_kind, self.source.index);
        let lock =
            || self.log.as_ref().map(|log| log.lock().unwrap_or_else(PoisonError::into_inner));
        if let Some(SumLog { balance, sums, read: Some(read) }) = lock().as_deref_mut() {
            let own = sums.get(*read..*read + receivers.len());
            let own = own.ok_or(EstimatorError::OtherReceivers)?.to_vec();
            *read += receivers.len();
            let polygons = options.polygons(receivers, scene, &self.fan);
            let areas = options.areas(receivers.len(), &polygons);
            let bytes = size_of_val(sums.as_slice());
            return Ok((own, areas, EstimateWork { balance: *balance, streamed: 0, bytes }));
        }
        let mut discs = Discs::new(receivers, options, kind, scene, &self.fan)?;
        let balance = discs.count(&self.source, photons);
        let work = EstimateWork { balance, streamed: balance.emitted, bytes: discs.bytes() };
        let (own, areas) = discs.into_sums();
        if let Some(log) = lock().as_deref_mut() {
            log.balance = balance;
            log.sums.extend_from_slice(&own);
        }
        Ok((own, areas, work))
    }
}

/// Work of estimates: the photons behind them, and the memory that they took.
#[derive(Clone, Copy, Debug, Default)]
pub struct EstimateWork {
    /// Ends of the photons.
    pub balance: Balance,
    /// Photons that were streamed for these estimates; 0 with a photon map.
    pub streamed: u64,
    /// Bytes of the photon map, or of the discs and their index.
    pub bytes: usize,
}

impl EstimateWork {
    /// Returns the work of these estimates and of others with the same photons, one after the other.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            balance: other.balance,
            streamed: self.streamed + other.streamed,
            bytes: self.bytes.max(other.bytes),
        }
    }
}
