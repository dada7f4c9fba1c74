//! Scene with its lights and an index, for commands that estimate irradiance.

use std::path::PathBuf;

use anyhow::{Context, ensure};
use arboleda::IndexKind;
use clap::Args;

use crate::benchmark::harness::progress::{during, photon_bar};
use crate::benchmark::harness::workload::{SAMPLE_PHOTONS, Workload};
use crate::commands::arguments::estimator::EstimatorArguments;
use crate::commands::arguments::light::LightArguments;
use crate::commands::arguments::packed::{PackedArguments, SceneIndex};
use crate::commands::arguments::photons::PhotonArguments;
use crate::commands::arguments::{BuildArguments, IndexChoice, SceneArguments, build_index};
use crate::commands::output::{count, say};
use crate::density::{Estimator, Harvest, Light, LightField, PhotonMap, PhotonSource};
use crate::parts::{Job, JobKind};
use crate::photon::Balance;
use crate::report::four_decimals;
use crate::scene::Model;
use crate::{PackedScene, Threads};

/// Photons, estimator, lights and index of a command that estimates irradiance.
#[derive(Args)]
pub struct LightingArguments {
    #[command(flatten)]
    pub photons: PhotonArguments,
    #[command(flatten)]
    pub estimator: EstimatorArguments,
    #[command(flatten)]
    lights: LightArguments,
    #[command(flatten)]
    pub packed: PackedArguments,
    #[command(flatten)]
    index: IndexChoice,
    #[command(flatten)]
    build: BuildArguments,
}

impl LightingArguments {
    /// Lists the files that are read beside the scene and the points.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let map = self.estimator.load_map.clone();
        self.packed.inputs().into_iter().chain(map).collect()
    }
}

/// Model with its lights, and an index over its triangles.
pub struct LitScene {
    pub model: Model,
    pub index: SceneIndex,
    /// Name of the index.
    pub index_name: &'static str,
    /// Kind of the index over discs: the one that was named, else the fastest.
    pub disc_kind: IndexKind,
}

impl LitScene {
    /// Loads a scene, gives it its lights, and builds the index that was named or is estimated cheapest; or opens a packed
    /// scene.
    ///
    /// # Errors
    /// If the scene cannot be loaded or indexed.
    pub fn load(scene: &SceneArguments, lighting: &LightingArguments) -> anyhow::Result<Self> {
        let LightingArguments { photons, lights, index, build, .. } = lighting;
        if let Some(PackedScene { model, index, .. }) = lighting.packed.open()? {
            let model = lights.lit(model, scene.up);
            let (disc_kind, index_name) = (IndexKind::WideBvh, index.index().kind().name());
            return Ok(Self { index: SceneIndex::Packed(index), index_name, disc_kind, model });
        }
        let model = lights.lit(scene.load()?, scene.up);
        let sample = index.uses_rays().then(|| {
            let few = SAMPLE_PHOTONS.min(photons.photons.max(1));
            during("sampling", || Workload::of_photons(&model, few, photons.seed).ok())
        });
        let sample = sample.flatten();
        let options = build.options();
        let view = build.scene(&model).rays(sample.as_ref().map_or(&[], Workload::sample));
        let view = view.expecting(photons.photons.saturating_mul(2));
        let kind = index.kind(&view, &options)?;
        let owned = build_index(kind, &view, &options, &Threads::default())?;
        let disc_kind = index.named().unwrap_or(IndexKind::WideBvh);
        Ok(Self { index: SceneIndex::Built(owned), index_name: kind.name(), disc_kind, model })
    }

