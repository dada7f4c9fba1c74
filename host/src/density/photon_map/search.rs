//! Search of the kd-tree: photons within a radius, and the k nearest.
//!
//! Photons are ordered by (squared distance, photon, bounce). The squared distance is computed in `f64` from `f32`
//! coordinates. The order is total, so the answer does not depend on the tree.
//!
//! # Why no photon is skipped
//! The half behind a plane is skipped only if the squared distance from the plane is greater than the limit. A photon
//! behind the plane is at least as far along the axis, subtraction and squaring round monotonously, and adding squares
//! of the other axes does not make a rounded sum smaller. So its squared distance is greater than the limit, too.

use std::f64::consts::PI;

use super::build::LEAF;
use super::{Photon, PhotonMap};
use crate::density::receiver::{Receiver, distance_squared};
use crate::photon::Side;
use crate::scene::vector::Vector64;

/// Test of the photons that count for a receiver, by an angle. Both parts hold on a smooth surface.
///
/// - The normal of the photon's surface, on the side on which the photon fell, is at most the angle away from the
///   receiver's normal.
/// - The direction from the receiver to the photon is at most the angle away from the receiver's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    cosine: f64,
    sine: f64,
}

impl Facing {
    /// Test that passes every photon whose surface does not face away.
    pub const ANY: Self = Self { cosine: 0.0, sine: 1.0 };

    /// Creates the test for an angle in degrees, clamped to 0 to 90. At 90 it is [`Facing::ANY`].
    pub fn within_degrees(degrees: f32) -> Self {
        if degrees >= 90.0 {
            return Self::ANY;
        }
        let angle = f64::from(degrees.max(0.0)) * (PI / 180.0);
        Self { cosine: libm::cos(angle), sine: libm::sin(angle) }
    }

    #[inline]
    fn accepts(
        &self,
        map: &PhotonMap,
        photon: &Photon,
        from: &NeighbourSearch<'_>,
        squared: f64,
    ) -> bool {
        /// Rounding of the product of two unit vectors.
        const ROUNDING: f64 = 1e-12;
        let Some(normal) = map.normals.get(photon.triangle()) else { return false };
        let cosine = from.receiver.normal().dot(normal);
        let cosine = if photon.side() == Side::Front { cosine } else { -cosine };
        if cosine < self.cosine - ROUNDING {
            return false;
        }
        let height = (photon.point() - from.point).dot(from.receiver.normal()).abs();
        let beyond = (height - from.slack).max(0.0);
        beyond * beyond <= self.sine * self.sine * squared
    }
}

/// Photons that a search may find: those within a radius of a receiver, border included, on surfaces that face it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbourhood<'r> {
    /// Middle of the search, and the side on which photons count.
    pub receiver: &'r Receiver,
    /// Test of the photons' surfaces; with `None` every photon counts.
    pub facing: Option<Facing>,
    /// Largest distance.
    pub radius: f64,
}

/// Photon that was found. Ordered by squared distance, then by rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Found {
    /// Bits of the squared distance. Those of numbers that are not negative have the order of the numbers.
    squared_bits: u64,
    /// Rank of the photon among all of the map, by (photon, bounce).
    pub rank: u32,
    /// Place in the array.
    pub(super) at: u32,
}

impl Found {
    fn new(squared: f64, rank: u32, at: usize) -> Self {
        Self { squared_bits: squared.to_bits(), rank, at: at as u32 }
    }

    /// Returns the squared distance from the point of the search.
    pub fn distance_squared(&self) -> f64 {
        f64::from_bits(self.squared_bits)
    }
}

/// Neighbourhood, with what its search needs for each photon.
struct NeighbourSearch<'r> {
    receiver: &'r Receiver,
    facing: Option<&'r Facing>,
    point: Vector64,
    slack: f64,
}

/// Consumer of the photons of a search. Its limit bounds the search.
trait Taker {
    /// Squared distance beyond which photons do not matter. It never grows.
    fn limit(&self) -> f64;
    fn take(&mut self, found: Found);
}

/// Hands every photon within a radius to a function.
struct All<F> {
    limit: f64,
    each: F,
}

impl<F: FnMut(Found)> Taker for All<F> {
    fn limit(&self) -> f64 {
        self.limit
    }

