//! `arboleda cast`: rays from a file, hits to a file.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use arboleda::{Hit, IndexKind, Ray, RayError, RayIndex};
use clap::{Args, ValueEnum};
use npyz::WriterBuilder;
use rayon::prelude::*;

use super::arguments::{BuildArguments, IndexChoice, SceneArguments};
use crate::{OwnedIndex, Threads, rays};

/// So many of the rays, evenly spread, tell the automatic choice of an index what is asked.
const SAMPLE_RAYS: usize = 1024;

/// Answer the rays of a `NumPy` file.
///
/// RAYS is float32 or float64 of shape (N, 6): origin, direction; or (N, 8): and `t_min`, `t_max` (else 0 and +inf).
/// Origins are in the coordinates of the scene's file, also with `--origin`.
/// HITS is a structured array [('triangle','<u4'),('t','<f4'),('u','<f4'),('v','<f4')] in ray order;
/// triangle ids count faces in file order after triangulation, a miss is 0xFFFFFFFF and +inf.
#[derive(Args)]
pub struct Cast {
    #[command(flatten)]
    scene: SceneArguments,
    /// The rays: a .npy file
    #[arg(long, value_name = "RAYS.npy")]
    rays: PathBuf,
    /// Where the hits go: a .npy file; with `--index all`, h.npy gives h.linear.npy and so on
    #[arg(long, value_name = "HITS.npy")]
    hits: PathBuf,
    /// What to ask of each ray
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
    /// Whether anything is hit: triangle 0 and t = u = v = 0, or a miss
    Occluded,
    /// Every hit, by ray, then by (t, triangle); h.offsets.npy says at which record each ray begins
    All,
}

#[derive(npyz::Serialize, npyz::AutoSerialize, Clone, Copy)]
struct Record {
    triangle: u32,
    t: f32,
    u: f32,
    v: f32,
}

impl From<Hit> for Record {
    fn from(hit: Hit) -> Self {
        Self { triangle: hit.triangle.0, t: hit.t, u: hit.u, v: hit.v }
    }
}

impl Cast {
    /// Runs the command.
    ///
    /// # Errors
    /// If a file cannot be read or written, or the rays have another shape.
    pub fn run(&self) -> anyhow::Result<()> {
        let table = rays::load(&self.rays)?;
        if table.is_rounded() {
            eprintln!("{}: float64 values are rounded to float32", self.rays.display());
        }
        let model = self.scene.load()?;
        let rays = table.rays(model.origin);
        drop(table);
        report_refused(&rays);
        let step = rays.len().div_ceil(SAMPLE_RAYS).max(1);
        let some: Vec<Ray> = rays.iter().step_by(step).filter_map(|ray| ray.ok()).collect();
        let scene = self.build.scene(&model).rays(&some).expecting(rays.len() as u64);
        let kinds = self.index.kinds(&scene, &self.build.options())?;
        for &kind in &kinds {
            let owned =
                OwnedIndex::build_with(kind, &scene, &self.build.options(), &Threads::default())?;
            let path = if self.index.is_all() {
                named(&self.hits, kind.name())
            } else {
                self.hits.clone()
            };
            self.answer(kind, &owned, &rays, &path)?;
        }
        Ok(())
    }

    fn answer(
        &self,
        kind: IndexKind,
        owned: &OwnedIndex,
        rays: &[Result<Ray, RayError>],
        path: &Path,
    ) -> anyhow::Result<()> {
        let index = owned.index();
        let index = index.as_ray_index();
        let miss = Record::from(Hit::NONE);
        let start = std::time::Instant::now();
        let (records, offsets): (Vec<Record>, Option<Vec<u64>>) = match self.query {
            Question::Closest => {
                let closest = |ray: &Ray| index.closest_hit(ray).map_or(miss, Record::from);
                (per_ray(rays, |ray| ray.as_ref().map_or(miss, closest)), None)
            }
            Question::Occluded => {
                // Which triangle is found first depends on the index; that one is found does not.
                let some = Record { triangle: 0, t: 0.0, u: 0.0, v: 0.0 };
                let any = |ray: &Ray| if index.occluded(ray) { some } else { miss };
                (per_ray(rays, |ray| ray.as_ref().map_or(miss, any)), None)
            }
            Question::All => {
                let lists = per_ray(rays, |ray| {
                    ray.as_ref().map_or_else(|_| Vec::new(), |ray| all_hits(index, ray))
                });
                let mut offsets = vec![0];
                let mut records = Vec::new();
                for list in lists {
                    records.extend(list.into_iter().map(Record::from));
                    offsets.push(records.len() as u64);
                }
                (records, Some(offsets))
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        write_npy(path, records.len(), &records)?;
        if let Some(offsets) = offsets {
            write_npy(&named(path, "offsets"), offsets.len(), &offsets)?;
        }
        let hits = records.iter().filter(|record| record.triangle != u32::MAX).count();
        eprintln!(
            "{}: {hits} hits of {} rays in {seconds:.3} s -> {}",
            kind.name(),
            rays.len(),
            path.display()
        );
        Ok(())
    }
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

/// `h.npy` with `name` gives `h.name.npy`.
fn named(path: &Path, name: &str) -> PathBuf {
    let extension = path.extension().unwrap_or_else(|| "npy".as_ref()).to_string_lossy();
    path.with_extension(format!("{name}.{extension}"))
}

/// Says on stderr how many rays are not valid, why, and which comes first.
fn report_refused(rays: &[Result<Ray, RayError>]) {
    let refused: Vec<_> =
        rays.iter().enumerate().filter_map(|(at, ray)| Some((at, ray.as_ref().err()?))).collect();
    if let Some((first, error)) = refused.first() {
        eprintln!(
            "{} of {} rays are not valid and count as misses; the first is ray {first}: {error}",
            refused.len(),
            rays.len()
        );
    }
}

fn write_npy<T: npyz::AutoSerialize + Copy>(
    path: &Path,
    count: usize,
    values: &[T],
) -> anyhow::Result<()> {
    let context = || format!("cannot write {}", path.display());
    let mut file = BufWriter::new(File::create(path).with_context(context)?);
    let mut writer = npyz::WriteOptions::new()
        .default_dtype()
        .shape(&[count as u64])
        .writer(&mut file)
        .begin_nd()
        .with_context(context)?;
    writer.extend(values.iter().copied()).with_context(context)?;
    writer.finish().with_context(context)?;
    file.flush().with_context(context)
}
