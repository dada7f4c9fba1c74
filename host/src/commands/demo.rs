//! `arboleda` alone: the whole of it on a built-in scene, within a minute.

use std::path::PathBuf;

use arboleda::IndexKind;
use clap::Args;

use super::arguments::BuildArguments;
use super::inspect::{ALWAYS, describe};
use super::output::say;
use super::shoot::{Comparison, check_digests, paint_light, print_rows};
use crate::OwnedIndex;
use crate::bench::rays::{RaySet, SAMPLE_PHOTONS};
use crate::photon::{Counting, ShootOptions};
use crate::report::{Canvas, paint_clusters};
use crate::scene::{self, UpAxis};

/// The scene of the paper's figure 4(b).
const SCENE: &str = "fig4b";

#[derive(Args)]
pub struct Demo {
    /// How many photons each index shoots
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    photons: u64,
    /// The picture: clusters and cluster tree on the left, the light on the right
    #[arg(long, value_name = "FILE.png", default_value = "arboleda.png")]
    picture: PathBuf,
    #[command(flatten)]
    build: BuildArguments,
}

impl Demo {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or the picture cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        let model = scene::builtin::require(SCENE)?.with_default_light(UpAxis::Z);
        let up = UpAxis::Z.vector(&model);
        let (width, height) = (820, 760);
        let mut clusters = Canvas::new(width, height);
        describe(&model, &self.build, &ALWAYS, |index, image, cluster_of| {
            paint_clusters(&mut clusters, index, &model.triangles, image, cluster_of, up);
        })?;

        let options = ShootOptions {
            photons: self.photons,
            counting: Counting::On,
            ..ShootOptions::default()
        };
        let sample = RaySet::shoot(&model, SAMPLE_PHOTONS, options.seed)?;
        let scene = self.build.scene(&model).rays(sample.sample());
        let build = self.build.options();
        let rows = Comparison { model: &model, scene, build, options }.run(IndexKind::ALL)?;
        check_digests(&rows)?;
        print_rows(&rows);

        let mut light = Canvas::new(width, height);
        if let Some(row) = rows.last() {
            let owned = OwnedIndex::build(IndexKind::Bvh, &scene, &build)?;
            paint_light(&mut light, &owned, &model, &row.shot, up);
        }
        let mut both = Canvas::new(2 * width, height);
        both.paste(&clusters, 0, 0);
        both.paste(&light, width, 0);
        both.save(&self.picture)?;
        say!("picture: {}", self.picture.display());
        Ok(())
    }
}
