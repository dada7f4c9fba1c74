//! `arboleda irradiance`: irradiance at points of a file.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;
use arboleda::Vec3;
use clap::Args;

use crate::benchmark::harness::progress::photon_bar;
use crate::commands::arguments::SceneArguments;
use crate::commands::arguments::estimator::KernelName;
use crate::commands::arguments::part::PartArguments;
use crate::commands::arguments::values::file_ending_in;
use crate::commands::light::lit_scene::{LightingArguments, LitScene, print_balance};
use crate::commands::light::parts::{MergeOutputs, MergedJob, PartWork, Team, recorded};
use crate::commands::output::{arrow_to, bytes, count, duration, say};
use crate::density::{
    DiscCounter, Estimate, EstimateWork, Estimator, EstimatorError, Fan, Harvest, LightPiece,
    LightSums, PhotonSource, Receiver,
};
use crate::files::output::{check_outputs, write_npy};
use crate::files::rays;
use crate::parts::{JobKind, PartSums};
use crate::photon::Digest;
use crate::report::four_decimals;

/// Estimate the irradiance at points of a NumPy file
///
/// POINTS is float32 or float64 of shape (N, 6): position, and the normal towards the lit side, of any length but 0.
/// Positions are in the coordinates of the scene's file, with `--origin` too, and need not be on a surface.
///
/// E is a structured array
/// [('irradiance','<f4',(3,)),('count','<u4'),('radius','<f4'),('standard_error','<f4')] in the order of the points.
/// Irradiance of red, green and blue is in W/m2. The count is that of the photons that were found; with fewer than K,
/// the estimate is one of the largest radius. The standard error is that of the mean of the three irradiances. A point
/// that is not valid gets zeros, and a warning.
#[derive(Args)]
// The help names arrays as NumPy users do, not as code.
#[allow(clippy::doc_markdown)]
pub struct Irradiance {
    #[command(flatten)]
    scene: SceneArguments,
    /// Read the points from a .npy file
    #[arg(long, value_name = "POINTS.npy")]
    points: PathBuf,
    /// Write the estimates to a .npy file
    #[arg(long, value_name = "E.npy", value_parser = file_ending_in(&["npy"]), required_unless_present = "part",
        conflicts_with = "part")]
    out: Option<PathBuf>,
    #[command(flatten)]
    part: PartArguments,
    #[command(flatten)]
    lighting: LightingArguments,
}

/// Row of the file of estimates.
#[derive(npyz::Serialize, npyz::AutoSerialize, Clone, Copy)]
struct EstimateRow {
    irradiance: [f32; 3],
    count: u32,
    radius: f32,
    standard_error: f32,
}

impl From<&Estimate> for EstimateRow {
    fn from(estimate: &Estimate) -> Self {
        let Estimate { irradiance, count, radius, standard_error } = *estimate;
        Self { irradiance, count, radius, standard_error }
    }
}

impl Irradiance {
    /// Runs the command, which these arguments of the program named, with a team.
    ///
    /// # Errors
    /// If a file cannot be read or written, or options contradict each other.
    pub fn run(&self, arguments: &[OsString], team: Team) -> anyhow::Result<()> {
        self.run_with(arguments, team, None)
    }

    /// Estimates from the sums of parts that this command shot, as one run of it does, and writes the files of a merge.
    ///
    /// # Errors
    /// If a file cannot be read or written, or the parts are of another job.
    pub fn finish(&mut self, outputs: &MergeOutputs, merged: MergedJob) -> anyhow::Result<()> {
        outputs.check_out(JobKind::Irradiance, &["npy"])?;
        outputs.refuse(JobKind::Irradiance, &["--values"])?;
        self.out.clone_from(&outputs.out);
        outputs.redirect(&mut self.scene, &mut self.lighting, &mut self.part);
        if let Some(path) = &outputs.points {
            self.points.clone_from(path);
        }
        self.run_with(&[], Team::Alone, Some(merged))
    }

    fn run_with(
        &self,
        arguments: &[OsString],
        team: Team,
        merged: Option<MergedJob>,
    ) -> anyhow::Result<()> {
        let files =
            [&self.out, &self.lighting.estimator.save_map, &self.part.part, &self.part.checkpoint];
        let own = vec![self.points.clone()];
        let inputs = [own, self.scene.inputs()?, self.lighting.inputs()].concat();
        check_outputs(files.into_iter().flatten(), &inputs)?;
        self.part.check()?;
        let table = rays::load_as(&self.points, &rays::POINTS)?;
        self.lighting.photons.run(|| self.estimate(&table, arguments, team, merged))
    }

