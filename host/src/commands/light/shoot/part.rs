//! `shoot` in parts: a range of the photons for `arboleda merge`, a checkpoint, or several processes.

use anyhow::ensure;
use arboleda::Scene;

use super::{Shoot, write_flux};
use crate::commands::arguments::build_index;
use crate::commands::arguments::packed::SceneIndex;
use crate::commands::light::lit_scene::print_balance;
use crate::commands::light::parts::{PartWork, Team, print_digest};
use crate::parts::{Job, PartSums};
use crate::photon::{ShootOptions, shoot_range};
use crate::scene::Model;
use crate::{PackedIndex, Threads};

impl Shoot {
    /// Shoots a range of the photons with a team, and writes what they leave behind.
    ///
    /// # Errors
    /// If the range has photons that the job does not have, an output needs the photons once more, the index cannot be
    /// built, or a file cannot be written.
    pub(super) fn in_parts(
        &self,
        team: Team,
        model: &Model,
        scene: &Scene<'_>,
        packed: Option<PackedIndex>,
        options: &ShootOptions,
    ) -> anyhow::Result<()> {
        let again = [&self.triangles, &self.mesh_ply, &self.photons_ply, &self.picture];
        ensure!(
            again.iter().all(|path| path.is_none()) && !self.counters,
            "--out and --part are for several processes; --triangles, --mesh-ply, --photons-ply, --picture and \
             --counters are for one"
        );
        let index = if let Some(packed) = packed {
            SceneIndex::Packed(packed)
        } else {
            let (build, threads) = (self.build.options(), Threads::new(self.threads));
            let kind = self.index.kind(scene, &build)?;
            SceneIndex::Built(build_index(kind, scene, &build, &threads)?)
        };
        let index = index.index();
        let name = index.kind().name();
        let shoot = |photons, progress: &(dyn Fn(u64) + Sync)| {
            let sums = shoot_range(model, index.as_ray_index(), options, photons, &progress);
            Ok(PartSums::Shot(sums))
        };
        let job = Job::of_shot(model, options);
        let work = PartWork { job, arguments: Vec::new(), index: name, shoot: &shoot };
        let Some(merged) = work.run(&self.part, team)? else { return Ok(()) };
        if let PartSums::Shot(sums) = merged.all.sums {
            if let Some(path) = &self.out {
                write_flux(path, sums.hits.iter().copied(), sums.balance.photon_flux())?;
            }
            print_balance(&sums.balance);
            print_digest(sums.balance.emitted, sums.digest(), name);
        }
        Ok(())
    }
}
