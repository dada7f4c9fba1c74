//! `arboleda` without a command: clusters, every index and photons on a built-in scene, within a minute.

use std::path::PathBuf;

use arboleda::IndexKind;
use clap::Args;

use super::arguments::BuildArguments;
use super::arguments::values::{MOST_PHOTONS, file_ending_in, whole};
use super::inspect::{ALWAYS, describe};
use super::light::shoot::{ShotComparison, print_digests, print_rows};
use super::output::cluster_picture::paint_model;
use super::output::count;
use crate::benchmark::harness::progress::during;
use crate::benchmark::harness::workload::{SAMPLE_PHOTONS, Workload};
use crate::files::output::check_writable;
use crate::photon::{Counting, ShootOptions};
use crate::render::{Exposed, Look, Snapshot, paint};
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
        let size = (width, height);
        let snapshot =
            Snapshot { photons: self.photons, seed: ShootOptions::default().seed, up, size };
        let camera = Camera::looking_at(&model.bounds(), up, width, height);
        let Exposed { film, summary, .. } = snapshot.take(model, Some(camera))?;
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
