//! Sums over a range of the photons of a shot.

use arboleda::Counters;
use serde::{Deserialize, Serialize};

use super::digest_tree::DigestTree;
use super::{Balance, Digest};

/// Sums over a range of photons.
///
/// # Invariants
/// - `balance.hits` is the sum of `hits`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RangeSums {
    /// Ends of the photons.
    pub balance: Balance,
    /// Reflections of all photons together.
    pub bounce_count: u64,
    /// Hits on the front and on the back of each triangle, by id.
    pub hits: Vec<[u64; 2]>,
    /// Counters of the index; zero if it did not count.
    #[serde(skip)]
    pub counters: Counters,
    /// Digests of the hits.
    pub(crate) digests: DigestTree,
}

impl RangeSums {
    /// Adds the sums of the photons that follow. Tells whether both are of equally many triangles; else nothing is
    /// added.
    #[must_use]
    pub fn join(&mut self, next: Self) -> bool {
        if self.hits.len() != next.hits.len() {
            return false;
        }
        self.balance.join(&next.balance);
        self.bounce_count += next.bounce_count;
        for (sides, others) in self.hits.iter_mut().zip(next.hits) {
            sides.iter_mut().zip(others).for_each(|(side, other)| *side += other);
        }
        self.counters += next.counters;
        self.digests.join(next.digests);
        true
    }

    /// The digest of all hits. It is that of the shot if the sums are of all photons of the job, in their order.
    pub fn digest(&self) -> Digest {
        self.digests.digest()
    }
}
