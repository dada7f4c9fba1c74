//! `arboleda shoot`: photons through one index, or the same photons through each.

mod comparison;
mod flux_file;
mod part;
mod surface_files;

use std::path::PathBuf;

use anyhow::Context;
use arboleda::{AnyIndex, IndexKind, Scene, Vec3};
use clap::Args;

use crate::benchmark::harness::progress::{during, photon_bar};
use crate::benchmark::harness::workload::{SAMPLE_PHOTONS, Workload};
use crate::commands::arguments::light::LightArguments;
use crate::commands::arguments::packed::{PackedArguments, SceneIndex};
use crate::commands::arguments::part::PartArguments;
use crate::commands::arguments::values::{MOST_PHOTONS, file_ending_in, threads, whole};
use crate::commands::arguments::{BuildArguments, IndexChoice, SceneArguments};
use crate::commands::light::parts::Team;
use crate::commands::output::{count, duration, say};
use crate::density::{PhotonSource, TriangleIrradiance, TriangleLight, first_hits};
use crate::files::output::check_outputs;
use crate::photon::{Counting, Emitter, ShootOptions, Shot};
use crate::report::{Canvas, paint_irradiance};
use crate::scene::Model;
use crate::{PackedScene, Threads, TimedIndex};
pub use comparison::{ShotComparison, print_digests, print_rows};
pub use flux_file::write_flux;
use surface_files::{write_mesh, write_photons, write_triangles};

/// Shoot photons from the lights of a scene through one index, or through each
///
/// OUT has one row for each triangle, in the order of ids. Ids count faces in file order after triangulation. The .npy
/// file is a structured array
/// [('front_photons','<u8'),('back_photons','<u8'),('front_flux','<f8'),('back_flux','<f8')]; the .csv file has the
/// column triangle, then the same columns. Every hit of a photon counts, whether the triangle absorbs or reflects it.
/// Flux is in watts. The front of a triangle is the side from which its corners, in the order of the file, are seen
/// counter-clockwise.
#[derive(Args)]
// The help names columns as the file does, not as code.
#[allow(clippy::doc_markdown)]
pub struct Shoot {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    packed: PackedArguments,
    #[command(flatten)]
    index: IndexChoice,
    /// Number of photons: 1000000, 1_000_000, 1e6 or 1M
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = whole::<u64>(1..=MOST_PHOTONS))]
    photons: u64,
    /// Number of threads: 1 to 256, or to the number of processors if that is larger [default: one on each processor]
    #[arg(long, value_name = "K", value_parser = threads())]
    threads: Option<usize>,
    /// Another seed gives other photons
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    lights: LightArguments,
    /// Also count the nodes visited and the triangles tested
    #[arg(long, conflicts_with_all = ["part", "checkpoint"])]
    counters: bool,
    /// Write the photons and the flux that each side of each triangle received
    #[arg(long, value_name = "OUT.npy|csv", value_parser = file_ending_in(&["npy", "csv"]),
        conflicts_with = "part")]
    out: Option<PathBuf>,
    /// Write the irradiance of each side of each triangle, in W/m2 of red, green and blue, with its standard error
    #[arg(long, value_name = "OUT.npy|csv", value_parser = file_ending_in(&["npy", "csv"]),
        conflicts_with_all = ["part", "checkpoint"])]
    triangles: Option<PathBuf>,
    /// Write the triangles with their irradiance as a mesh
    #[arg(long, value_name = "OUT.ply", value_parser = file_ending_in(&["ply"]), conflicts_with_all = ["part", "checkpoint"])]
    mesh_ply: Option<PathBuf>,
    /// Write where the first photons fell, as points
    #[arg(long, value_name = "OUT.ply", value_parser = file_ending_in(&["ply"]), conflicts_with_all = ["part", "checkpoint"])]
    photons_ply: Option<PathBuf>,
    /// Most points of `--photons-ply`
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = whole::<usize>(1..=100_000_000),
        requires = "photons_ply")]
    ply_limit: usize,
    /// Write a picture of the light that arrived
    #[arg(long, value_name = "FILE.png", value_parser = file_ending_in(&["png"]), conflicts_with_all = ["part", "checkpoint"])]
    picture: Option<PathBuf>,
    #[command(flatten)]
    part: PartArguments,
    #[command(flatten)]
    build: BuildArguments,
}

