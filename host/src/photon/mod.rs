//! Photons: emission from the lights, tracing through an index, counts for each triangle.
//!
//! ```text
//! random (seed, photon) -+-> emission -> trace <-> index             one photon
//! hemisphere, offset ----+      |          |
//!                             lanes -----> wave <-> index            as many as a batch of rays has
//!                                          stream                    all photons, on all processors
//!                                          shoot -> Shot, Digest
//! ```
//!
//! Every result is a function of the model and the options. It does not depend on the index, the threads or the
//! machine. Only `+ - * / sqrt` are used on floats.
// A loop over lanes is turned into vectors only if all that it calls is inlined, and has no branch; see `lanes`.
#![allow(clippy::inline_always, clippy::needless_bitwise_bool)]

mod balance;
mod digest;
mod emission;
#[cfg(test)]
pub(crate) mod fixtures;
pub(crate) mod hemisphere;
mod lanes;
pub(crate) mod offset;
mod random;
mod shoot;
mod shot;
mod side;
mod stream;
#[cfg(test)]
mod tests;
mod trace;
mod wave;

pub use balance::Balance;
pub use digest::Digest;
pub use emission::{Emission, Emitter};
pub use random::{PhotonRandom, philox4x32};
pub use shoot::{Counting, ShootOptions, shoot};
pub use shot::Shot;
pub use side::Side;
pub use stream::CHUNK;
pub(crate) use stream::{Visitor, stream};
pub use trace::{DEFAULT_MAX_BOUNCES, Path, PathEnd, Segment, Tracer};
