//! `arboleda cast`: rays from a file, hits to a file.

mod hit_files;

use std::path::{Path, PathBuf};

use anyhow::ensure;
use arboleda::{AnyIndex, BATCH_SCRATCH, Hit, Ray, RayError, RayIndex};
use clap::{Args, ValueEnum};
use rayon::prelude::*;

use super::arguments::packed::PackedArguments;
use super::arguments::values::{file_ending_in, file_ending_in_or_bare};
use super::arguments::{BuildArguments, IndexChoice, SceneArguments, unbuilt};
use crate::benchmark::harness::progress::during;
use crate::files::output::{check_outputs, write_npy};
use crate::files::rays::{self, RayTable};
use crate::scene::Model;
use crate::{IndexFile, PackedScene, Threads, TimedIndex};
use hit_files::{HitRecord, normals, write_objects, write_points};

/// Rays of the sample for the automatic selection of an index, evenly spread over the file.
const SAMPLE_RAYS: usize = 1024;

/// Answer the rays of a NumPy file
///
/// With --index-file, nothing is built. SCENE may be a file X.arb without its scene, too; then only hits are written, and
/// if the index was packed with `--origin`, subtract the origin from the origins of the rays: the file does not hold it.
///
/// RAYS is float32 or float64 of shape (N, 6): origin, direction; or (N, 8): origin, direction, t_min, t_max. The
/// defaults are t_min = 0 and t_max = +inf. A direction may have any length but 0; the unit of t is that length.
/// Origins are in the coordinates of the scene's file, with `--origin` too.
///
/// HITS is a structured array [('triangle','<u4'),('t','<f4'),('u','<f4'),('v','<f4')] in ray order. Triangle ids
/// count faces in file order after triangulation. u and v are the weights of the second and third corner. A miss has
/// triangle 0xFFFFFFFF and t +inf. POINTS and NORMALS are float32 of shape (N, 3), one row for each row of HITS; with
/// `--origin`, POINTS is float64. Points are in the coordinates of the scene's file.
#[derive(Args)]
// The help names arrays as NumPy users do, not as code.
#[allow(clippy::doc_markdown)]
pub struct Cast {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    packed: PackedArguments,
    /// Read the rays from a .npy file
    #[arg(long, value_name = "RAYS.npy")]
    rays: PathBuf,
    /// Write the hits to a .npy file. With `--index all`, `--hits h.npy` writes one file for each index: h.linear.npy,
    /// h.octree.npy and so on. `--points` and `--normals` do the same
    #[arg(long, value_name = "HITS.npy", value_parser = file_ending_in_or_bare("npy"),
        required_unless_present_any = ["points", "normals", "object_names"])]
    hits: Option<PathBuf>,
    /// Write the hit points: NaN for a miss. Each point is on its triangle, rounded to float32
    #[arg(long, value_name = "POINTS.npy", value_parser = file_ending_in_or_bare("npy"))]
    points: Option<PathBuf>,
    /// Write the geometric unit normals: float32, computed in float64, NaN for a miss. A normal points to the side from
    /// which the corners, in the order of the file, are seen counter-clockwise, whichever side the ray comes from
    #[arg(long, value_name = "NORMALS.npy", value_parser = file_ending_in_or_bare("npy"))]
    normals: Option<PathBuf>,
    /// Write the object of each triangle as CSV, one row for each run of triangles: first_triangle, triangle_count,
    /// object. The object's name is that of the file's `o` and `g` lines
    #[arg(long, value_name = "OBJECTS.csv", value_parser = file_ending_in(&["csv"]))]
    object_names: Option<PathBuf>,
    /// Query to answer for each ray
    #[arg(long, value_enum, default_value_t = Question::Closest)]
    query: Question,
    #[command(flatten)]
    index: IndexChoice,
    #[command(flatten)]
    build: BuildArguments,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Question {
    /// The closest hit
    Closest,
    /// Any hit at all: triangle 0 and t = u = v = 0 if the ray is occluded, else a miss
    Occluded,
    /// All hits, sorted by ray, then by (t, triangle); h.offsets.npy beside h.npy has the offset of each ray's first
    /// row
    All,
}

