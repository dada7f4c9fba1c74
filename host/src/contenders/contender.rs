//! What a library has to do to be compared.
//!
//! A contender answers a whole slice in one call, so that its loop is compiled with its own code and
//! no indirect call is paid for each ray. It gets the rays as [`Ray`]s and fills in its own kind of
//! ray inside the loop, as any program that uses it would.

use std::fmt::Display;

use arboleda::{Hit, Ray, Triangle, TriangleId};

use super::PeerError;

/// What a library found, by the place of the triangle in the scene and the parameter in lengths of the
/// ray's direction. The barycentric coordinates are not compared.
#[inline]
pub(crate) fn found(triangle: u32, t: f32) -> Hit {
    Hit { triangle: TriangleId(triangle), t, u: 0.0, v: 0.0 }
}

/// A built index of someone's, on the thread that calls.
///
/// All rays begin at `t_min = 0`: half of the libraries know no other. Slices of results are as long
/// as the slices of rays.
pub trait Contender {
    /// The bytes that it holds while it answers, its copy of the triangles included, where it can
    /// be found out. The application's mesh is not its own.
    fn bytes(&self) -> Option<usize>;

    /// The closest hit of each ray, one ray at a time.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]);

    /// Whether anything is hit up to `t_max`, by the fastest way there is for many rays.
    fn occluded(&self, rays: &[Ray], answers: &mut [bool]);

    /// The way to answer several rays together, if there is one.
    fn batch(&self) -> Option<&dyn Batch> {
        None
    }
}

/// A contender that can answer several rays together.
pub trait Batch {
    /// The closest hit of each ray.
    fn closest_hits_together(&self, rays: &[Ray], hits: &mut [Hit]);
}

/// A contender and how long it took to build.
pub struct Built<'a> {
    /// The index.
    pub contender: Box<dyn Contender + 'a>,
    /// From triangles in the form that the library wants to an index that answers; on one thread.
    pub build_seconds: f64,
}

/// One way to build a contender.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// For tables; in the words of the library.
    pub name: &'static str,
    pub(crate) build: fn(&[Triangle]) -> Result<Built<'static>, PeerError>,
}

impl Setting {
    /// Builds it.
    ///
    /// # Errors
    /// The library is not there or refuses the triangles.
    pub fn build(&self, triangles: &[Triangle]) -> Result<Built<'static>, PeerError> {
        (self.build)(triangles)
    }
}

/// A library, with those of its settings that may be the fastest.
#[derive(Clone, Copy, Debug)]
pub struct Peer {
    /// For tables and command lines.
    pub name: &'static str,
    /// Which is best depends on the scene and the processor; see [`super::best_setting`].
    pub settings: &'static [Setting],
}

/// Turns any error of a library into one of ours.
pub(crate) fn refused(library: &'static str, reason: impl Display) -> PeerError {
    PeerError::Refused { library, reason: reason.to_string() }
}
