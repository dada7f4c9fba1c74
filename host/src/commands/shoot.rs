//! `arboleda shoot`: photons through one index, or the same photons through each.

use std::path::PathBuf;

use anyhow::{Context, ensure};
use arboleda::{IndexKind, Options, Scene, Vec3};
use clap::Args;

use super::arguments::{BuildArguments, IndexChoice, SceneArguments, unbuilt};
use super::flux_file::write_flux;
use super::output::{bytes, count, duration, say, table};
use super::values::{MOST_PHOTONS, file_ending_in, threads, whole};
use crate::bench::progress::{during, photon_bar};
use crate::bench::workload::{SAMPLE_PHOTONS, Workload};
use crate::file_output::check_writable;
use crate::photon::{Counting, Digest, Emitter, ShootOptions, Shot, shoot};
use crate::report::{Canvas, paint_irradiance};
use crate::scene::{AreaLight, Model};
use crate::{OwnedIndex, Threads};

/// With `--index all`, the linear scan answers so many photons only, and the others as many again.
pub const LINEAR_PHOTONS: u64 = 256;

/// Shoot photons from the lights of a scene through an index, or all of them
///
/// OUT has a row for each triangle, in the order of ids, which count faces in file order after triangulation: as .npy
/// a structured array [('front_photons','<u8'),('back_photons','<u8'),('front_flux','<f8'),('back_flux','<f8')]; as
/// .csv the same columns after the column triangle. Every hit of a photon counts, also if the photon is reflected; flux
/// is in watts. The front is the side from which a triangle's corners, in their order in the file, are seen
/// counter-clockwise.
#[derive(Args)]
// Columns as they are called in the file, not as code.
#[allow(clippy::doc_markdown)]
pub struct Shoot {
    #[command(flatten)]
    scene: SceneArguments,
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
    /// An area light instead of the scene's: a corner, two edges, and the flux in watts; it shines to the
    /// side of the cross product of the edges. May be given several times;
    /// in the coordinates of the scene's file, also with `--origin`
    #[arg(long, value_name = "CX,CY,CZ,UX,UY,UZ,VX,VY,VZ,FLUX", value_parser = light, allow_hyphen_values = true)]
    light: Vec<GivenLight>,
    /// Count nodes visited and triangle tests, too
    #[arg(long)]
    counters: bool,
    /// Write the photons and the flux that each triangle received, on either side
    #[arg(long, value_name = "OUT.npy|csv", value_parser = file_ending_in(&["npy", "csv"]))]
    out: Option<PathBuf>,
    /// Write a picture of the light that arrived
    #[arg(long, value_name = "FILE.png", value_parser = file_ending_in(&["png"]))]
    picture: Option<PathBuf>,
    #[command(flatten)]
    build: BuildArguments,
}

/// A light of the command line, in the coordinates of the scene's file.
#[derive(Clone, Copy)]
struct GivenLight([f64; 10]);

