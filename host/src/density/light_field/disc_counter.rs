//! Counter of DETP for one range of photons after the other, at the same receivers.

use std::sync::{Mutex, PoisonError};

use arboleda::IndexKind;

use super::Harvest;
use crate::density::estimator::EstimatorError;
use crate::density::photon_map::Deposits;
use crate::density::receiver::Receiver;
use crate::density::receiver::visible::Fan;
use crate::density::source::PhotonSource;
use crate::density::tangent_plane::{Discs, TangentPlane};

/// Receivers, and the discs around them that were counted last. Ranges of photons of one radius share the discs: their
/// polygons and their index take as long as some hundred thousand photons.
pub struct DiscCounter<'r> {
    receivers: &'r [Receiver],
    fan: &'r Fan,
    discs: Mutex<Option<(TangentPlane, Discs<'r>)>>,
}

impl<'r> DiscCounter<'r> {
    /// Creates a counter at receivers. Nothing is done yet.
    pub fn new(receivers: &'r [Receiver], fan: &'r Fan) -> Self {
        Self { receivers, fan, discs: Mutex::default() }
    }

    /// Counts the photons of a source that cross the discs, in the caller's pool. `progress` is called from any thread
    /// with numbers of photons.
    ///
    /// # Errors
    /// [`EstimatorError`].
    pub fn harvest(
        &self,
        source: &PhotonSource<'_>,
        options: TangentPlane,
        disc_kind: IndexKind,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<Harvest, EstimatorError> {
        // 1. The discs of before, if they are of these options. They are taken out, so that no thread waits with a lock.
        let lock = || self.discs.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = lock().take().filter(|(before, _)| *before == options);
        let mut discs = match kept {
            Some((_, discs)) => discs,
            None => Discs::new(self.receivers, &options, disc_kind, source.index, self.fan)?,
        };
        // 2. The photons.
        let balance = discs.count(source, progress);
        let sums = discs.take_sums();
        *lock() = Some((options, discs));
        Ok(Harvest { balance, sums, deposits: Deposits::default() })
    }
}
