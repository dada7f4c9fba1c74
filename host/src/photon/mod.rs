//! Photons: emission from the lights, tracing through an index, counts for each triangle.
//!
//! ```text
//! random (seed, photon) -+-> emission -> trace <-> index             one photon
//! surface ---------------+      |          |
//!                             lanes -----> wave <-> index            as many as a batch of rays has
//!                                          stream                    all photons, on all processors
//!                                          shot -> Shot, Digest
//! ```
//!
//! Every result but times and counters is a function of the model and the options. It does not depend on the index, the
//! threads or the machine. Only `+ - * / sqrt` are used on floats.
// A loop over lanes is turned into vectors only if all that it calls is inlined, and has no branch; see `lanes`.
#![allow(clippy::inline_always, clippy::needless_bitwise_bool)]

mod emission;
#[cfg(test)]
pub(crate) mod fixtures;
mod lanes;
mod random;
mod shot;
mod stream;
pub(crate) mod surface;
#[cfg(test)]
mod tests;
mod trace;
mod wave;

pub use emission::{Emission, Emitter};
pub use random::{PhotonRandom, philox4x32};
pub use shot::{Balance, Counting, Digest, RangeSums, ShootOptions, Shot, shoot, shoot_range};
pub use stream::CHUNK;
pub(crate) use stream::{Visitor, stream};
pub use surface::Side;
pub use trace::{DEFAULT_MAX_BOUNCES, Path, PathEnd, Segment, Tracer};
