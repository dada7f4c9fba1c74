//! Photons: from the lights, through an index, to counts per triangle.
//!
//! ```text
//! random (seed, photon) -+-> emission -> trace <-> an index          (one photon)
//! hemisphere, offset ----+                 |
//!                                        shoot -> Shot, Digest       (many, on all processors)
//! ```
//!
//! Every number is a function of the model and the options: not of the index, the threads or the
//! machine. Only `+ - * / sqrt` are used on floats.

mod digest;
mod emission;
#[cfg(test)]
mod fixtures;
mod hemisphere;
mod offset;
mod random;
mod shoot;
mod shot;
mod side;
#[cfg(test)]
mod tests;
mod trace;
mod vector;

pub use digest::Digest;
pub use emission::{Emission, Emitter};
pub use random::{PhotonRandom, philox4x32};
pub use shoot::{CHUNK, Counting, ShootOptions, shoot};
pub use shot::Shot;
pub use side::Side;
pub use trace::{DEFAULT_MAX_BOUNCES, Path, PathEnd, Segment, Tracer};
pub(crate) use vector::Vector64;
