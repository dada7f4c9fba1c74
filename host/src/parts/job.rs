//! Job: what sums over photons depend on, and which of its photons are missing.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::photon::ShootOptions;
use crate::scene::Model;

/// Kind of a job: the command whose photons it shoots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum JobKind {
    /// Counts of each triangle.
    Shoot,
    /// Irradiance at points.
    Irradiance,
    /// A picture.
    Render,
}

impl fmt::Display for JobKind {
    /// Writes the name on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Shoot => "shoot",
            Self::Irradiance => "irradiance",
            Self::Render => "render",
        })
    }
}

/// What the sums over photons depend on. Parts of equal jobs can be put together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Job {
    /// Version of the program. Another one may shoot other photons, or read another scene from the same file.
    pub program: String,
    /// Kind: the command that shoots the photons.
    pub kind: JobKind,
    /// Digest of the triangles, materials and lights.
    pub model: [u8; 32],
    /// Number of triangles.
    pub triangles: u64,
    /// Number of photons of all parts together.
    pub photons: u64,
    /// Passes of a picture, of equally many photons; 1 otherwise.
    pub passes: u32,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Most bounces of a photon.
    pub max_bounces: u32,
    /// Options of the estimates, each with its name.
    pub options: Vec<(String, String)>,
}

impl Job {
    /// Version of this program.
    pub const PROGRAM: &str = env!("CARGO_PKG_VERSION");

    /// The job of shooting photons from the lights of a model.
    pub fn of_shot(model: &Model, options: &ShootOptions) -> Self {
        Self {
            program: Self::PROGRAM.to_owned(),
            kind: JobKind::Shoot,
            model: *model.digest().as_bytes(),
            triangles: model.triangles.len() as u64,
            photons: options.photons,
            passes: 1,
            seed: options.seed,
            max_bounces: options.max_bounces,
            options: Vec::new(),
        }
    }

    /// Says in what another job differs from this one; `None` if they are equal.
    pub fn difference(&self, other: &Self) -> Option<String> {
        if self.program != other.program {
            let [own, others] = [&self.program, &other.program];
            return Some(format!("version {others} of the program, not {own}"));
        }
        if self.kind != other.kind {
            return Some(format!("photons for `{}`, not for `{}`", other.kind, self.kind));
        }
        let numbers = [
            ("photons in all", self.photons, other.photons),
            ("passes", self.passes.into(), other.passes.into()),
            ("as seed", self.seed, other.seed),
            ("bounces at most", self.max_bounces.into(), other.max_bounces.into()),
            ("triangles", self.triangles, other.triangles),
        ];
        let differing = numbers.into_iter().find(|(_, own, others)| own != others);
        if let Some((what, own, others)) = differing {
            return Some(format!("{others} {what}, not {own}"));
        }
        if self.model != other.model {
            return Some("another scene, other materials or other lights".to_owned());
        }
        let mut both = self.options.iter().zip(&other.options);
        let differing = both.find(|(own, others)| own != others);
        if let Some(((own_name, own), (name, others))) = differing {
            return Some(if name == own_name {
                format!("{name} {others}, not {own}")
            } else {
                format!("{name} {others}, not {own_name} {own}")
            });
        }
        let same = self.options.len() == other.options.len();
        (!same).then(|| "other options".to_owned())
    }

    /// Tells whether 64 bits can count the segments of all paths. Then no sum over photons wraps, however the job is cut.
    pub fn is_countable(&self) -> bool {
        let segments = u128::from(self.photons) * (u128::from(self.max_bounces) + 1);
        segments <= u64::MAX.into()
    }
}

/// Photons that two parts have in common: they would be counted twice.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub struct Overlap {
    /// The photons.
    pub photons: Range<u64>,
    /// Places of both parts in the list.
    pub parts: [usize; 2],
}

impl fmt::Display for Overlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { photons, parts: [a, b] } = self;
        write!(f, "photons {}..{} are in parts {a} and {b}", photons.start, photons.end)
    }
}

/// Lists the ranges of the photons `0..photons` that no part has, in their order. Parts come in any order; empty ones
/// have no photon.
///
/// # Errors
/// If two parts have a photon in common.
pub fn missing(photons: u64, parts: &[Range<u64>]) -> Result<Vec<Range<u64>>, Overlap> {
    let mut order: Vec<usize> = (0..parts.len()).filter(|&part| !parts[part].is_empty()).collect();
    order.sort_by_key(|&part| parts[part].start);
    let mut gaps = Vec::new();
    let (mut end, mut last) = (0, None);
    for part in order {
        let range = &parts[part];
        if let Some(last) = last.filter(|_| range.start < end) {
            let photons = range.start..range.end.min(end);
            return Err(Overlap { photons, parts: [last, part] });
        }
        if range.start > end {
            gaps.push(end..range.start);
        }
        (end, last) = (range.end, Some(part));
    }
    if end < photons {
        gaps.push(end..photons);
    }
    Ok(gaps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_listed_and_overlaps_are_errors() {
        assert_eq!(missing(10, &[]), missing(10, &[3..3, 5..5]));
        assert!(missing(10, &[]).unwrap().into_iter().eq([(0, 10)].map(|(start, end)| start..end)));
        assert_eq!(missing(10, &[4..6, 0..2, 6..7, 3..3]), Ok(vec![2..4, 7..10]));
        assert_eq!(missing(10, &[5..10, 0..5]), Ok(vec![]));
        assert_eq!(missing(0, &[]), Ok(vec![]));
        let overlap = Overlap { photons: 4..5, parts: [1, 0] };
        assert_eq!(missing(10, &[4..6, 0..5]), Err(overlap));
        assert_eq!(missing(10, &[0..9, 2..3]).unwrap_err().photons, 2..3);
        assert_eq!(missing(10, &[2..3, 2..3]).unwrap_err().photons, 2..3);
    }
}
