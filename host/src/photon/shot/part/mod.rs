//! Part of a job: what a range of its photons leaves behind, and how parts are put together.
//!
//! ```text
//! photons of a job:  part | part | part     shot anywhere, in any order, through any index
//!                      \    join   /
//!                         Shot              the counts and the digest of one run
//! ```
//! Photons are numbered and sums are of integers, so it does not matter where a job is cut.

mod file;
mod job;

use std::ops::Range;

use arboleda::Counters;
use serde::{Deserialize, Serialize};

use super::digest_tree::DigestTree;
use super::{Balance, Digest};
pub use file::PartFile;
pub use job::{Job, Overlap, missing};

/// What a range of the photons of a job leaves behind.
#[derive(Clone, Debug, PartialEq)]
pub struct JobPart {
    /// The photons.
    pub photons: Range<u64>,
    /// What they leave behind.
    pub sums: RangeSums,
}

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
    pub(super) digests: DigestTree,
}

impl JobPart {
    /// Adds the part of the photons that follow. Tells whether they do, and whether both are of equally many triangles;
    /// else nothing is added.
    #[must_use]
    pub fn join(&mut self, next: Self) -> bool {
        let (sums, other) = (&mut self.sums, next.sums);
        if self.photons.end != next.photons.start || sums.hits.len() != other.hits.len() {
            return false;
        }
        self.photons.end = next.photons.end;
        sums.balance.join(&other.balance);
        sums.bounce_count += other.bounce_count;
        for (sides, others) in sums.hits.iter_mut().zip(other.hits) {
            sides.iter_mut().zip(others).for_each(|(side, other)| *side += other);
        }
        sums.counters += other.counters;
        sums.digests.join(other.digests);
        true
    }

    /// The digest of all hits, if the part has all photons of the job.
    pub fn digest(&self, job: &Job) -> Option<Digest> {
        (self.photons == (0..job.photons)).then(|| self.sums.digests.digest())
    }
}

#[cfg(test)]
mod tests {
    use arboleda::{IndexKind, Vec3};

    use super::*;
    use crate::photon::fixtures::{BuiltIndex, closed_box, lamp, model};
    use crate::photon::{ShootOptions, Shot, shoot, shoot_part};
    use crate::scene::Model;

    fn room(photons: u64) -> (Model, ShootOptions) {
        let mut triangles = closed_box(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0));
        triangles.pop();
        let model = model(triangles, 0.7, lamp(Vec3::new(2.0, 1.5, 1.9), 0.5, 40.0));
        (model, ShootOptions { photons, max_bounces: 6, ..ShootOptions::default() })
    }

    /// Shoots the photons between neighbouring cuts through one index after the other, with one to three threads.
    fn parts(model: &Model, options: &ShootOptions, cuts: &[u64]) -> Vec<JobPart> {
        let ends = cuts.iter().skip(1).copied();
        let ranges = cuts.iter().zip(ends).map(|(&start, end)| start..end);
        let shot = ranges.enumerate().map(|(at, range)| {
            let mut built = BuiltIndex::new(model, IndexKind::ALL[at % IndexKind::ALL.len()]);
            let options = ShootOptions { threads: Some(1 + at % 3), ..options.clone() };
            shoot_part(model, built.index().as_ray_index(), &options, range, &|_| {})
        });
        shot.collect()
    }

    fn join(parts: Vec<JobPart>) -> Option<JobPart> {
        parts.into_iter().reduce(|mut all, part| {
            assert!(all.join(part));
            all
        })
    }

    fn whole(model: &Model, options: &ShootOptions) -> Shot {
        shoot(model, &BuiltIndex::new(model, IndexKind::Octree).index(), options, &|_| {})
    }

    #[test]
    fn parts_cut_anywhere_are_the_shot() {
        for (photons, cuts) in [
            (70_000, &[0, 1, 2, 1_023, 1_025, 5_000, 40_960, 40_961, 69_999, 70_000][..]),
            (70_000, &[0, 32_768, 65_536, 70_000]),
            (70_000, &[0, 70_000]),
            (2_048, &[0, 1_024, 1_500, 2_048]),
            (500, &[0, 100, 300, 500]),
            (1, &[0, 1]),
        ] {
            let (model, options) = room(photons);
            let (job, shot) = (Job::new(&model, &options), whole(&model, &options));
            // The left half, the right half, and both.
            let mut left = parts(&model, &options, cuts);
            let right = left.split_off(left.len() / 2);
            let halves: Vec<JobPart> = [left, right].into_iter().filter_map(join).collect();
            let joined = join(halves).unwrap();
            assert_eq!(joined.digest(&job), Some(shot.digest), "{cuts:?}");
            assert_eq!(joined.sums.balance, shot.balance);
            assert_eq!(joined.sums.bounce_count, shot.bounce_count);
            let both: Vec<u64> = joined.sums.hits.iter().map(|[a, b]| a + b).collect();
            assert_eq!(both, shot.hit_counts);
            let front: Vec<u64> = joined.sums.hits.iter().map(|sides| sides[0]).collect();
            assert_eq!(front, shot.front_hit_counts);
        }
    }

    #[test]
    fn parts_that_do_not_follow_are_not_joined() {
        let (model, options) = room(3_000);
        let [first, second, third] = &parts(&model, &options, &[0, 1_000, 2_000, 3_000])[..] else {
            panic!("three parts")
        };
        let mut joined = first.clone();
        assert!(!joined.join(third.clone()) && !joined.join(first.clone()));
        assert_eq!(joined, *first);
        assert!(joined.join(second.clone()) && joined.join(third.clone()));
    }

    #[test]
    fn a_shot_without_photons_knows_the_flux_of_the_lights() {
        let (model, options) = room(0);
        let shot = whole(&model, &options);
        assert_eq!((shot.balance.emitted, shot.balance.total_flux), (0, 40.0));
    }

    #[test]
    fn a_scene_without_light_has_parts_too() {
        let (mut model, options) = room(3_000);
        model.lights.clear();
        let (job, shot) = (Job::new(&model, &options), whole(&model, &options));
        let joined = join(parts(&model, &options, &[0, 10, 3_000])).unwrap();
        assert_eq!(joined.digest(&job), Some(shot.digest));
    }
}