    fn take(&mut self, found: Found) {
        (self.each)(found);
    }
}

/// Keeps the k first. Twice as many are collected before the farther half is dropped, at a constant cost for each.
struct Nearest<'f> {
    k: usize,
    limit: f64,
    found: &'f mut Vec<Found>,
}

impl Nearest<'_> {
    fn drop_all_but_k(&mut self) {
        if self.found.len() >= self.k {
            let (_, last, _) = self.found.select_nth_unstable(self.k - 1);
            self.limit = last.distance_squared();
            self.found.truncate(self.k);
        }
    }
}

impl Taker for Nearest<'_> {
    fn limit(&self) -> f64 {
        self.limit
    }

    fn take(&mut self, found: Found) {
        self.found.push(found);
        if self.found.len() == 2 * self.k {
            self.drop_all_but_k();
        }
    }
}

impl PhotonMap {
    /// Finds the photons of a neighbourhood, in the order of (squared distance, photon, bounce).
    pub fn within(&self, around: &Neighbourhood<'_>) -> Vec<Found> {
        let mut found = Vec::new();
        self.each_within(around, |photon| found.push(photon));
        found.sort_unstable();
        found
    }

    /// Finds the `k` first photons of a neighbourhood in the order of (squared distance, photon, bounce): all of them
    /// if there are fewer. They replace the contents of `found`. Cost: about `k + log n` for `n` photons.
    pub fn nearest(&self, around: &Neighbourhood<'_>, k: usize, found: &mut Vec<Found>) {
        self.first(around, k, found);
        found.sort_unstable();
    }

    /// Finds the photons of [`PhotonMap::nearest`] in any order.
    pub(super) fn first(&self, around: &Neighbourhood<'_>, k: usize, found: &mut Vec<Found>) {
        found.clear();
        if k == 0 {
            return;
        }
        let mut taker = Nearest { k, limit: around.radius * around.radius, found };
        self.search(around, &mut taker);
        taker.drop_all_but_k();
    }

    /// Hands the photons of a neighbourhood to `each`, in any order.
    pub(super) fn each_within(&self, around: &Neighbourhood<'_>, each: impl FnMut(Found)) {
        self.search(around, &mut All { limit: around.radius * around.radius, each });
    }

    fn search(&self, around: &Neighbourhood<'_>, taker: &mut impl Taker) {
        let receiver = around.receiver;
        let (point, slack) = (receiver.point(), receiver.slack(around.radius));
        let place = NeighbourSearch { receiver, facing: around.facing.as_ref(), point, slack };
        self.search_run(0, self.photons.len(), &place, taker);
    }

    /// Searches the run `lo..hi`. Recurses to the depth of the tree, at most 31.
    fn search_run(
        &self,
        mut lo: usize,
        mut hi: usize,
        place: &NeighbourSearch<'_>,
        taker: &mut impl Taker,
    ) {
        loop {
            let Some(run) = self.photons.get(lo..hi) else { return };
            if run.len() <= LEAF {
                for (at, photon) in (lo..).zip(run) {
                    self.show(at, photon, place, taker);
                }
                return;
            }
            let middle = lo + run.len() / 2;
            let root = &run[run.len() / 2];
            let axis = root.axis();
            let from_plane = place.point.to_array()[axis] - f64::from(root.position[axis]);
            let (near, far) = if from_plane < 0.0 {
                ((lo, middle), (middle + 1, hi))
            } else {
                ((middle + 1, hi), (lo, middle))
            };
            self.search_run(near.0, near.1, place, taker);
            if from_plane * from_plane > taker.limit() {
                return;
            }
            self.show(middle, root, place, taker);
            (lo, hi) = far;
        }
    }

    #[inline]
    fn show(
        &self,
        at: usize,
        photon: &Photon,
        place: &NeighbourSearch<'_>,
        taker: &mut impl Taker,
    ) {
        let squared = distance_squared(photon.point(), place.point);
        let counts = squared <= taker.limit()
            && place.facing.is_none_or(|facing| facing.accepts(self, photon, place, squared));
        if counts {
            taker.take(Found::new(squared, photon.rank(), at));
        }
    }
}
