//! Libraries of other people, and the settings in which each is tried.

use std::fmt::Display;

use arboleda::{Hit, Triangle, TriangleId};

use super::contender::Contender;
use super::error::PeerError;

/// Returns what a library found, by the place of the triangle in the scene and the parameter in lengths of the
/// ray's direction. The barycentric coordinates are not compared.
#[inline]
pub fn found(triangle: u32, t: f32) -> Hit {
    Hit { triangle: TriangleId(triangle), t, u: 0.0, v: 0.0 }
}

/// Index of a library, and how long it took to build.
pub struct BuiltPeer {
    /// The index.
    pub contender: Box<dyn Contender>,
    /// From triangles in the form that the library wants to an index that answers; on one thread.
    pub build_seconds: f64,
}

/// One way to build a library's index.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// For tables; in the words of the library.
    pub name: &'static str,
    pub(super) build: fn(&[Triangle]) -> Result<BuiltPeer, PeerError>,
}

impl Setting {
    /// Builds the index.
    ///
    /// # Errors
    /// The library is not there or refuses the triangles.
    pub fn build(&self, triangles: &[Triangle]) -> Result<BuiltPeer, PeerError> {
        (self.build)(triangles)
    }
}

/// Library, with those of its settings that may be the fastest.
#[derive(Clone, Copy, Debug)]
pub struct Peer {
    /// Name in tables and on command lines.
    pub name: &'static str,
    /// Settings; the best depends on the scene and the processor, see [`super::best_setting`].
    pub settings: &'static [Setting],
}

/// Turns any error of a library into one of ours.
pub fn refused(library: &'static str, reason: impl Display) -> PeerError {
    PeerError::Refused { library, reason: reason.to_string() }
}
