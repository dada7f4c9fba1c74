//! `shoot --part`: a range of the photons, for `arboleda merge`.

use std::path::Path;

use anyhow::ensure;
use arboleda::Scene;

use super::Shoot;
use crate::Threads;
use crate::bench::progress::photon_bar;
use crate::bench::provenance::Provenance;
use crate::commands::arguments::build_index;
use crate::commands::output::{count, say};
use crate::photon::{Job, PartFile, ShootOptions, shoot_part};
use crate::scene::Model;

impl Shoot {
    /// Shoots a range of the photons and writes what they leave behind.
    ///
    /// # Errors
    /// If the range has photons that the job does not have, the index cannot be built, or the file cannot be written.
    pub(super) fn write_part(
        &self,
        path: &Path,
        model: &Model,
        scene: &Scene<'_>,
        options: &ShootOptions,
    ) -> anyhow::Result<()> {
        let photons = self.photon_range.clone().unwrap_or(0..self.photons);
        ensure!(
            photons.end <= self.photons,
            "--photon-range ends at photon {}, but there are {} photons in all: --photons is their number in all parts",
            photons.end,
            self.photons
        );
        let build = self.build.options();
        let kind = self.index.kind(scene, &build)?;
        let name = kind.name();
        let owned = build_index(kind, scene, &build, &Threads::new(self.threads))?;
        let bar = photon_bar(photons.end - photons.start, name);
        let index = owned.index();
        let progress = |photons| bar.inc(photons);
        let part = shoot_part(model, index.as_ray_index(), options, photons.clone(), &progress);
        bar.finish_and_clear();

        let provenance = format!("{name}; {}", Provenance::gather().line());
        let file = PartFile { job: Job::new(model, options), photons: photons.clone(), provenance };
        file.write(path, &part.sums)?;
        let balance = &part.sums.balance;
        say!(
            "photons {}..{} of {}: {} rays, {} hits",
            photons.start,
            photons.end,
            count(self.photons),
            count(balance.rays),
            count(balance.hits)
        );
        log::info!("part: {}", path.display());
        Ok(())
    }
}
