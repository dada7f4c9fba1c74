//! Passes: a picture from photons, and better ones from more photons.
//!
//! Pass `i` shoots the photons `i N .. (i + 1) N`, with discs of the area
//!
//! ```text
//! a(0) = the area asked for      a(i) = a(i - 1) (i - 1 + 2/3) / i
//! ```
//! The picture is the mean of the passes, in their order. Both its noise and its blur vanish with the number of passes.
//! A pass does not depend on the others.
//!
//! # Source
//! C. Knaus, M. Zwicker, *Progressive Photon Mapping: A Probabilistic Approach*, ACM Transactions on Graphics 2011.

use std::ops::Range;
use std::time::Instant;

use arboleda::IndexKind;
use thiserror::Error;

use super::film::Film;
use super::gather::Gathering;
use super::samples::{Glow, Sampling, TILE, TileSamples};
use crate::density::{Estimator, EstimatorError, LightField, PhotonMap, PhotonSource};
use crate::photon::Balance;
use crate::report::Camera;

/// About the number of receivers that are estimated at once: 300 MB of discs.
const RECEIVERS_AT_ONCE: u32 = 2_000_000;
/// Share of an area that the first step of shrinking keeps; 2/3 as in Hachisuka's and Knaus and Zwicker's pictures.
const KEPT: f64 = 2.0 / 3.0;

/// Picture to render: its light, its camera and its passes.
pub struct Passes<'s> {
    /// Photons of the first pass.
    pub source: PhotonSource<'s>,
    /// Estimator of the first pass.
    pub estimator: Estimator,
    /// Kind of the index over discs.
    pub disc_kind: IndexKind,
    /// Photon map of the first pass, if it is there already.
    pub map: Option<PhotonMap>,
    /// Camera, and the size of the picture.
    pub camera: Camera,
    /// Rays of a pixel.
    pub sampling: Sampling,
    /// Rays of final gathering at each receiver, 2 or more; 0 is none.
    pub final_gather: u32,
    /// Number of passes.
    pub passes: u32,
}

/// Listener to the progress of a picture. Its functions are called from any thread.
pub trait Progress: Sync {
    /// Notes that `photons` more photons were shot.
    fn photons(&self, photons: u64);
    /// Notes that `estimates` more estimates were made.
    fn estimates(&self, estimates: u64);
    /// Receives the photon map of a pass, counted from 0.
    ///
    /// # Errors
    /// If the map cannot be kept; then rendering ends.
    fn map(&self, _: u32, _: &PhotonMap) -> anyhow::Result<()> {
        Ok(())
    }
    /// Receives the mean of the first `passes` passes.
    ///
    /// # Errors
    /// If the picture cannot be kept; then rendering ends.
    fn pass(&self, passes: u32, film: &Film, summary: &Summary) -> anyhow::Result<()>;
}

/// Work and outcome of rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Ends of the photons of all passes, each photon once.
    pub balance: Balance,
    /// Primary rays of a pass.
    pub primary_rays: u64,
    /// Estimates of all passes.
    pub estimates: u64,
    /// Estimates of the first pass from fewer photons than [`Estimator::fewest`].
    pub starved: u64,
    /// Estimates of the first pass.
    pub first_estimates: u64,
    /// Photons that were streamed or stored, each as often as it was shot.
    pub photons_shot: u64,
    /// Seconds of shooting photons, with the making of a photon map or the counting of crossings.
    pub photon_seconds: f64,
    /// Seconds of estimates: looking up in a photon map. For DETP, counting is in `photon_seconds`.
    pub estimate_seconds: f64,
    /// Seconds of all.
    pub seconds: f64,
    /// Largest number of bytes of a photon map, or of discs and their index.
    pub bytes: usize,
}

