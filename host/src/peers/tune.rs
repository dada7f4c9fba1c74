//! Each library at its best: all its settings are built, and the one that answers fastest stays.
//!
//! Which preset or instruction set is best depends on the scene and the processor. Ours have no such
//! choice to make: they compete with their default options.

use arboleda::{Hit, Ray, Triangle};
use cpu_time::ThreadTime;

use super::PeerError;
use super::contender::{Built, Peer};

/// How often each setting answers the sample; the fastest time counts.
const PASSES: usize = 4;
/// A later setting must be faster than this share of the time of the best before: on many processors
/// some settings are the same, and noise should not choose between them.
const CLEARLY_FASTER: f64 = 0.97;
/// How often what takes part is built at least and at most; the fastest build counts, since the first also pays for
/// pages and libraries touched for the first time.
const BUILDS: [usize; 2] = [3, 30];
/// More often than at least as long as all builds together take less: short ones are the most disturbed.
const SECONDS: f64 = 0.25;
/// From so many triangles on that share is small, and a build long: one is enough.
const LARGE: usize = 500_000;

/// Builds something several times and keeps the one that took the shortest by `seconds`.
///
/// # Errors
/// The first error of `build`.
pub fn fastest_build<B, E>(
    triangle_count: usize,
    build: impl Fn() -> Result<B, E>,
    seconds: impl Fn(&B) -> f64,
) -> Result<B, E> {
    let mut fastest = build()?;
    let (mut builds, mut total) = (1, seconds(&fastest));
    let [least, most] = if triangle_count < LARGE { BUILDS } else { [1; 2] };
    while builds < least || builds < most && total < SECONDS {
        let next = build()?;
        (builds, total) = (builds + 1, total + seconds(&next));
        if seconds(&next) < seconds(&fastest) {
            fastest = next;
        }
    }
    Ok(fastest)
}

/// Builds a library's index by each of its settings and keeps the fastest on `sample`.
///
/// # Errors
/// That of the last setting, if none could be built.
pub fn best(
    peer: &Peer,
    triangles: &[Triangle],
    sample: &[Ray],
) -> Result<(&'static str, Built<'static>), PeerError> {
    let mut hits = vec![Hit::NONE; sample.len()];
    let mut best: Option<(f64, &str, Built<'static>)> = None;
    let mut problem = None;
    for setting in peer.settings {
        let build = || setting.build(triangles);
        let built = match fastest_build(triangles.len(), build, |built| built.build_seconds) {
            Ok(built) => built,
            Err(error) => {
                problem = Some(error);
                continue;
            }
        };
        let seconds = (0..PASSES)
            .map(|_| {
                let start = ThreadTime::now();
                built.contender.closest_hits(sample, &mut hits);
                start.elapsed().as_secs_f64()
            })
            .fold(f64::INFINITY, f64::min);
        if best.as_ref().is_none_or(|(fastest, ..)| seconds < fastest * CLEARLY_FASTER) {
            best = Some((seconds, setting.name, built));
        }
    }
    match (best, problem) {
        (Some((_, name, built)), _) => Ok((name, built)),
        (None, Some(error)) => Err(error),
        (None, None) => {
            Err(PeerError::Refused { library: peer.name, reason: "it has no settings".into() })
        }
    }
}
