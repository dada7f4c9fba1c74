//! Snapshot: a picture with automatic options, as `arboleda render` makes it without any.

use arboleda::{IndexKind, Options, Vec3};

use super::film::Film;
use super::passes::{Passes, PictureLight, Progress, Summary, render};
use super::samples::Sampling;
use super::viewpoint::viewpoint;
use crate::TimedIndex;
use crate::density::{
    Domain, Estimator, Kernel, PhotonSource, TangentPlane, automatic_radius, wanted_photons,
};
use crate::report::Camera;
use crate::scene::Model;

/// Picture with automatic options: by DETP, in the visible part of discs of the automatic radius.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot {
    /// Number of photons.
    pub photons: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Direction that points up.
    pub up: Vec3,
    /// Width and height in pixels.
    pub size: (u32, u32),
}

/// Film of a snapshot, and how it was made.
pub struct Exposed {
    /// The film.
    pub film: Film,
    /// Work and outcome.
    pub summary: Summary,
    /// Radius of the discs.
    pub radius: f32,
}

impl Snapshot {
    /// Renders a model in the caller's pool. Without a camera, the [`viewpoint`] is chosen.
    ///
    /// # Errors
    /// If no index of the model, or of the discs, can be built.
    pub fn take(&self, model: &Model, camera: Option<Camera>) -> anyhow::Result<Exposed> {
        let kind = IndexKind::WideBvh;
        let built = TimedIndex::build(kind, &model.scene(), &Options::default())?;
        let index = built.index();
        let source = PhotonSource::new(model, index.as_ray_index(), self.photons, self.seed);
        let radius = automatic_radius(&source, wanted_photons(self.photons) as f64);
        let (kernel, domain) = (Kernel::Epanechnikov, Domain::Visible);
        let plane = TangentPlane { radius, beyond: 0.0, kernel, domain };
        let passes = Passes {
            camera: camera.unwrap_or_else(|| viewpoint(&source, self.up, self.size)),
            source,
            estimator: Estimator::TangentPlane(plane),
            disc_kind: kind,
            light: PictureLight::Shot,
            sampling: Sampling::of_radius(2, radius),
            final_gather: 0,
            passes: 1,
        };
        let (film, summary) = render(passes, &Silent)?;
        Ok(Exposed { film, summary, radius })
    }
}

/// Listener that says nothing.
struct Silent;

impl Progress for Silent {
    fn photons(&self, _: u64) {}
    fn estimates(&self, _: u64) {}
    fn pass(&self, _: u32, _: &Film, _: &Summary) -> anyhow::Result<()> {
        Ok(())
    }
}
