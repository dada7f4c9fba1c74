//! Estimates of irradiance from a photon map.

use super::PhotonMap;
use super::search::{Facing, Found, Neighbourhood};
use crate::density::Kernel;
use crate::density::estimate::{Estimate, Sums, disc_area, rounded};
use crate::density::receiver::Receiver;
use crate::density::receiver::visible::VisiblePolygon;

/// Photons that an estimate takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gather {
    /// The `k` nearest, at most `max_radius` away.
    Nearest {
        /// Number of photons, 3 or more.
        k: usize,
        /// Largest radius, finite and above 0.
        max_radius: f32,
    },
    /// All within a radius.
    Within {
        /// The radius, finite and above 0.
        radius: f32,
    },
}

/// Estimator of irradiance by a photon map.
///
/// # The k nearest
/// The farthest of the `k` photons gives the radius `r`, and is not counted: given `r`, the others are uniform in the
/// disc in a uniform field. So `(k - 1) / (pi r^2)` is an unbiased estimate of the density, while `k / (pi r^2)` is too
/// large by `k / (k - 1)`. The relative standard deviation is `1 / sqrt(k - 2)`. If fewer than `k` photons are within
/// the largest radius, all of them count in the disc of that radius.
///
/// # Source
/// R. J. García Hernández, C. Ureña, J. Poch, M. Sbert, *Description and Solution of an Unreported Intrinsic Bias in
/// Photon Mapping Density Estimation with Constant Kernel*, Computer Graphics Forum 2012.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapEstimator {
    /// Photons that an estimate takes.
    pub gather: Gather,
    /// Surfaces whose photons count.
    pub facing: Facing,
    /// Weight by distance.
    pub kernel: Kernel,
}

impl MapEstimator {
    /// Estimates the irradiance at a receiver. With a polygon, only photons inside it count, and its area is that of
    /// the estimate; an estimate of the k nearest ignores it. `found` is memory for the search.
    pub fn estimate(
        &self,
        map: &PhotonMap,
        receiver: &Receiver,
        polygon: Option<&VisiblePolygon<'_>>,
        found: &mut Vec<Found>,
    ) -> Estimate {
        match self.gather {
            Gather::Nearest { k, max_radius } => {
                let max_radius = f64::from(max_radius);
                map.first(&self.around(receiver, max_radius), k, found);
                match found.iter().max().copied() {
                    // At a distance of 0 there is no density.
                    Some(farthest) if found.len() >= k && farthest.distance_squared() > 0.0 => {
                        self.of_nearest(map, found, farthest)
                    }
                    _ => self.of_all(map, found, max_radius),
                }
            }
            Gather::Within { radius } => self.of_disc(map, receiver, radius.into(), polygon),
        }
    }

    fn around<'r>(&self, receiver: &'r Receiver, radius: f64) -> Neighbourhood<'r> {
        Neighbourhood { receiver, facing: Some(self.facing), radius }
    }

    /// Estimates from the k nearest, of which the farthest is not counted.
    fn of_nearest(&self, map: &PhotonMap, found: &[Found], farthest: Found) -> Estimate {
        let squared = farthest.distance_squared();
        let counted = found.iter().filter(|&&photon| photon != farthest);
        let sums = self.sums(map, counted, squared);
        let flux = map.balance.photon_flux();
        let mut estimate = sums.estimate(flux, disc_area(squared), squared.sqrt());
        estimate.count = found.len() as u32;
        // The radius varies too, which adds the k-th photon's share: 1 / sqrt(k - 2) instead of 1 / sqrt(k - 1).
        let k = found.len() as f64;
        let factor = ((k - 1.0) / (k - 2.0).max(1.0)).sqrt();
        estimate.standard_error = rounded(f64::from(estimate.standard_error) * factor);
        estimate
    }

    /// Estimates from all photons within the largest radius, fewer than k.
    fn of_all(&self, map: &PhotonMap, found: &[Found], radius: f64) -> Estimate {
        let squared = radius * radius;
        let sums = self.sums(map, found.iter(), squared);
        sums.estimate(map.balance.photon_flux(), disc_area(squared), radius)
    }

    fn sums<'f>(
        &self,
        map: &PhotonMap,
        found: impl Iterator<Item = &'f Found>,
        radius_squared: f64,
    ) -> Sums {
        let mut sums = Sums::default();
        for photon in found {
            let kernel = self.kernel.weight(photon.distance_squared() / radius_squared);
            sums.add(map.weights(photon.at as usize), kernel);
        }
        sums
    }

    fn of_disc(
        &self,
        map: &PhotonMap,
        receiver: &Receiver,
        radius: f64,
        polygon: Option<&VisiblePolygon<'_>>,
    ) -> Estimate {
        let squared = radius * radius;
        let mut sums = Sums::default();
        map.each_within(&self.around(receiver, radius), |photon| {
            let at = photon.at as usize;
            let inside = polygon
                .is_none_or(|polygon| polygon.contains(map.photons[at].point() - receiver.point()));
            if inside {
                let kernel = self.kernel.weight(photon.distance_squared() / squared);
                sums.add(map.weights(at), kernel);
            }
        });
        let area = polygon.map_or(disc_area(squared), |polygon| polygon.area(self.kernel));
        sums.estimate(map.balance.photon_flux(), area, radius)
    }
}