/// Error of rendering.
#[derive(Debug, Error)]
pub enum RenderError {
    /// The estimator is not valid, or its photons or discs cannot be kept.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// The listener failed.
    #[error(transparent)]
    Listener(#[from] anyhow::Error),
}

/// Renders a picture in passes, in the caller's pool.
///
/// # Errors
/// [`RenderError`].
pub fn render(
    passes: Passes<'_>,
    progress: &impl Progress,
) -> Result<(Film, Summary), RenderError> {
    let start = Instant::now();
    let Passes { source, estimator, disc_kind, mut map, camera, sampling, final_gather, passes } =
        passes;
    let (width, height) = camera.size();
    let per_pass = source.photons.end - source.photons.start;
    let glow = Glow::of(source.model);
    let (mut mean, mut summary) = (Film::new(width, height), Summary::default());
    let mut area_share = 1.0;
    for pass in 0..passes.max(1) {
        // 1. The photons and the discs of the pass.
        if pass > 0 {
            area_share *= (f64::from(pass - 1) + KEPT) / f64::from(pass);
        }
        let first = source.photons.start.saturating_add(per_pass.saturating_mul(pass.into()));
        let photons = first..first.saturating_add(per_pass);
        let source = PhotonSource { photons, ..source.clone() };
        let begun = Instant::now();
        let estimator = estimator.shrunk(area_share);
        let given = map.take();
        let shot = if given.is_none() { per_pass } else { 0 };
        let field =
            LightField::new(source, estimator, disc_kind, given, &|some| progress.photons(some))?;
        if let Some(map) = field.map() {
            summary.photons_shot += shot;
            progress.map(pass, map)?;
        }
        let mut gathering = None;
        if final_gather > 0 {
            // Points of two passes have different numbers: a picture has fewer than 2^32 points.
            let first = u64::from(pass) << 32;
            let photons = |some| progress.photons(some);
            gathering = Some(Gathering::new(&field, final_gather, first, &photons)?);
            summary.photons_shot += if field.map().is_some() { per_pass } else { 0 };
        }
        summary.photon_seconds += begun.elapsed().as_secs_f64();

        // 2. The bands of the picture.
        let mut film = Film::new(width, height);
        let mut balance = Balance::default();
        for band in bands(&camera, sampling) {
            let scene = &field.source().index;
            let model = field.source().model;
            let samples = TileSamples::of_rows(&camera, sampling, model, *scene, band);
            let begun = Instant::now();
            let shot = |photons| progress.photons(photons);
            let estimated = |estimates| progress.estimates(estimates);
            let receivers = &samples.receivers;
            let (estimates, work) = match &mut gathering {
                None => field.estimates(receivers, &shot, &estimated)?,
                Some(gathering) => gathering.estimates(&field, receivers, &shot, &estimated)?,
            };
            let seconds = begun.elapsed().as_secs_f64();
            if field.map().is_none() {
                summary.photons_shot += work.streamed;
                summary.photon_seconds += seconds;
            } else {
                summary.estimate_seconds += seconds;
            }
            let rays = sampling.side * sampling.side;
            samples.add_to(&mut film, model, &estimates, rays);
            for share in &samples.shares {
                film.add_emitted(share, share.rays as f32 / rays as f32, &glow);
            }
            balance = work.balance;
            summary.bytes = summary.bytes.max(work.bytes);
            summary.estimates += estimates.len() as u64;
            if pass == 0 {
                let starved =
                    estimates.iter().filter(|estimate| estimate.count < estimator.fewest());
                summary.starved += starved.count() as u64;
                summary.first_estimates += estimates.len() as u64;
                summary.primary_rays += samples.rays;
            }
        }
        film.finish();

        // 3. The mean of the passes.
        summary.balance.join(&balance);
        summary.seconds = start.elapsed().as_secs_f64();
        if pass == 0 {
            mean = film;
        } else {
            mean.join(&film, pass);
        }
        progress.pass(pass + 1, &mean, &summary)?;
    }
    Ok((mean, summary))
}

/// Divides the rows of tiles into bands of about [`RECEIVERS_AT_ONCE`] receivers: one a pixel, and half as many more.
fn bands(camera: &Camera, sampling: Sampling) -> impl Iterator<Item = Range<u32>> + use<> {
    let (width, height) = camera.size();
    let tall = if sampling.side > 1 { 3 } else { 2 };
    let in_row = (width * TILE).saturating_mul(tall) / 2;
    let rows = (RECEIVERS_AT_ONCE / in_row.max(1)).max(1);
    let count = height.div_ceil(TILE);
    (0..count).step_by(rows as usize).map(move |first| first..count.min(first + rows))
}
