//! Harvest: what photons leave behind for estimates, before it is estimated from.
//!
//! ```text
//! DETP         sums at each receiver      added
//! photon map   hits of the photons        in the order of photons
//! ```
//! Sums are of whole numbers, and hits are in a total order. So harvests of neighbouring ranges of photons, shot anywhere,
//! are joined to that of all, to the bit.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::density::estimate::Sums;
use crate::density::estimator::EstimatorError;
use crate::density::photon_map::Deposits;
use crate::density::source::PhotonSource;
use crate::photon::Balance;

/// What a range of photons leaves behind for one light field.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Harvest {
    /// Ends of the photons.
    pub balance: Balance,
    /// Sums at the receivers, in the order in which they were asked for; empty for a photon map.
    pub(super) sums: Vec<Sums>,
    /// Hits; none for DETP.
    pub(super) deposits: Deposits,
}

impl Harvest {
    /// Shoots the photons of a source and keeps their hits, for a photon map, in the caller's pool.
    ///
    /// # Errors
    /// [`EstimatorError::Map`].
    pub fn of_hits(
        source: &PhotonSource<'_>,
        progress: &(impl Fn(u64) + Sync),
    ) -> Result<Self, EstimatorError> {
        let (deposits, balance) = Deposits::shoot(source, progress)?;
        Ok(Self { balance, sums: Vec::new(), deposits })
    }

    fn take_counts(&mut self) -> Vec<u64> {
        std::mem::take(&mut self.sums).into_iter().flat_map(Sums::to_words).collect()
    }

    fn put_counts(&mut self, counts: &[u64]) {
        let (sums, _) = counts.as_chunks();
        self.sums = sums.iter().map(|&words| Sums::from_words(words)).collect();
    }

    /// Tells whether another harvest has as many receivers.
    fn is_like(&self, other: &Self) -> bool {
        self.sums.len() == other.sums.len()
    }

    fn join(&mut self, next: Self) {
        self.balance.join(&next.balance);
        for (sum, next) in self.sums.iter_mut().zip(&next.sums) {
            sum.join(next);
        }
        self.deposits.join(next.deposits);
    }

    /// Tells whether this may be the harvest of a model of `triangles` triangles.
    pub(crate) fn is_of(&self, triangles: u64) -> bool {
        (self.sums.is_empty() || self.deposits.is_empty()) && self.deposits.are_of(triangles)
    }
}

/// Pass and field of numbers that are only added.
pub type CountsOf = (u32, u32);

/// What photons of one pass leave behind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightPiece {
    /// Number of the pass, from 0.
    pub pass: u32,
    /// The photons.
    pub photons: Range<u64>,
    /// For the light field.
    pub all: Harvest,
    /// For the field of direct light, which final gathering has.
    pub direct: Option<Harvest>,
}

impl LightPiece {
    fn follows(&self, before: &Self) -> bool {
        let direct = match (&before.direct, &self.direct) {
            (Some(before), Some(next)) => before.is_like(next),
            (before, next) => before.is_none() == next.is_none(),
        };
        before.photons.end == self.photons.start && before.all.is_like(&self.all) && direct
    }
}

/// What a range of the photons of all passes leaves behind.
///
/// # Invariants
/// - Pieces are in the order of passes, at most one for each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LightSums {
    pieces: Vec<LightPiece>,
}

impl LightSums {
    /// The sums of one pass, or of a part of it.
    pub fn of(piece: LightPiece) -> Self {
        Self { pieces: vec![piece] }
    }

    /// Adds the sums of the photons that follow. Tells whether they do, at as many receivers; else nothing is added.
    #[must_use]
    pub fn join(&mut self, next: Self) -> bool {
        let follows = match (self.pieces.last(), next.pieces.first()) {
            (Some(last), Some(first)) if last.pass == first.pass => first.follows(last),
            (Some(last), Some(first)) => last.photons.end == first.photons.start,
            _ => true,
        };
        if follows {
            for piece in next.pieces {
                match self.pieces.last_mut().filter(|last| last.pass == piece.pass) {
                    Some(last) => {
                        last.photons.end = piece.photons.end;
                        last.all.join(piece.all);
                        if let (Some(direct), Some(next)) = (&mut last.direct, piece.direct) {
                            direct.join(next);
                        }
                    }
                    None => self.pieces.push(piece),
                }
            }
        }
        follows
    }

    /// Takes the numbers out that are only added, each list with its pass and its field: 0 for all light, 1 for direct
    /// light.
    pub fn take_counts(&mut self) -> Vec<(CountsOf, Vec<u64>)> {
        let mut all = Vec::new();
        for piece in &mut self.pieces {
            all.push(((piece.pass, 0), piece.all.take_counts()));
            all.extend(piece.direct.as_mut().map(|direct| ((piece.pass, 1), direct.take_counts())));
        }
        all
    }

