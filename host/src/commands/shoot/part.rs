//! `shoot --part`: a range of the photons, for `arboleda merge`.

use arboleda::Scene;

use super::Shoot;
use crate::Threads;
use crate::commands::arguments::build_index;
use crate::commands::parts::PartWork;
use crate::parts::{Job, PartSums};
use crate::photon::{ShootOptions, shoot_range};
use crate::scene::Model;

impl Shoot {
    /// Shoots a range of the photons and writes what they leave behind.
    ///
    /// # Errors
    /// If the range has photons that the job does not have, the index cannot be built, or the file cannot be written.
    pub(super) fn write_part(
        &self,
        model: &Model,
        scene: &Scene<'_>,
        options: &ShootOptions,
    ) -> anyhow::Result<()> {
        let build = self.build.options();
        let kind = self.index.kind(scene, &build)?;
        let owned = build_index(kind, scene, &build, &Threads::new(self.threads))?;
        let index = owned.index();
        let shoot = |photons, progress: &(dyn Fn(u64) + Sync)| {
            let sums = shoot_range(model, index.as_ray_index(), options, photons, &progress);
            Ok(PartSums::Shot(sums))
        };
        let job = Job::of_shot(model, options);
        let work = PartWork { job, arguments: Vec::new(), index: kind.name(), shoot: &shoot };
        work.write_part(&self.part)
    }
}