    /// Runs work with the source of the photons.
    pub fn with_source<T>(
        &self,
        lighting: &LightingArguments,
        work: impl FnOnce(&PhotonSource<'_>) -> T,
    ) -> T {
        let LightingArguments { photons, estimator, .. } = lighting;
        let index = self.index.index();
        let source =
            PhotonSource::new(&self.model, index.as_ray_index(), photons.photons, photons.seed);
        work(&PhotonSource { bounces: estimator.bounces(), ..source })
    }

    /// Makes the job of a command that estimates in the light of the source, of all its passes. `options` are what its
    /// estimates depend on beside its photons and its estimator.
    ///
    /// # Errors
    /// If there are too many photons to have numbers.
    pub fn job(
        &self,
        kind: JobKind,
        lighting: &LightingArguments,
        (source, estimator): (&PhotonSource<'_>, &Estimator),
        passes: u32,
        options: Vec<(&str, String)>,
    ) -> anyhow::Result<Job> {
        let photons = lighting.photons.photons.checked_mul(passes.into());
        let mut all = lighting.estimator.described(estimator);
        all.extend(options.into_iter().map(|(name, value)| (name.to_owned(), value)));
        Ok(Job {
            program: Job::PROGRAM.to_owned(),
            kind,
            model: *self.model.digest().as_bytes(),
            triangles: self.model.triangles.len() as u64,
            photons: photons.context("--passes times --photons is beyond 64 bits")?,
            passes,
            seed: source.seed,
            max_bounces: source.max_bounces,
            options: all,
        })
    }

    /// Prepares the light of a source, with a progress bar: from what photons left behind, from a photon map that it
    /// loads, or it shoots the photons. Saves the photon map.
    ///
    /// # Errors
    /// If the photon map cannot be made, read or written.
    pub fn field<'s>(
        &'s self,
        source: &PhotonSource<'s>,
        estimator: &Estimator,
        arguments: &EstimatorArguments,
        harvest: Option<Harvest>,
    ) -> anyhow::Result<LightField<'s>> {
        let photons = source.photons.end - source.photons.start;
        let light = match (harvest, self.load_map(arguments, photons)?) {
            (Some(harvest), _) => Light::Harvest(harvest),
            (None, Some(map)) => Light::Map(map),
            (None, None) => Light::Shot,
        };
        let bar = photon_bar(photons, "photon map");
        let progress = |photons| bar.inc(photons);
        let field = LightField::new(source.clone(), *estimator, self.disc_kind, light, &progress)?;
        bar.finish_and_clear();
        if let Some(map) = field.map() {
            self.save_map(map, arguments)?;
        }
        Ok(field)
    }

    /// Reads the photon map of `--load-map`, if it is given, for estimates by `photons` photons.
    ///
    /// # Errors
    /// If the file cannot be read, or is not a photon map of this scene. If it has another number of photons, because
    /// radii and numbers of nearest photons were chosen for `photons`.
    pub fn load_map(
        &self,
        arguments: &EstimatorArguments,
        photons: u64,
    ) -> anyhow::Result<Option<PhotonMap>> {
        let Some(path) = &arguments.load_map else { return Ok(None) };
        let map = during("reading the photon map", || PhotonMap::load(path, &self.model))?;
        let shot = map.balance().emitted;
        ensure!(
            shot == photons,
            "{} was shot with {shot} photons, not {photons}: give --photons {shot}",
            path.display()
        );
        Ok(Some(map))
    }

    /// Writes a photon map to the file of `--save-map`, if it is given.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_map(&self, map: &PhotonMap, arguments: &EstimatorArguments) -> anyhow::Result<()> {
        let Some(path) = &arguments.save_map else { return Ok(()) };
        during("writing the photon map", || map.save(path, &self.model))?;
        log::info!("photon map: {}", path.display());
        Ok(())
    }
}

/// Prints where the light went: every photon is absorbed, escapes, or is given up.
pub fn print_balance(balance: &Balance) {
    let watts = |photons: u64| four_decimals(photons as f64 * balance.photon_flux());
    say!(
        "{} photons of {:.4e} W, {} rays, {} hits",
        count(balance.emitted),
        balance.photon_flux(),
        count(balance.rays),
        count(balance.hits)
    );
    say!(
        "energy: {} W emitted = {} absorbed + {} escaped + {} cut off + {} refused",
        watts(balance.emitted),
        watts(balance.absorbed),
        watts(balance.escaped),
        watts(balance.cut_off),
        watts(balance.refused)
    );
    if balance.emitted == 0 {
        log::warn!("no photons: the scene is dark");
    }
}
