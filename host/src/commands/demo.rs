//! `arboleda` without a command: clusters, every index and photons on a built-in scene, within a minute.

use std::path::PathBuf;

use arboleda::IndexKind;
use clap::Args;

use super::arguments::BuildArguments;
use super::arguments::values::{MOST_PHOTONS, file_ending_in, whole};
use super::cluster_picture::paint_model;
use super::inspect::{ALWAYS, describe};
use super::output::count;
use super::shoot::{ShotComparison, print_digests, print_rows};
use crate::TimedIndex;
use crate::bench::progress::during;
use crate::bench::workload::{SAMPLE_PHOTONS, Workload};
use crate::density::{
    Bounces, Domain, Estimator, Kernel, PhotonSource, TangentPlane, automatic_radius,
    wanted_photons,
};
use crate::files::output::check_writable;
use crate::photon::{Counting, DEFAULT_MAX_BOUNCES, ShootOptions};
use crate::render::{Film, Look, Passes, Progress, Sampling, Summary, paint, render};
use crate::report::{Camera, Canvas, Colour};
use crate::scene::{self, Model, UpAxis};

/// The scene of the paper's figure 4(b).
const SCENE: &str = "fig4b";

#[derive(Args)]
pub struct Demo {
    /// Number of photons that each index shoots
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = whole::<u64>(1..=MOST_PHOTONS))]
    photons: u64,
    /// Write a picture: clusters and cluster tree on the left, the light on the right
    #[arg(long, value_name = "FILE.png", value_parser = file_ending_in(&["png"]))]
    picture: Option<PathBuf>,
    #[command(flatten)]
    build: BuildArguments,
}

impl Demo {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or the picture cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        if let Some(path) = &self.picture {
            check_writable(path)?;
        }
        let model = scene::builtin::require(SCENE)?.with_default_light(UpAxis::Z);
        describe(&model, &self.build, &ALWAYS)?;

        let options = ShootOptions {
            photons: self.photons,
            counting: Counting::On,
            ..ShootOptions::default()
        };
        let sample = Workload::of_photons(&model, SAMPLE_PHOTONS, options.seed)?;
        let scene = self.build.scene(&model).rays(sample.sample());
        let build = self.build.options();
        let rows = ShotComparison { model: &model, scene, build, options }.run(IndexKind::ALL)?;
        print_rows(&rows);
        print_digests(&rows)?;
        if let Some(path) = &self.picture {
            during("painting", || self.picture(&model)?.save(path))?;
            log::info!("picture: {}", path.display());
        } else {
            log::info!("add --picture arboleda.png for a picture");
        }
        Ok(())
    }

    /// Paints the clusters on the left, and renders the light of the photons on the right.
    fn picture(&self, model: &Model) -> anyhow::Result<Canvas> {
        let up = UpAxis::Z.vector(model);
        let (width, height) = (820, 760);
        let mut clusters = Canvas::new(width, height);
        let (scene, options) = (self.build.scene(model), self.build.options());
        paint_model(&mut clusters, model, &scene, &options, up)?;
        let owned = TimedIndex::build(IndexKind::WideBvh, &scene, &options)?;
        let index = owned.index();
        let source = PhotonSource {
            model,
            index: index.as_ray_index(),
            photons: 0..self.photons,
            seed: ShootOptions::default().seed,
            max_bounces: DEFAULT_MAX_BOUNCES,
            bounces: Bounces::All,
        };
        let radius = automatic_radius(&source, wanted_photons(self.photons) as f64);
        let (kernel, domain) = (Kernel::Epanechnikov, Domain::Visible);
        let passes = Passes {
            source,
            estimator: Estimator::TangentPlane(TangentPlane {
                radius,
                beyond: 0.0,
                kernel,
                domain,
            }),
            disc_kind: IndexKind::WideBvh,
            map: None,
            camera: Camera::looking_at(&model.bounds(), up, width, height),
            sampling: Sampling { side: 2, merged_within: 0.25 * radius },
            passes: 1,
        };
        let (film, summary) = render(passes, &Silent)?;
        let mut light = paint(&film, &Look::default());
        let (photons, watts) = (count(self.photons), summary.balance.total_flux);
        let title = format!("{SCENE}: the light of {photons} photons, {watts} W");
        light.text((10, 10), &title, Colour::PAPER, Colour(0.0, 0.0, 0.0));
        let mut both = Canvas::new(2 * width, height);
        both.paste(&clusters, 0, 0);
        both.paste(&light, width, 0);
        Ok(both)
    }
}

/// Listener that says nothing: the picture takes seconds.
struct Silent;

impl Progress for Silent {
    fn photons(&self, _: u64) {}
    fn estimates(&self, _: u64) {}
    fn pass(&self, _: u32, _: &Film, _: &Summary) -> anyhow::Result<()> {
        Ok(())
    }
}