/// Parses a light, and refuses one that emits nothing: it would shoot no photons without a word.
fn light(text: &str) -> Result<GivenLight, String> {
    const NAMES: [&str; 10] = ["CX", "CY", "CZ", "UX", "UY", "UZ", "VX", "VY", "VZ", "FLUX"];
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let mut numbers = [0.0_f64; 10];
    if parts.len() != numbers.len() {
        return Err(format!("ten numbers are needed, {} were given", parts.len()));
    }
    for ((part, name), number) in parts.into_iter().zip(NAMES).zip(&mut numbers) {
        *number = part.parse().map_err(|_| format!("{name} is `{part}`, which is not a number"))?;
        if !(*number as f32).is_finite() {
            return Err(format!("{name} is `{part}`, which is not finite as a 32-bit number"));
        }
    }
    let light = GivenLight(numbers);
    let placed = light.place([0.0; 3]);
    if placed.flux <= 0.0 {
        return Err(format!("FLUX is {}; it must be above 0", placed.flux));
    }
    if Emitter::new(&[placed]).is_dark() {
        return Err("the light has no area: its edges (UX,UY,UZ) and (VX,VY,VZ) are parallel or 0"
            .to_owned());
    }
    Ok(light)
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
        for path in [&self.out, &self.picture].into_iter().flatten() {
            check_writable(path)?;
        }
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
        let sample = self.index.uses_rays().then(|| {
            let photons = SAMPLE_PHOTONS.min(self.photons);
            during("sampling", || Workload::of_photons(&model, photons, self.seed).ok())
        });
        let sample = sample.flatten();
        let scene = self.build.scene(&model).rays(sample.as_ref().map_or(&[], Workload::sample));
        // A photon's first ray and, with the usual reflectances, one bounce.
        let scene = scene.expecting(self.photons.saturating_mul(2));
        let kinds = self.index.kinds(&scene, &self.build.options())?;
        let comparison = Comparison { model: &model, scene, build: self.build.options(), options };
        let rows = comparison.run(&kinds)?;
        print_rows(&rows);
        print_digests(&rows)?;
        let last = rows.last().context("no index was named")?;
        let shot = rows.iter().map(|row| &row.shot).max_by_key(|shot| shot.emitted_photons);
        summarise(shot.unwrap_or(&last.shot));

        let shot = shot.unwrap_or(&last.shot);
        if let Some(path) = &self.out {
            write_flux(path, shot)?;
            log::info!("photons and flux of each triangle: {}", path.display());
        }
        if let Some(path) = &self.picture {
            let mut canvas = Canvas::new(1280, 900);
            let up = self.scene.up.vector(&model);
            during("painting", || -> anyhow::Result<()> {
                let (scene, options) = (self.build.scene(&model), self.build.options());
                let owned = OwnedIndex::build(IndexKind::Bvh, &scene, &options)?;
                paint_light(&mut canvas, &owned, &model, shot, up);
                canvas.save(path)
            })?;
            log::info!("picture: {}", path.display());
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
    let title = format!(
        "{}: irradiance by {} photons, {} W",
        model.name,
        count(shot.emitted_photons),
        shot.total_flux
    );
    paint_irradiance(canvas, index, &model.triangles, &model.bounds(), &irradiance, up, &title);
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
        if shares {
            let photons = few.photons;
            log::info!(
                "{} shoots only the first {photons} photons: it tests every triangle for every ray",
                IndexKind::Linear.name()
            );
        }
        for &kind in kinds {
            let build = || OwnedIndex::build_with(kind, &self.scene, &self.build, &threads);
            let owned = during(&format!("building {}", kind.name()), build)
                .map_err(|error| unbuilt(&error))
                .with_context(|| format!("cannot build {}", kind.name()))?;
            let index = owned.index();
            let clusters = index.sections().cluster_count();
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

/// Prints a table.
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
}

/// Prints one digest if all indices agree, as they promise; else each digest, and fails.
///
/// # Errors
/// If two differ: a defect of an index.
pub fn print_digests(rows: &[Row]) -> anyhow::Result<()> {
    if let Err(defect) = check_digests(rows) {
        for row in rows {
            let share = row.share.map(|digest| format!(", {digest} of the first photons"));
            let photons = count(row.shot.emitted_photons);
            let share = share.unwrap_or_default();
            say!("digest {:<24} {} of {photons} photons{share}", row.kind.name(), row.shot.digest);
        }
        return Err(defect);
    }
    let photons = rows.iter().map(|row| row.shot.emitted_photons).max().unwrap_or(0);
    let full: Vec<&Row> = rows.iter().filter(|row| row.shot.emitted_photons == photons).collect();
    let whole = match full[..] {
        [] => return Ok(()),
        [only] => format!("{} by {}", only.shot.digest, only.kind.name()),
        [first, ..] => format!("{}, the same by all {} indices", first.shot.digest, full.len()),
    };
    say!("digest of {} photons: {whole}", count(photons));
    let part = rows.iter().find(|row| row.shot.emitted_photons < photons);
    if let Some((part, share)) = part.and_then(|row| Some((row, row.share?))) {
        say!(
            "digest of the first {}: {share}, the same by all {} and {}",
            count(part.shot.emitted_photons),
            full.len(),
            part.kind.name()
        );
    }
    Ok(())
}

/// Compares all digests of equally many photons.
fn check_digests(rows: &[Row]) -> anyhow::Result<()> {
    for (at, row) in rows.iter().enumerate() {
        for other in &rows[..at] {
            let same_photons = row.shot.emitted_photons == other.shot.emitted_photons;
            let same =
                (!same_photons || row.shot.digest == other.shot.digest) && row.share == other.share;
            ensure!(
                same,
                "{} and {} DO NOT GIVE THE SAME RESULT: please report this scene",
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
