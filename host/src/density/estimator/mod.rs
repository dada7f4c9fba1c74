//! Estimator of irradiance: a method with its options; and the radius that suits the photons.

mod radius;

use thiserror::Error;

use super::photon_map::{Gather, MapError, MapEstimator};
use super::tangent_plane::{DiscError, Domain, TangentPlane};
pub use radius::{automatic_radius, wanted_photons};

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
    /// Photons left sums behind at other receivers.
    #[error("the parts have sums of other points")]
    OtherReceivers,
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