    /// Puts numbers in that [`take_counts`](Self::take_counts) took out, or sums of them.
    pub fn put_counts(&mut self, (pass, field): CountsOf, counts: &[u64]) {
        if let Some(piece) = self.pieces.iter_mut().find(|piece| piece.pass == pass) {
            match (field, &mut piece.direct) {
                (0, _) => piece.all.put_counts(counts),
                (_, Some(direct)) => direct.put_counts(counts),
                _ => {}
            }
        }
    }

    /// Takes the sums of a pass out, if they are there.
    pub fn take(&mut self, pass: u32) -> Option<LightPiece> {
        let at = self.pieces.iter().position(|piece| piece.pass == pass)?;
        Some(self.pieces.remove(at))
    }

    /// Returns the ends of all photons.
    pub fn balance(&self) -> Balance {
        self.pieces.iter().fold(Balance::default(), |mut all, piece| {
            all.join(&piece.all.balance);
            all
        })
    }

    /// Tells whether these may be the sums of a range of photons, of `per_pass` each pass; `is_sound` tells it of a
    /// harvest.
    pub(crate) fn is_of(
        &self,
        photons: &Range<u64>,
        per_pass: u64,
        is_sound: impl Fn(&Harvest, &Range<u64>) -> bool,
    ) -> bool {
        let mut end = photons.start;
        let follow = self.pieces.iter().all(|piece| {
            let LightPiece { pass, photons, all, direct } = piece;
            let of_pass = |photon: u64| photon.checked_div(per_pass) == Some(u64::from(*pass));
            let sound = photons.start == end
                && photons.start < photons.end
                && of_pass(photons.start)
                && of_pass(photons.end - 1)
                && is_sound(all, photons)
                && direct.as_ref().is_none_or(|direct| is_sound(direct, photons));
            end = photons.end;
            sound
        });
        let passes = self.pieces.windows(2).all(|pair| pair[0].pass < pair[1].pass);
        follow && passes && end == photons.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sums of photons at two receivers, and those of direct light at one.
    fn piece(pass: u32, photons: Range<u64>) -> LightPiece {
        let sums = |weight: f32| {
            let mut sums = Sums::default();
            for photon in photons.clone() {
                sums.add([weight, 0.5, photon as f32], 1.5);
            }
            sums
        };
        let harvest = |sums| Harvest { sums, ..Harvest::default() };
        let all = harvest(vec![sums(0.25), sums(2.0)]);
        LightPiece { pass, photons: photons.clone(), all, direct: Some(harvest(vec![sums(1.0)])) }
    }

    fn sums(pieces: impl IntoIterator<Item = LightPiece>) -> LightSums {
        pieces.into_iter().fold(LightSums::default(), |mut all, piece| {
            assert!(all.join(LightSums::of(piece)));
            all
        })
    }

    #[test]
    fn sums_of_neighbours_are_those_of_all() {
        let whole = sums([piece(0, 0..10), piece(1, 10..20)]);
        let cut = sums([piece(0, 0..3), piece(0, 3..10), piece(1, 10..11), piece(1, 11..20)]);
        assert_eq!(cut, whole);
        let sound = |_: &Harvest, _: &Range<u64>| true;
        assert!(whole.is_of(&(0..20), 10, sound));
        for (photons, per_pass) in [(0..21, 10), (1..20, 10), (0..20, 9), (0..20, 20), (0..20, 0)] {
            assert!(!whole.is_of(&photons, per_pass, sound), "{photons:?} {per_pass}");
        }
    }

    #[test]
    fn what_does_not_follow_is_not_joined() {
        let before = sums([piece(0, 0..3)]);
        let fewer = |mut piece: LightPiece| {
            piece.all.sums.pop();
            piece
        };
        let without = |piece: LightPiece| LightPiece { direct: None, ..piece };
        for other in
            [piece(0, 4..6), piece(1, 4..6), fewer(piece(0, 3..6)), without(piece(0, 3..6))]
        {
            let mut joined = before.clone();
            assert!(!joined.join(LightSums::of(other)));
            assert_eq!(joined, before);
        }
    }

    #[test]
    fn counts_that_are_added_apart_are_those_of_all() {
        let whole = sums([piece(0, 0..10), piece(1, 10..20)]);
        let mut added = std::collections::BTreeMap::<CountsOf, Vec<u64>>::new();
        let cut = [piece(0, 0..3), piece(0, 3..10), piece(1, 10..20)].map(|piece| {
            let mut sums = LightSums::of(piece);
            for (of, counts) in sums.take_counts() {
                let own = added.entry(of).or_insert_with(|| vec![0; counts.len()]);
                own.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
            sums
        });
        let mut joined = cut.into_iter().fold(LightSums::default(), |mut all, sums| {
            assert!(all.join(sums));
            all
        });
        for (of, counts) in added {
            joined.put_counts(of, &counts);
        }
        assert_eq!(joined, whole);
    }
}
