//! Estimator of irradiance: a method with its options, and the estimates at many receivers.

use arboleda::{IndexKind, RayIndex};
use rayon::prelude::*;
use thiserror::Error;

use super::estimate::Estimate;
use super::photon_map::{Gather, MapError, MapEstimator, PhotonMap};
use super::receiver::Receiver;
use super::source::PhotonSource;
use super::tangent_plane::{DiscError, Discs, Domain, TangentPlane};
use super::visible::Fan;
use crate::photon::Balance;

/// Method of estimating irradiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Estimator {
    /// Photon map; with [`Domain::Visible`] only photons in the visible part of the disc count.
    PhotonMap(MapEstimator, Domain),
    /// Density estimation on the tangent plane.
    TangentPlane(TangentPlane),
}

/// Error of an estimator.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum EstimatorError {
    /// A radius is not a positive number.
    #[error("the radius is {0}; it must be finite and above 0")]
    Radius(f32),
    /// Too few photons for the (k - 1) rule to have a deviation.
    #[error("k is {0}; it must be 3 or more")]
    FewNearest(usize),
    /// The slack is negative or not a number.
    #[error("the slack before the plane is {0} radii; it must be finite and not below 0")]
    Beyond(f32),
    /// The visible domain has to know the radius beforehand, which the k nearest have only when they are found.
    #[error("the visible domain needs a fixed radius, which the k nearest do not have")]
    VisibleNearest,
    /// The photon map cannot be made.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The discs cannot be made.
    #[error(transparent)]
    Disc(#[from] DiscError),
}

impl Estimator {
    /// Checks the options.
    ///
    /// # Errors
    /// [`EstimatorError`], by the first option that is wrong.
    pub fn check(&self) -> Result<(), EstimatorError> {
        let radius = self.radius();
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(EstimatorError::Radius(radius));
        }
        match *self {
            Self::PhotonMap(MapEstimator { gather: Gather::Nearest { k, .. }, .. }, domain) => {
                if k < 3 {
                    return Err(EstimatorError::FewNearest(k));
                }
                if domain == Domain::Visible {
                    return Err(EstimatorError::VisibleNearest);
                }
            }
            Self::TangentPlane(TangentPlane { beyond, .. }) => {
                if !(beyond >= 0.0 && beyond.is_finite()) {
                    return Err(EstimatorError::Beyond(beyond));
                }
            }
            Self::PhotonMap(..) => {}
        }
        Ok(())
    }

    /// Returns the radius; for the k nearest, the largest.
    pub fn radius(&self) -> f32 {
        match *self {
            Self::PhotonMap(MapEstimator { gather: Gather::Within { radius }, .. }, _)
            | Self::TangentPlane(TangentPlane { radius, .. }) => radius,
            Self::PhotonMap(MapEstimator { gather: Gather::Nearest { max_radius, .. }, .. }, _) => {
                max_radius
            }
        }
    }

    /// Returns the estimator with discs of `share` times the area. The radius shrinks; for the k nearest, k and the
    /// largest radius do.
    #[must_use]
    pub fn shrunk(&self, share: f64) -> Self {
        let less = |radius: f32| ((f64::from(radius) * share.sqrt()) as f32).max(f32::MIN_POSITIVE);
        match *self {
            Self::PhotonMap(map, domain) => {
                let gather = match map.gather {
                    Gather::Within { radius } => Gather::Within { radius: less(radius) },
                    Gather::Nearest { k, max_radius } => Gather::Nearest {
                        k: ((k as f64 * share) as usize).max(8).min(k),
                        max_radius: less(max_radius),
                    },
                };
                Self::PhotonMap(MapEstimator { gather, ..map }, domain)
            }
            Self::TangentPlane(plane) => {
                Self::TangentPlane(TangentPlane { radius: less(plane.radius), ..plane })
            }
        }
    }

    /// Returns the number of photons below which an estimate counts as starved: k, or 8 for a fixed radius.
    pub fn fewest(&self) -> u32 {
        match *self {
            Self::PhotonMap(MapEstimator { gather: Gather::Nearest { k, .. }, .. }, _) => k as u32,
            _ => 8,
        }
    }
}

/// Light of a scene, ready for estimates: a photon map, or photons to be streamed.
pub struct LightField<'s> {
    estimator: Estimator,
    source: PhotonSource<'s>,
    /// Kind of the index over the discs.
    disc_kind: IndexKind,
    map: Option<PhotonMap>,
    fan: Fan,
}

impl<'s> LightField<'s> {
    /// Prepares the light of a source, in the caller's pool: a photon map is made, unless it is `given`; for DETP
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
        given: Option<PhotonMap>,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<Self, EstimatorError> {
        estimator.check()?;
        let map = match (estimator, given) {
            (Estimator::TangentPlane(_), _) => None,
            (_, Some(map)) => Some(map),
            (Estimator::PhotonMap(..), None) => Some(PhotonMap::shoot(&source, progress)?),
        };
        Ok(Self { estimator, source, disc_kind, map, fan: Fan::default() })
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
    ) -> Result<(Vec<Estimate>, Work), EstimatorError> {
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
                Ok((all, Work { balance: *map.balance(), streamed: 0, bytes: map.bytes() }))
            }
            (Estimator::TangentPlane(options), _) => {
                let (kind, scene) = (self.disc_kind, self.source.index);
                let mut discs = Discs::new(receivers, options, kind, scene, &self.fan)?;
                let balance = discs.count(&self.source, photons);
                let flux = balance.photon_flux();
                let all = (0..receivers.len()).into_par_iter().map(|at| discs.estimate(at, flux));
                let all = all.collect();
                estimates(receivers.len() as u64);
                Ok((all, Work { balance, streamed: balance.emitted, bytes: discs.bytes() }))
            }
            // A photon map is made with the field.
            (Estimator::PhotonMap(..), None) => Ok((Vec::new(), Work::default())),
        }
    }
}

/// Work of estimates: the photons behind them, and the memory that they took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Work {
    /// Ends of the photons.
    pub balance: Balance,
    /// Photons that were streamed for these estimates; 0 with a photon map.
    pub streamed: u64,
    /// Bytes of the photon map, or of the discs and their index.
    pub bytes: usize,
}

impl Work {
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
