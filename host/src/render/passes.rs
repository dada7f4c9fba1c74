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
use crate::density::{
    Estimator, EstimatorError, Light, LightField, LightPiece, LightSums, PhotonMap, PhotonSource,
};
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
    /// Where the light comes from.
    pub light: PictureLight,
    /// Camera, and the size of the picture.
    pub camera: Camera,
    /// Rays of a pixel.
    pub sampling: Sampling,
    /// Rays of final gathering at each receiver, 2 or more; 0 is none.
    pub final_gather: u32,
    /// Number of passes.
    pub passes: u32,
}

/// Where the light of a picture comes from.
pub enum PictureLight {
    /// Photons are shot.
    Shot,
    /// A photon map of the first pass; photons of the others are shot.
    Map(PhotonMap),
    /// What the photons of all passes left behind.
    Sums(LightSums),
}

impl PictureLight {
    /// Takes the light of a pass, and for final gathering its direct light.
    fn of_pass(&mut self, number: u32) -> Result<[Light; 2], EstimatorError> {
        let light = match self {
            Self::Sums(sums) => {
                let piece = sums.take(number).ok_or(EstimatorError::OtherReceivers)?;
                let LightPiece { all, direct, .. } = piece;
                return Ok([Light::Harvest(all), Light::Harvest(direct.unwrap_or_default())]);
            }
            other => std::mem::replace(other, Self::Shot),
        };
        let light = match light {
            Self::Map(map) => Light::Map(map),
            _ => Light::Shot,
        };
        Ok([light, Light::Shot])
    }
}

/// A pass: its photons and its estimator.
pub(super) struct Pass<'s> {
    pub number: u32,
    pub source: PhotonSource<'s>,
    pub estimator: Estimator,
}

impl<'s> Passes<'s> {
    /// Lists the passes.
    pub(super) fn each(&self) -> impl Iterator<Item = Pass<'s>> + use<'s> {
        let (source, estimator) = (self.source.clone(), self.estimator);
        let first = source.photons.start;
        let per_pass = source.photons.end - first;
        let mut area_share = 1.0;
        (0..self.passes.max(1)).map(move |number| {
            if number > 0 {
                area_share *= (f64::from(number - 1) + KEPT) / f64::from(number);
            }
            let first = first.saturating_add(per_pass.saturating_mul(number.into()));
            let photons = first..first.saturating_add(per_pass);
            let source = PhotonSource { photons, ..source.clone() };
            Pass { number, source, estimator: estimator.shrunk(area_share) }
        })
    }
}

impl Pass<'_> {
    /// Number of the first point from which rays are gathered. Points of two passes have different numbers: a picture
    /// has fewer than 2^32 points.
    pub(super) fn first_point(&self) -> u64 {
        u64::from(self.number) << 32
    }
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
    let each = passes.each();
    let Passes { source, disc_kind, mut light, camera, sampling, final_gather, .. } = passes;
    let (width, height) = camera.size();
    let glow = Glow::of(source.model);
    let (mut mean, mut summary) = (Film::new(width, height), Summary::default());
    for pass in each {
        // 1. The photons and the discs of the pass.
        let begun = Instant::now();
        let per_pass = pass.source.photons.end - pass.source.photons.start;
        let first_point = pass.first_point();
        let Pass { number: pass, source, estimator } = pass;
        let [all, direct] = light.of_pass(pass)?;
        let of_light = |light: &Light| if matches!(light, Light::Shot) { per_pass } else { 0 };
        let shot = [of_light(&all), of_light(&direct)];
        let photons = |some| progress.photons(some);
        let field = LightField::new(source, estimator, disc_kind, all, &photons)?;
        if let Some(map) = field.map() {
            summary.photons_shot += shot[0];
            progress.map(pass, map)?;
        }
        let mut gathering = None;
        if final_gather > 0 {
            let source = Gathering::direct(field.source());
            let direct = LightField::new(source, estimator, disc_kind, direct, &photons)?;
            summary.photons_shot += if field.map().is_some() { shot[1] } else { 0 };
            gathering = Some(Gathering::new(direct, final_gather, first_point));
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
        field.check_used()?;
        gathering.map_or(Ok(()), |gathering| gathering.into_direct().check_used())?;

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
pub(super) fn bands(
    camera: &Camera,
    sampling: Sampling,
) -> impl Iterator<Item = Range<u32>> + use<> {
    let (width, height) = camera.size();
    let tall = if sampling.side > 1 { 3 } else { 2 };
    let in_row = (width * TILE).saturating_mul(tall) / 2;
    let rows = (RECEIVERS_AT_ONCE / in_row.max(1)).max(1);
    let count = height.div_ceil(TILE);
    (0..count).step_by(rows as usize).map(move |first| first..count.min(first + rows))
}
