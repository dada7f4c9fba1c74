//! `arboleda irradiance`: irradiance at points of a file.

use std::path::PathBuf;
use std::time::Instant;

use arboleda::Vec3;
use clap::Args;

use super::arguments::SceneArguments;
use super::arguments::estimator::KernelName;
use super::arguments::values::file_ending_in;
use super::lit_scene::{LightingArguments, LitScene, print_balance};
use super::output::{bytes, count, duration, say};
use crate::bench::progress::photon_bar;
use crate::density::{Estimate, Receiver, Work};
use crate::files::output::{check_writable, write_npy};
use crate::files::rays;

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
    #[arg(long, value_name = "E.npy", value_parser = file_ending_in(&["npy"]))]
    out: PathBuf,
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
    /// Runs the command.
    ///
    /// # Errors
    /// If a file cannot be read or written, or options contradict each other.
    pub fn run(&self) -> anyhow::Result<()> {
        check_writable(&self.out)?;
        if let Some(path) = &self.lighting.estimator.save_map {
            check_writable(path)?;
        }
        let table = rays::load_as(&self.points, &rays::POINTS)?;
        self.lighting.photons.run(|| self.estimate(&table))
    }

    fn estimate(&self, table: &rays::RayTable) -> anyhow::Result<()> {
        let lit = LitScene::load(&self.scene, &self.lighting)?;
        // 1. Receivers: the rows that are valid.
        let points = table.points(lit.model.origin);
        let receivers: Vec<Option<Receiver>> =
            points.iter().map(|&(position, normal)| Receiver::new(position, normal)).collect();
        report_refused(&points, &receivers);
        let valid: Vec<Receiver> = receivers.iter().copied().flatten().collect();

        // 2. Estimates.
        let start = Instant::now();
        let (estimates, Work { balance, bytes: memory, .. }, estimator) =
            lit.with_source(&self.lighting, |source| -> anyhow::Result<_> {
                let estimator = self.lighting.estimator.resolve(source, KernelName::Constant)?;
                let field = lit.field(source, &estimator, &self.lighting.estimator)?;
                let bar = photon_bar(self.lighting.photons.photons, "estimating");
                let (estimates, work) = field.estimates(&valid, &|some| bar.inc(some), &|_| {})?;
                bar.finish_and_clear();
                Ok((estimates, work, estimator))
            })?;
        let seconds = start.elapsed().as_secs_f64();

        // 3. Rows in the order of the points.
        let mut next = estimates.iter();
        let mut row = |receiver: &Option<Receiver>| {
            let estimate = receiver.as_ref().and_then(|_| next.next());
            EstimateRow::from(estimate.unwrap_or(&Estimate::default()))
        };
        let rows: Vec<EstimateRow> = receivers.iter().map(&mut row).collect();
        write_npy(&self.out, &[rows.len()], &rows)?;

        // 4. Summary.
        print_balance(&balance);
        let empty = estimates.iter().filter(|estimate| estimate.count == 0).count();
        if empty > 0 {
            let of = estimates.len();
            log::warn!(
                "{empty} of {of} points have no photon within the radius; their irradiance is 0"
            );
        }
        say!(
            "{} points, radius {:.4}, {}; {}, {} estimates/s -> {}",
            count(rows.len() as u64),
            estimator.radius(),
            bytes(memory),
            duration(seconds),
            count((estimates.len() as f64 / seconds) as u64),
            self.out.display()
        );
        Ok(())
    }
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