impl Shoot {
    /// Runs the command with a team.
    ///
    /// # Errors
    /// If the scene cannot be loaded, an output cannot be written, or two indices do not agree.
    pub fn run(&self, team: Team) -> anyhow::Result<()> {
        let files = [
            &self.out,
            &self.picture,
            &self.triangles,
            &self.mesh_ply,
            &self.photons_ply,
            &self.part.part,
            &self.part.checkpoint,
        ];
        let inputs = [self.scene.inputs()?, self.packed.inputs()].concat();
        check_outputs(files.into_iter().flatten(), &inputs)?;
        self.part.check()?;
        let (model, packed) = match self.packed.open()? {
            Some(PackedScene { model, index, .. }) => (model, Some(index)),
            None => (self.scene.load()?, None),
        };
        let model = self.lights.lit(model, self.scene.up);
        say!(
            "{}: {} triangles, {} photons",
            model.name,
            count(model.triangles.len() as u64),
            count(self.photons)
        );
        let options = ShootOptions {
            photons: self.photons,
            seed: self.seed,
            threads: self.threads,
            counting: if self.counters { Counting::On } else { Counting::Off },
            ..ShootOptions::default()
        };
        // A scene that emits no photons gives no sample; the selection then sees the triangles only.
        let sample = (packed.is_none() && self.index.uses_rays()).then(|| {
            let photons = SAMPLE_PHOTONS.min(self.photons);
            during("sampling", || Workload::of_photons(&model, photons, self.seed).ok())
        });
        let sample = sample.flatten();
        let scene = self.build.scene(&model).rays(sample.as_ref().map_or(&[], Workload::sample));
        // A photon's first ray and, with the usual reflectances, one bounce.
        let photons =
            self.part.photon_range.as_ref().map_or(self.photons, |range| range.end - range.start);
        let scene = scene.expecting(photons.saturating_mul(2));
        if self.part.in_parts(team) {
            return self.in_parts(team, &model, &scene, packed, &options);
        }
        let comparison =
            ShotComparison { model: &model, scene, build: self.build.options(), options };
        let rows = match &packed {
            Some(packed) => vec![comparison.through(&packed.index(), &comparison.options)],
            None => comparison.run(&self.index.kinds(&scene, &self.build.options())?)?,
        };
        print_rows(&rows);
        print_digests(&rows)?;
        let last = rows.last().context("no index was named")?;
        let shot = rows.iter().map(|row| &row.shot).max_by_key(|shot| shot.balance.emitted);
        summarise(shot.unwrap_or(&last.shot));

        let shot = shot.unwrap_or(&last.shot);
        if let Some(path) = &self.out {
            let counts = shot.hit_counts.iter().zip(&shot.front_hit_counts);
            let hits = counts.map(|(both, &front)| [front, both - front]);
            write_flux(path, hits, shot.balance.photon_flux())?;
        }
        let index = || match packed {
            Some(packed) => Ok(SceneIndex::Packed(packed)),
            None => self.build_again(last.kind, &scene),
        };
        self.write_pictures(&model, shot, index)
    }
}

impl Shoot {
    /// Builds an index once more, for work after the comparison. No result depends on its kind, and the linear scan would
    /// be slow.
    fn build_again(&self, kind: IndexKind, scene: &Scene<'_>) -> anyhow::Result<SceneIndex> {
        let kind = if kind == IndexKind::Linear { IndexKind::Bvh } else { kind };
        let (options, threads) = (self.build.options(), Threads::new(self.threads));
        Ok(SceneIndex::Built(TimedIndex::build_with(kind, scene, &options, &threads)?))
    }

