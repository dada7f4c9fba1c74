//! `arboleda shoot`: photons through one index, or the same photons through each.

use std::path::PathBuf;

use anyhow::{Context, ensure};
use arboleda::{IndexKind, Options, Scene, Vec3};
use clap::Args;

use super::arguments::{BuildArguments, IndexChoice, SceneArguments};
use super::output::{bytes, count, duration, photon_bar, say, table};
use crate::bench::rays::{RaySet, SAMPLE_PHOTONS};
use crate::photon::{Counting, Digest, ShootOptions, Shot, shoot};
use crate::report::{Canvas, paint_irradiance};
use crate::scene::{AreaLight, Model};
use crate::{OwnedIndex, Threads};

/// With `--index all`, the linear scan answers so many photons only, and the others as many again.
pub const LINEAR_PHOTONS: u64 = 256;

#[derive(Args)]
pub struct Shoot {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    index: IndexChoice,
    /// How many photons
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    photons: u64,
    /// Threads [default: one on each processor]
    #[arg(long, value_name = "K")]
    threads: Option<usize>,
    /// Another seed gives other photons
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// An area light instead of the scene's: a corner, two edges, and the flux in watts; it shines to the
    /// side of the cross product of the edges. May be given several times;
    /// in the coordinates of the scene's file, also with `--origin`
    #[arg(long, value_name = "CX,CY,CZ,UX,UY,UZ,VX,VY,VZ,FLUX", value_parser = light, allow_hyphen_values = true)]
    light: Vec<GivenLight>,
    /// Count nodes visited and triangle tests, too
    #[arg(long)]
    counters: bool,
    /// Write a picture of the light that arrived
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    build: BuildArguments,
}

/// A light as it was given, in the coordinates of the scene's file.
#[derive(Clone, Copy)]
struct GivenLight([f64; 10]);

fn light(text: &str) -> Result<GivenLight, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let numbers = numbers.map_err(|error| format!("not a number: {error}"))?;
    <[f64; 10]>::try_from(numbers)
        .map(GivenLight)
        .map_err(|numbers| format!("ten numbers are needed, {} were given", numbers.len()))
}

impl GivenLight {
    /// The light, its corner relative to the scene's origin.
    fn place(self, origin: [f64; 3]) -> AreaLight {
        let at = |first: usize| [0, 1, 2].map(|axis| self.0[first + axis]);
        let rounded = |point: [f64; 3]| Vec3::from_array(point.map(|x| x as f32));
        let corner = at(0);
        AreaLight {
            corner: rounded([0, 1, 2].map(|axis| corner[axis] - origin[axis])),
            edge_u: rounded(at(3)),
            edge_v: rounded(at(6)),
            flux: self.0[9] as f32,
        }
    }
}

impl Shoot {
    /// Runs the command.
    ///
    /// # Errors
    /// If the scene cannot be loaded, or two indices do not agree.
    pub fn run(&self) -> anyhow::Result<()> {
        let mut model = self.scene.load()?;
        if !self.light.is_empty() {
            model.lights = self.light.iter().map(|light| light.place(model.origin)).collect();
        }
        let model = model.with_default_light(self.scene.up);
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
        // Without light there are no rays, and nothing to go by but the scene.
        let sample = self
            .index
            .goes_by_rays()
            .then(|| RaySet::shoot(&model, SAMPLE_PHOTONS.min(self.photons), self.seed).ok());
        let sample = sample.flatten();
        let scene = self.build.scene(&model).rays(sample.as_ref().map_or(&[], RaySet::sample));
        // A photon's first ray and, with the usual reflectances, one bounce.
        let scene = scene.expecting(self.photons.saturating_mul(2));
        let kinds = self.index.kinds(&scene, &self.build.options())?;
        let comparison = Comparison { model: &model, scene, build: self.build.options(), options };
        let rows = comparison.run(&kinds)?;
        check_digests(&rows)?;
        print_rows(&rows);
        let last = rows.last().context("no index was named")?;
        let shot = rows.iter().map(|row| &row.shot).max_by_key(|shot| shot.emitted_photons);
        summarise(shot.unwrap_or(&last.shot));

        if let Some(path) = &self.picture {
            let owned = OwnedIndex::build(
                IndexKind::Bvh,
                &self.build.scene(&model),
                &self.build.options(),
            )?;
            let mut canvas = Canvas::new(1280, 900);
            let shot = shot.unwrap_or(&last.shot);
            paint_light(&mut canvas, &owned, &model, shot, self.scene.up.vector(&model));
            canvas.save(path)?;
            say!("picture: {}", path.display());
        }
        Ok(())
    }
}

/// Paints the light of a shot on the model's triangles.
pub fn paint_light(canvas: &mut Canvas, owned: &OwnedIndex, model: &Model, shot: &Shot, up: Vec3) {
    let irradiance: Vec<f64> = (0..)
        .zip(&model.triangles)
        .map(|(id, triangle)| shot.irradiance(arboleda::TriangleId(id), triangle))
        .collect();
    let index = owned.index();
    let index = index.as_ray_index();
    paint_irradiance(canvas, index, &model.triangles, &model.bounds(), &irradiance, up);
}

