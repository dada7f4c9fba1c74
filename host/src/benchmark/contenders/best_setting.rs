//! Each library at its best: all its settings are built, and the one that answers fastest stays.
//!
//! The best preset or instruction set depends on the scene and the processor. Our indices have no such choice: they
//! compete with their default options.

use arboleda::{Ray, Triangle};

use super::contender::Mode;
use super::{BuiltPeer, Peer, PeerError, Setting};
use crate::benchmark::harness::timing::{Turn, time};

/// Number of times that each setting answers the sample; the fastest time counts.
const PASSES: usize = 4;
/// A later setting must be faster than this share of the time of the best before: on many processors
/// some settings are the same, and noise should not choose between them.
const CLEARLY_FASTER: f64 = 0.97;

/// Builds a library's index by each of its settings and keeps the fastest on `sample`.
///
/// # Errors
/// The error of the last setting, if none could be built.
pub fn best_setting(
    peer: &Peer,
    triangles: &[Triangle],
    sample: &[Ray],
) -> Result<(&'static Setting, BuiltPeer), PeerError> {
    let mut best: Option<(f64, &Setting, BuiltPeer)> = None;
    let mut problem = None;
    for setting in peer.settings {
        let built = match setting.build(triangles) {
            Ok(built) => built,
            Err(error) => {
                problem = Some(error);
                continue;
            }
        };
        let turn = Turn { contender: &*built.contender, mode: Mode::Single, rays: sample };
        let passes = time(&[turn], PASSES, &|| {});
        let seconds = passes.into_iter().flatten().fold(f64::INFINITY, f64::min);
        if best.as_ref().is_none_or(|(fastest, ..)| seconds < fastest * CLEARLY_FASTER) {
            best = Some((seconds, setting, built));
        }
    }
    match (best, problem) {
        (Some((_, setting, built)), _) => Ok((setting, built)),
        (None, Some(error)) => Err(error),
        (None, None) => {
            Err(PeerError::Refused { library: peer.name, reason: "it has no settings".into() })
        }
    }
}