impl Cast {
    /// Runs the command.
    ///
    /// # Errors
    /// If a file cannot be read or written, or the rays have a wrong shape.
    pub fn run(&self) -> anyhow::Result<()> {
        self.check_outputs()?;
        let table = during("reading rays", || rays::load(&self.rays))?;
        if table.is_rounded() {
            log::info!("{}: float64 values are rounded to float32", self.rays.display());
        }
        if let Some(path) = self.scene.index_file(&self.build)? {
            return self.answer_by_file(path, &table);
        }
        if let Some(scene) = self.packed.open()? {
            return self.answer_by_packed(scene, &table);
        }
        let model = self.scene.load()?;
        let rays = table.rays(model.origin);
        drop(table);
        report_refused(&rays);
        let step = rays.len().div_ceil(SAMPLE_RAYS).max(1);
        let some: Vec<Ray> = rays.iter().step_by(step).filter_map(|ray| ray.ok()).collect();
        let scene = self.build.scene(&model).rays(&some).expecting(rays.len() as u64);
        if let Some(path) = &self.object_names {
            write_objects(path, &model)?;
        }
        if self.files().next().is_none() {
            return Ok(());
        }
        let options = self.build.options();
        for kind in self.index.kinds(&scene, &options)? {
            let build = || TimedIndex::build_with(kind, &scene, &options, &Threads::default());
            let owned = during(&format!("building {}", kind.name()), build)
                .map_err(|error| unbuilt(&error))?;
            self.answer(&owned.index(), &rays, &model)?;
        }
        Ok(())
    }

    /// Answers rays by a packed scene.
    fn answer_by_packed(&self, mut scene: PackedScene, table: &RayTable) -> anyhow::Result<()> {
        let rays = table.rays(scene.model.origin);
        report_refused(&rays);
        if let Some(path) = &self.object_names {
            scene.model.object_names = scene.object_names()?;
            write_objects(path, &scene.model)?;
        }
        if self.files().next().is_none() {
            return Ok(());
        }
        self.answer(&scene.index.index(), &rays, &scene.model)
    }

    /// Answers rays by the index of a file. Only hits are written, because not every kind gives its triangles back.
    fn answer_by_file(&self, path: &Path, table: &RayTable) -> anyhow::Result<()> {
        ensure!(
            self.points.is_none() && self.normals.is_none() && self.object_names.is_none(),
            "{} is an index: --points, --normals and --object-names need the scene",
            path.display()
        );
        let rays = table.rays([0.0; 3]);
        report_refused(&rays);
        let file = IndexFile::open(path)?;
        let (index, _) = during("reading the index", || file.index())?;
        let name = index.kind().name();
        ensure!(
            !self.index.is_all() && self.index.named().is_none_or(|kind| kind == index.kind()),
            "{} is the index {name}; --index names another",
            path.display()
        );
        self.answer(&index, &rays, &Model::default())
    }