    /// Writes the files of the light on surfaces, and the picture, if one is named. `index` makes the index.
    fn write_pictures(
        &self,
        model: &Model,
        shot: &Shot,
        index: impl FnOnce() -> anyhow::Result<SceneIndex>,
    ) -> anyhow::Result<()> {
        let asked = [&self.triangles, &self.mesh_ply, &self.photons_ply, &self.picture];
        if asked.into_iter().flatten().next().is_none() {
            return Ok(());
        }
        let index = during("the index for pictures", index)?;
        let index = index.index();
        self.write_surfaces(model, &index)?;
        if let Some(path) = &self.picture {
            let mut canvas = Canvas::new(1280, 900);
            let up = self.scene.up.vector(model);
            during("painting", || {
                paint_light(&mut canvas, &index, model, shot, up);
                canvas.save(path)
            })?;
            log::info!("picture: {}", path.display());
        }
        Ok(())
    }

    /// Writes the files of the light on surfaces. The photons are shot again, with their colours.
    fn write_surfaces(&self, model: &Model, index: &AnyIndex<'_>) -> anyhow::Result<()> {
        let source = PhotonSource::new(model, index.as_ray_index(), self.photons, self.seed);
        if let Some(path) = &self.photons_ply {
            let hits = first_hits(&source, self.ply_limit);
            write_photons(path, &hits, &self.comments(model, &source))?;
            log::info!("{} hits of photons: {}", count(hits.len() as u64), path.display());
        }
        if self.triangles.is_none() && self.mesh_ply.is_none() {
            return Ok(());
        }
        let bar = photon_bar(self.photons, "irradiance");
        let light = TriangleLight::shoot(&source, &|photons| bar.inc(photons));
        bar.finish_and_clear();
        let lights: Vec<TriangleIrradiance> = light.irradiance(model).collect();
        if let Some(path) = &self.triangles {
            write_triangles(path, &lights)?;
            log::info!("irradiance of each triangle: {}", path.display());
        }
        if let Some(path) = &self.mesh_ply {
            write_mesh(path, model, &lights, &self.comments(model, &source))?;
            log::info!("mesh with irradiance: {}", path.display());
        }
        Ok(())
    }

    /// Lists the comments of a PLY file.
    fn comments(&self, model: &Model, source: &PhotonSource<'_>) -> Vec<String> {
        let flux = Emitter::of(model).total_flux() / self.photons as f64;
        let [x, y, z] = model.origin;
        vec![
            format!("scene {}", model.name),
            format!("photons {}", self.photons),
            format!("seed {}", source.seed),
            format!("photon flux {flux:e} W"),
            format!("origin {x} {y} {z}: add it to positions to get the file's coordinates"),
        ]
    }
}

/// Paints the irradiance of the model's triangles by a shot.
fn paint_light(canvas: &mut Canvas, index: &AnyIndex<'_>, model: &Model, shot: &Shot, up: Vec3) {
    let irradiance: Vec<f64> = (0..)
        .zip(&model.triangles)
        .map(|(id, triangle)| shot.irradiance(arboleda::TriangleId(id), triangle))
        .collect();
    let index = index.as_ray_index();
    let title = format!(
        "{}: irradiance by {} photons, {} W",
        model.name,
        count(shot.balance.emitted),
        shot.balance.total_flux
    );
    paint_irradiance(canvas, index, &model.triangles, &model.bounds(), &irradiance, up, &title);
}

fn summarise(shot: &Shot) {
    let balance = &shot.balance;
    say!(
        "{} rays, {} hits, {} absorbed, {} escaped, {} refused, {} cut off; {} on {} thread{}",
        count(balance.rays),
        count(balance.hits),
        count(balance.absorbed),
        count(balance.escaped),
        count(balance.refused),
        count(balance.cut_off),
        duration(shot.seconds),
        shot.thread_count,
        if shot.thread_count == 1 { "" } else { "s" },
    );
}