    fn estimate(
        &self,
        table: &rays::RayTable,
        arguments: &[OsString],
        team: Team,
        mut merged: Option<MergedJob>,
    ) -> anyhow::Result<()> {
        let lit = LitScene::load(&self.scene, &self.lighting)?;
        // 1. Receivers: the rows that are valid.
        let points = table.points(lit.model.origin);
        let receivers: Vec<Option<Receiver>> =
            points.iter().map(|&(position, normal)| Receiver::new(position, normal)).collect();
        report_refused(&points, &receivers);
        let valid: Vec<Receiver> = receivers.iter().copied().flatten().collect();

        lit.with_source(&self.lighting, |source| -> anyhow::Result<_> {
            let estimator = self.lighting.estimator.resolve(source, KernelName::Constant)?;
            let own = (source, &estimator);
            let job = || {
                let places = vec![("points", described(&valid))];
                lit.job(JobKind::Irradiance, &self.lighting, own, 1, places)
            };
            if merged.is_none() && self.part.in_parts(team) {
                let fan = Fan::default();
                let counter = DiscCounter::new(&valid, &fan);
                let work = PartWork {
                    job: job()?,
                    arguments: recorded(arguments)?,
                    index: lit.index_name,
                    shoot: &|photons, progress| {
                        let source = PhotonSource { photons, ..source.clone() };
                        Ok(PartSums::Light(harvest(&source, &estimator, &lit, &counter, progress)?))
                    },
                };
                merged = work.run(&self.part, team)?;
                if merged.is_none() {
                    return Ok(());
                }
            }
            let harvest = match merged {
                None => None,
                Some(merged) => {
                    let mut sums = merged.light(&job()?)?;
                    Some(sums.take(0).context("the parts have no photons")?.all)
                }
            };
            self.write(&lit, own, &receivers, &valid, harvest)
        })
    }

    /// Estimates from photons that are shot, or from what photons left behind, and writes the estimates.
    fn write(
        &self,
        lit: &LitScene,
        (source, estimator): (&PhotonSource<'_>, &Estimator),
        receivers: &[Option<Receiver>],
        valid: &[Receiver],
        harvest: Option<Harvest>,
    ) -> anyhow::Result<()> {
        // 1. Estimates.
        let start = Instant::now();
        let field = lit.field(source, estimator, &self.lighting.estimator, harvest)?;
        let bar = photon_bar(self.lighting.photons.photons, "estimating");
        let (estimates, work) = field.estimates(valid, &|some| bar.inc(some), &|_| {})?;
        field.check_used()?;
        bar.finish_and_clear();
        let EstimateWork { balance, bytes: memory, .. } = work;
        let seconds = start.elapsed().as_secs_f64();

        // 2. Rows in the order of the points.
        let mut next = estimates.iter();
        let mut row = |receiver: &Option<Receiver>| {
            let estimate = receiver.as_ref().and_then(|_| next.next());
            EstimateRow::from(estimate.unwrap_or(&Estimate::default()))
        };
        let rows: Vec<EstimateRow> = receivers.iter().map(&mut row).collect();
        if let Some(path) = &self.out {
            write_npy(path, &[rows.len()], &rows)?;
        }

        // 3. Summary.
        print_balance(&balance);
        let empty = estimates.iter().filter(|estimate| estimate.count == 0).count();
        if empty > 0 {
            let of = estimates.len();
            log::warn!(
                "{empty} of {of} points have no photon within the radius; their irradiance is 0"
            );
        }
        say!(
            "{} points, radius {}, {}; {}, {} estimates/s{}",
            count(rows.len() as u64),
            four_decimals(estimator.radius().into()),
            bytes(memory),
            duration(seconds),
            count((estimates.len() as f64 / seconds) as u64),
            arrow_to(self.out.as_deref())
        );
        say!("digest of {} estimates: {}", count(rows.len() as u64), digest(&rows));
        Ok(())
    }
}

/// Shoots the photons of a source and keeps what they leave behind for estimates at the receivers of a counter.
fn harvest(
    source: &PhotonSource<'_>,
    estimator: &Estimator,
    lit: &LitScene,
    counter: &DiscCounter<'_>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<LightSums, EstimatorError> {
    let all = match *estimator {
        Estimator::PhotonMap(..) => Harvest::of_hits(source, &progress)?,
        Estimator::TangentPlane(plane) => {
            counter.harvest(source, plane, lit.disc_kind, &progress)?
        }
    };
    let photons = source.photons.clone();
    Ok(LightSums::of(LightPiece { pass: 0, photons, all, direct: None }))
}

/// Says by number and digest which points there are.
fn described(receivers: &[Receiver]) -> String {
    let mut hasher = blake3::Hasher::new();
    for receiver in receivers {
        for x in receiver.position().to_array() {
            hasher.update(&x.to_bits().to_le_bytes());
        }
        for bits in receiver.normal_bits() {
            hasher.update(&bits.to_le_bytes());
        }
    }
    let digest = Digest(*hasher.finalize().as_bytes());
    format!("of digest {digest} ({} valid)", count(receivers.len() as u64))
}

/// Hashes the estimates, as they are in the file.
fn digest(rows: &[EstimateRow]) -> Digest {
    let mut hasher = blake3::Hasher::new();
    for EstimateRow { irradiance, count, radius, standard_error } in rows {
        let [red, green, blue] = irradiance.map(f32::to_bits);
        let words = [red, green, blue, *count, radius.to_bits(), standard_error.to_bits()];
        for word in words {
            hasher.update(&word.to_le_bytes());
        }
    }
    Digest(*hasher.finalize().as_bytes())
}

/// Warns of points that are not valid: how many there are, and the first one.
fn report_refused(points: &[(Vec3, Vec3)], receivers: &[Option<Receiver>]) {
    let refused = receivers.iter().filter(|receiver| receiver.is_none()).count();
    if let Some(first) = receivers.iter().position(Option::is_none) {
        let (position, normal) = points[first];
        log::warn!(
            "{refused} of {} points are not valid and get zeros; the first is point {first}, position {position}, \
             normal {normal}: numbers must be finite, and a normal must not be 0",
            points.len()
        );
    }
}