    /// Lists the files that are written for each index.
    fn files(&self) -> impl Iterator<Item = &Path> {
        [&self.hits, &self.points, &self.normals].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Refuses outputs that cannot be written. Runs before anything is loaded.
    fn check_outputs(&self) -> anyhow::Result<()> {
        ensure!(
            self.query != Question::Occluded || (self.points.is_none() && self.normals.is_none()),
            "--query occluded finds no hit points and no normals; ask for --query closest"
        );
        let named_files = self.files().chain(self.object_names.as_deref()).map(Path::to_owned);
        let first = self.files().next().filter(|_| self.query == Question::All);
        let files = named_files.chain(first.map(|path| named(path, "offsets")));
        let own = vec![self.rays.clone()];
        let inputs = [own, self.scene.inputs()?, self.packed.inputs()].concat();
        check_outputs(&files.collect::<Vec<_>>(), &inputs)
    }

    fn answer(
        &self,
        index: &AnyIndex<'_>,
        rays: &[Result<Ray, RayError>],
        model: &Model,
    ) -> anyhow::Result<()> {
        let (kind, index) = (index.kind(), index.as_ray_index());
        let start = std::time::Instant::now();
        let (records, offsets) = during("answering", || self.records(index, rays));
        let seconds = start.elapsed().as_secs_f64();

        let place = |path: &Path| {
            if self.index.is_all() { named(path, kind.name()) } else { path.to_owned() }
        };
        let count = records.len();
        if let Some(path) = &self.hits {
            write_npy(&place(path), &[count], &records)?;
        }
        if let Some(path) = &self.points {
            write_points(&place(path), model, &records)?;
        }
        if let Some(path) = &self.normals {
            write_npy(&place(path), &[count, 3], &normals(model, &records))?;
        }
        if let (Some(offsets), Some(first)) = (offsets, self.files().next()) {
            write_npy(&named(&place(first), "offsets"), &[offsets.len()], &offsets)?;
        }
        let hits = records.iter().filter(|record| record.is_hit()).count();
        let files: Vec<String> =
            self.files().map(|path| place(path).display().to_string()).collect();
        log::info!(
            "{}: {hits} hits of {} rays in {seconds:.3} s -> {}",
            kind.name(),
            rays.len(),
            files.join(", ")
        );
        Ok(())
    }

    /// Answers the rays in their order. If a ray may have several records, also returns the offset of each ray's first
    /// record.
    fn records(
        &self,
        index: &(dyn RayIndex + Sync),
        rays: &[Result<Ray, RayError>],
    ) -> (Vec<HitRecord>, Option<Vec<u64>>) {
        match self.query {
            Question::Closest => {
                let closest = |rays: &[Ray], hits: &mut [Hit], scratch: &mut [u8]| {
                    index.closest_hits_in(rays, hits, scratch);
                };
                let record =
                    |hit: Hit| if hit.is_none() { HitRecord::MISS } else { HitRecord::from(hit) };
                (per_batch(rays, Hit::NONE, closest, record), None)
            }
            Question::Occluded => {
                // The triangle that an any-hit query finds depends on the index, so the record does not name it.
                let any = |rays: &[Ray], occluded: &mut [bool], scratch: &mut [u8]| {
                    index.occluded_each_in(rays, occluded, scratch);
                };
                let record =
                    |is_occluded| if is_occluded { HitRecord::OCCLUDED } else { HitRecord::MISS };
                (per_batch(rays, false, any, record), None)
            }
            Question::All => {
                let lists = per_ray(rays, |ray| {
                    ray.as_ref().map_or_else(|_| Vec::new(), |ray| all_hits(index, ray))
                });
                let mut offsets = vec![0];
                let mut records = Vec::new();
                for list in lists {
                    records.extend(list.into_iter().map(HitRecord::from));
                    offsets.push(records.len() as u64);
                }
                (records, Some(offsets))
            }
        }
    }
}

/// Rays of a batch: enough that its beginning and its end cost nothing, few enough for all processors to have some.
const BATCH: usize = 2048;

/// Answers valid rays in batches, each in the scratch of its thread, and makes the records of the answers. `none` fills
/// the answers at first. Invalid rays are misses.
fn per_batch<A: Copy + Sync>(
    rays: &[Result<Ray, RayError>],
    none: A,
    answer: impl Fn(&[Ray], &mut [A], &mut [u8]) + Sync,
    record: impl Fn(A) -> HitRecord + Sync,
) -> Vec<HitRecord> {
    let mut records = vec![HitRecord::MISS; rays.len()];
    let batches = rays.par_chunks(BATCH).zip(records.par_chunks_mut(BATCH));
    batches.for_each_init(
        || vec![0; BATCH_SCRATCH],
        |scratch, (rays, records)| {
            let valid: Vec<Ray> = rays.iter().flatten().copied().collect();
            let mut answers = vec![none; valid.len()];
            answer(&valid, &mut answers, scratch);
            let answered = records.iter_mut().zip(rays).filter(|(_, ray)| ray.is_ok());
            for ((slot, _), answer) in answered.zip(answers) {
                *slot = record(answer);
            }
        },
    );
    records
}

fn per_ray<T: Send>(
    rays: &[Result<Ray, RayError>],
    answer: impl Fn(&Result<Ray, RayError>) -> T + Sync + Send,
) -> Vec<T> {
    rays.par_iter().with_min_len(256).map(answer).collect()
}

fn all_hits(index: &(dyn RayIndex + Sync), ray: &Ray) -> Vec<Hit> {
    let mut buffer = vec![Hit::NONE; 16];
    loop {
        let answer = index.all_hits(ray, &mut buffer);
        let (count, truncated) = (answer.hits.len(), answer.truncated);
        if !truncated {
            buffer.truncate(count);
            return buffer;
        }
        buffer.resize(buffer.len() * 4, Hit::NONE);
    }
}

/// Inserts `name` before the ending: `h.npy` becomes `h.name.npy`.
fn named(path: &Path, name: &str) -> PathBuf {
    let extension = path.extension().unwrap_or_else(|| "npy".as_ref()).to_string_lossy();
    path.with_extension(format!("{name}.{extension}"))
}

/// Warns of invalid rays: how many there are, the first one, and the reason for it.
fn report_refused(rays: &[Result<Ray, RayError>]) {
    let refused: Vec<_> =
        rays.iter().enumerate().filter_map(|(at, ray)| Some((at, ray.as_ref().err()?))).collect();
    if let Some((first, error)) = refused.first() {
        log::warn!(
            "{} of {} rays are not valid and count as misses; the first is ray {first}: {error}",
            refused.len(),
            rays.len()
        );
    }
}