/// What one index did.
pub struct Row {
    /// Which index.
    pub kind: IndexKind,
    /// How many clusters it works on; 1 for a simple one.
    pub clusters: u32,
    /// How long it took to build, and how large it is.
    pub build_seconds: f64,
    /// See above.
    pub bytes: usize,
    /// All photons; a few only for the linear scan.
    pub shot: Shot,
    /// The digest of the few that the linear scan also shot.
    pub share: Option<Digest>,
}

/// The same photons through several indices.
pub struct Comparison<'m> {
    /// The lights and what they shine on.
    pub model: &'m Model,
    /// What the indices are built of.
    pub scene: Scene<'m>,
    /// How they are built.
    pub build: Options,
    /// How many photons, and on how many threads.
    pub options: ShootOptions,
}

impl Comparison<'_> {
    /// Builds each index and shoots, with a progress bar. Among several, the linear scan shoots a share.
    ///
    /// # Errors
    /// If an index cannot be built.
    pub fn run(&self, kinds: &[IndexKind]) -> anyhow::Result<Vec<Row>> {
        let shares = kinds.len() > 1 && kinds.contains(&IndexKind::Linear);
        let few = ShootOptions {
            photons: self.options.photons.min(LINEAR_PHOTONS),
            ..self.options.clone()
        };
        let threads = Threads::new(self.options.threads);
        let mut rows = Vec::new();
        for &kind in kinds {
            let owned = OwnedIndex::build_with(kind, &self.scene, &self.build, &threads)
                .with_context(|| format!("cannot build {}", kind.name()))?;
            let index = owned.index();
            let clusters = index.image().cluster_count();
            let index = index.as_ray_index();
            let share = shares.then(|| shoot(self.model, index, &few, &|_| {}).digest);
            let options = if shares && kind == IndexKind::Linear { &few } else { &self.options };
            let bar = photon_bar(options.photons, kind.name());
            let shot = shoot(self.model, index, options, &|photons| bar.inc(photons));
            bar.finish_and_clear();
            let (build_seconds, bytes) = (owned.build_seconds(), owned.bytes());
            rows.push(Row { kind, clusters, build_seconds, bytes, shot, share });
        }
        Ok(rows)
    }
}

/// Prints a table, and a line with the digest of each index; call [`check_digests`] first.
pub fn print_rows(rows: &[Row]) {
    let counted = rows.iter().any(|row| row.shot.counters.is_some());
    let mut headings =
        vec!["index", "clusters", "build", "bytes", "photons", "rays/s", "photons/s"];
    if counted {
        headings.extend(["nodes/ray", "tests/ray"]);
    }
    let mut lines = table(&headings);
    for row in rows {
        let mut cells = vec![
            row.kind.name().to_owned(),
            count(u64::from(row.clusters)),
            duration(row.build_seconds),
            bytes(row.bytes),
            count(row.shot.emitted_photons),
            count(row.shot.rays_per_second() as u64),
            count(row.shot.photons_per_second() as u64),
        ];
        if let Some(counters) = row.shot.counters {
            let rays = row.shot.ray_count.max(1) as f64;
            cells.push(format!("{:.1}", counters.nodes_visited as f64 / rays));
            cells.push(format!("{:.1}", counters.triangle_tests as f64 / rays));
        }
        lines.add_row(cells);
    }
    say!("{lines}");
    let share =
        rows.iter().filter(|row| row.share.is_some()).map(|row| row.shot.emitted_photons).min();
    for row in rows {
        // The linear scan that shot a share has nothing to compare over all photons.
        match (row.share, share) {
            (Some(digest), Some(photons)) if row.kind == IndexKind::Linear => {
                say!("first {photons} photons: {digest} by the linear scan and by every index");
            }
            _ => say!("digest {:<20} {}", row.kind.name(), row.shot.digest),
        }
    }
}

/// Compares all digests of equally many photons.
///
/// # Errors
/// If two differ: a defect of an index.
pub fn check_digests(rows: &[Row]) -> anyhow::Result<()> {
    for (at, row) in rows.iter().enumerate() {
        for other in &rows[..at] {
            let same_photons = row.shot.emitted_photons == other.shot.emitted_photons;
            let same =
                (!same_photons || row.shot.digest == other.shot.digest) && row.share == other.share;
            ensure!(
                same,
                "{} and {} do not give the same result: please report this scene",
                row.kind.name(),
                other.kind.name()
            );
        }
    }
    Ok(())
}

fn summarise(shot: &Shot) {
    say!(
        "{} rays, {} hits, {} absorbed, {} escaped, {} refused, {} cut off; {} on {} thread{}",
        count(shot.ray_count),
        count(shot.hit_count),
        count(shot.absorbed),
        count(shot.escaped),
        count(shot.refused),
        count(shot.cut_off),
        duration(shot.seconds),
        shot.thread_count,
        if shot.thread_count == 1 { "" } else { "s" },
    );
}
