//! Part of a job: what a range of its photons leaves behind, and how parts are put together.
//!
//! ```text
//! photons of a job:  part | part | part     shot anywhere, in any order, through any index
//!                      \    join   /
//!                     the sums of one run    its counts, estimates, pictures and digests
//! ```
//! Photons are numbered and sums are of integers, so it does not matter where a job is cut.

mod file;
mod job;
#[cfg(test)]
mod tests;

use std::ops::Range;

use serde::{Deserialize, Serialize};

pub use file::PartFile;
pub use job::{Job, JobKind, Overlap, missing};

use crate::density::{CountsOf, Harvest, LightSums};
use crate::photon::{Balance, Digest, RangeSums};

/// What a range of the photons of a job leaves behind.
#[derive(Clone, Debug, PartialEq)]
pub struct JobPart {
    /// The photons.
    pub photons: Range<u64>,
    /// What they leave behind.
    pub sums: PartSums,
}

/// What a range of photons leaves behind, by what it is for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PartSums {
    /// Hits of each triangle, for `shoot`.
    Shot(RangeSums),
    /// Light at receivers, for `irradiance` and `render`.
    Light(LightSums),
}

impl PartSums {
    /// Adds what the photons that follow leave behind. Tells whether it is for the same, and of as many triangles or
    /// receivers; else nothing is added.
    #[must_use]
    pub fn join(&mut self, next: Self) -> bool {
        match (self, next) {
            (Self::Shot(sums), Self::Shot(next)) => sums.join(next),
            (Self::Light(sums), Self::Light(next)) => sums.join(next),
            _ => false,
        }
    }

    /// Takes the numbers out that are only added, which may be many. What is left has to be joined in the order of
    /// photons.
    pub fn take_counts(&mut self) -> Vec<(CountsOf, Vec<u64>)> {
        match self {
            Self::Shot(sums) => {
                vec![((0, 0), std::mem::take(&mut sums.hits).into_iter().flatten().collect())]
            }
            Self::Light(sums) => sums.take_counts(),
        }
    }

    /// Puts numbers in that [`take_counts`](Self::take_counts) took out, or sums of them.
    pub fn put_counts(&mut self, of: CountsOf, counts: &[u64]) {
        match self {
            Self::Shot(sums) if of == (0, 0) => sums.hits = counts.as_chunks().0.to_vec(),
            Self::Shot(_) => {}
            Self::Light(sums) => sums.put_counts(of, counts),
        }
    }

    /// The ends of the photons.
    pub fn balance(&self) -> Balance {
        match self {
            Self::Shot(sums) => sums.balance,
            Self::Light(sums) => sums.balance(),
        }
    }

    /// Tells whether these may be the sums of a range of the photons of a job.
    fn is_of(&self, photons: &Range<u64>, job: &Job) -> bool {
        match self {
            Self::Shot(sums) => job.kind == JobKind::Shoot && is_of_shot(sums, photons, job),
            Self::Light(sums) => {
                let is_sound = |harvest: &Harvest, photons: &Range<u64>| {
                    let Balance { hits, rays, .. } = harvest.balance;
                    is_balanced(&harvest.balance, photons)
                        && are_of_paths(&[hits, rays], &harvest.balance, job)
                        && harvest.is_of(job.triangles)
                };
                let per_pass = job.photons / u64::from(job.passes.max(1));
                job.kind != JobKind::Shoot && sums.is_of(photons, per_pass, is_sound)
            }
        }
    }
}

impl JobPart {
    /// Adds the part of the photons that follow. Tells whether they do, and whether both are parts of the same; else
    /// nothing is added.
    #[must_use]
    pub fn join(&mut self, next: Self) -> bool {
        let joined = self.photons.end == next.photons.start && self.sums.join(next.sums);
        if joined {
            self.photons.end = next.photons.end;
        }
        joined
    }

    /// The digest of all hits, if the part is of a shot and has all photons of the job.
    pub fn digest(&self, job: &Job) -> Option<Digest> {
        match &self.sums {
            PartSums::Shot(sums) => {
                (self.photons == (0..job.photons)).then(|| sums.digests.digest())
            }
            PartSums::Light(_) => None,
        }
    }
}

/// Tells whether sums may be those of a range of the photons of a shot.
fn is_of_shot(sums: &RangeSums, photons: &Range<u64>, job: &Job) -> bool {
    let balance = &sums.balance;
    let hits = sums.hits.iter().flatten().try_fold(0_u64, |sum, &hits| sum.checked_add(hits));
    // Without lights no photons are emitted, and there is nothing to hash.
    let is_dark = balance.emitted == 0 && sums.digests.is_empty();
    (is_dark || sums.digests.is_of(photons, job.photons))
        && is_balanced(balance, photons)
        && hits == Some(balance.hits)
        && are_of_paths(&[balance.hits, balance.rays, sums.bounce_count], balance, job)
        && sums.hits.len() as u64 == job.triangles
}

/// Tells whether counts are no more than the segments that the paths of these photons may have. So no sum of parts wraps
/// that would not wrap in one run.
fn are_of_paths(counts: &[u64], balance: &Balance, job: &Job) -> bool {
    let most = u128::from(balance.emitted) * (u128::from(job.max_bounces) + 1);
    counts.iter().all(|&count| u128::from(count) <= most)
}

/// Tells whether a balance may be that of a range of photons; without lights, none of them is emitted.
fn is_balanced(balance: &Balance, photons: &Range<u64>) -> bool {
    let ends = [balance.absorbed, balance.escaped, balance.cut_off, balance.refused];
    let ended = ends.into_iter().try_fold(0_u64, u64::checked_add);
    let count = photons.end.checked_sub(photons.start);
    (balance.emitted == 0 || count == Some(balance.emitted))
        && ended == Some(balance.emitted)
        && balance.total_flux.is_finite()
        && balance.total_flux >= 0.0
}
