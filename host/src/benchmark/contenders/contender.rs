//! Contender: anything that answers a slice of rays, so that it can be measured.
//!
//! A contender answers a whole slice in one call, so that its loop is compiled with its own code and
//! no indirect call is paid for each ray. It gets the rays as [`Ray`]s and fills in its own kind of
//! ray inside the loop, as any program that uses it would.

use arboleda::{Hit, Ray};

/// Built index of anyone's, on the thread that calls.
///
/// All rays begin at `t_min = 0`: half of the libraries know no other. Slices of results are as long
/// as the slices of rays.
pub trait Contender {
    /// Returns the bytes that it holds while it answers, its copy of the triangles included, where it can
    /// be found out. The application's mesh is not its own.
    fn bytes(&self) -> Option<usize>;

    /// Finds the closest hit of each ray, one ray at a time.
    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]);

    /// Tells whether anything is hit up to `t_max`, by the fastest way there is for many rays.
    fn occluded(&self, rays: &[Ray], answers: &mut [bool]);

    /// Returns the way to answer several rays together, if there is one.
    fn batch(&self) -> Option<&dyn Batch> {
        None
    }
}

/// Contender that can answer several rays together.
pub trait Batch {
    /// Finds the closest hit of each ray.
    fn closest_hits_together(&self, rays: &[Ray], hits: &mut [Hit]);
}

/// Question to a contender, and the way in which it is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Closest hits, one ray at a time.
    Single,
    /// Closest hits, several rays together.
    Batch,
    /// Occlusion: whether anything is hit, by the fastest way.
    Occluded,
}

impl Mode {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 3] = [Self::Single, Self::Batch, Self::Occluded];
}

/// Room for answers, at least one for each ray.
pub struct Answers {
    /// Answers to closest-hit rays.
    pub hits: Vec<Hit>,
    /// Answers to occlusion rays.
    pub occluded: Vec<bool>,
}

impl Answers {
    /// Makes room for the answers to `count` rays.
    pub fn room(count: usize) -> Self {
        Self { hits: vec![Hit::NONE; count], occluded: vec![false; count] }
    }
}

impl dyn Contender + '_ {
    /// Answers all rays in one mode; `false` if it has no such mode.
    pub fn answer(&self, mode: Mode, rays: &[Ray], answers: &mut Answers) -> bool {
        let hits = &mut answers.hits[..rays.len()];
        match (mode, self.batch()) {
            (Mode::Single, _) => self.closest_hits(rays, hits),
            (Mode::Batch, Some(batch)) => batch.closest_hits_together(rays, hits),
            (Mode::Batch, None) => return false,
            (Mode::Occluded, _) => self.occluded(rays, &mut answers.occluded[..rays.len()]),
        }
        true
    }
}
