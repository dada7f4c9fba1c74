//! `arboleda` without a command: clusters, every index and photons on a built-in scene, within a minute.

use std::path::PathBuf;

use arboleda::IndexKind;
use clap::Args;

use super::arguments::BuildArguments;
use super::arguments::values::{MOST_PHOTONS, file_ending_in, whole};
use super::cluster_picture::paint_model;
use super::inspect::{ALWAYS, describe};
use super::shoot::{ShotComparison, paint_light, print_digests, print_rows};
use crate::TimedIndex;
use crate::bench::progress::during;
use crate::bench::workload::{SAMPLE_PHOTONS, Workload};
use crate::files::output::check_writable;
use crate::photon::{Counting, ShootOptions, Shot};
use crate::report::Canvas;
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
        match (&self.picture, rows.last()) {
            (Some(path), Some(last)) => {
                during("painting", || self.picture(&model, &last.shot)?.save(path))?;
                log::info!("picture: {}", path.display());
            }
            _ => log::info!("add --picture arboleda.png for a picture"),
        }
        Ok(())
    }

    /// Paints the clusters on the left and the irradiance on the right.
    fn picture(&self, model: &Model, shot: &Shot) -> anyhow::Result<Canvas> {
        let up = UpAxis::Z.vector(model);
        let (width, height) = (820, 760);
        let [mut clusters, mut light] = [(); 2].map(|()| Canvas::new(width, height));
        let (scene, options) = (self.build.scene(model), self.build.options());
        paint_model(&mut clusters, model, &scene, &options, up)?;
        let owned = TimedIndex::build(IndexKind::Bvh, &scene, &options)?;
        paint_light(&mut light, &owned, model, shot, up);
        let mut both = Canvas::new(2 * width, height);
        both.paste(&clusters, 0, 0);
        both.paste(&light, width, 0);
        Ok(both)
    }
}
