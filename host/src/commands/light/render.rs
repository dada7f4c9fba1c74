//! `arboleda render`: a picture of a scene by photons.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::{Context, ensure};
use arboleda::Vec3;
use clap::{Args, ValueEnum};
use indicatif::ProgressBar;

use crate::benchmark::harness::progress::{count_bar, photon_bar, together};
use crate::commands::arguments::SceneArguments;
use crate::commands::arguments::estimator::KernelName;
use crate::commands::arguments::part::PartArguments;
use crate::commands::arguments::values::{PIXELS, file_ending_in, number, whole};
use crate::commands::light::lit_scene::{LightingArguments, LitScene, print_balance};
use crate::commands::light::parts::{MergeOutputs, MergedJob, PartWork, Team, recorded};
use crate::commands::output::{arrow_to, bytes, count, duration, say};
use crate::density::{
    Bounces, Estimator, Gather, MapEstimator, PhotonMap, PhotonSource, automatic_radius,
};
use crate::files::output::check_outputs;
use crate::parts::{Job, JobKind, PartSums};
use crate::render::{
    Film, Look, Passes, PictureLight, Progress, Quantity, Range, Sampling, Summary, Unit, paint,
    render, viewpoint, write_values,
};
use crate::report::{Camera, short_number};

/// Render a picture of a scene, lit by photons
///
/// Without `--eye`, the camera looks from above one corner, or from where it sees more of the lit surfaces. A surface
/// reflects diffusely. Natural colours are exposed such that the 99th percentile is white, and written in sRGB. Each of
/// several passes shoots new photons, with smaller discs, and writes the mean of the passes so far.
#[derive(Args)]
pub struct Render {
    #[command(flatten)]
    scene: SceneArguments,
    /// Write the picture
    #[arg(long, short, value_name = "PICTURE.png", value_parser = file_ending_in(&["png"]),
        required_unless_present = "part", conflicts_with = "part")]
    out: Option<PathBuf>,
    /// Write the values of the pixels: .exr with radiance, irradiance, count, radius, depth.Z, triangle and stderr;
    /// .pfm with three values of the quantity
    #[arg(long, value_name = "OUT.exr|pfm", value_parser = file_ending_in(&["exr", "pfm"]), conflicts_with = "part")]
    values: Option<PathBuf>,
    /// Width and height in pixels, 64 to 8192
    #[arg(long, value_names = ["WIDTH", "HEIGHT"], num_args = 2, default_values_t = [1280, 900],
        value_parser = whole::<u32>(PIXELS))]
    size: Vec<u32>,
    /// Rays of a pixel along each side
    #[arg(long, value_name = "S", default_value_t = 2, value_parser = whole::<u32>(1..=16))]
    samples: u32,
    /// Position of the eye, in the coordinates of the scene's file
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    eye: Option<[f64; 3]>,
    /// Point in the middle of the picture [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "eye")]
    look_at: Option<[f64; 3]>,
    /// Angle in degrees that the width of the picture covers
    #[arg(long, value_name = "DEG", default_value_t = 40.0, value_parser = number(1.0..=170.0), requires = "eye")]
    fov: f32,
    /// Quantity to show
    #[arg(long, value_enum, default_value_t = QuantityName::Radiance)]
    quantity: QuantityName,
    /// Factor of natural colours; a value of 1 is white then
    #[arg(long, value_name = "X|auto", default_value = "auto", value_parser = positive_or_auto,
        conflicts_with = "false_colour")]
    exposure: PositiveOrAuto,
    /// Show values as colours, with a legend
    #[arg(long)]
    false_colour: bool,
    /// Value of the brightest false colour [auto: the 99th percentile]
    #[arg(long, value_name = "MAX|auto", default_value = "auto", value_parser = positive_or_auto,
        requires = "false_colour")]
    scale: PositiveOrAuto,
    /// Logarithmic false colours over this number of decades
    #[arg(long, value_name = "DECADES", value_parser = number(0.1..=30.0), requires = "false_colour")]
    log: Option<f32>,
    /// Unit of false colours and of the printed extrema: W/m2, or lux
    #[arg(long, value_enum, default_value_t = UnitName::W)]
    unit: UnitName,
    /// Lumens of a watt, for lux; 179 is that of Radiance
    #[arg(long, value_name = "LM", default_value_t = 179.0, value_parser = number(1e-3..=683.0), requires = "unit")]
    efficacy: f32,
    /// Gather indirect light by N rays from each point, 2 to 4096, and estimate at their ends: smoother, but N times
    /// the estimates
    #[arg(long, value_name = "N", value_parser = whole::<u32>(2..=4096))]
    final_gather: Option<u32>,
    /// Number of passes
    #[arg(long, value_name = "P", default_value_t = 1, value_parser = whole::<u32>(1..=1_000_000))]
    passes: u32,
    #[command(flatten)]
    part: PartArguments,
    #[command(flatten)]
    lighting: LightingArguments,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QuantityName {
    /// Radiance towards the eye: light that surfaces reflect and emit
    Radiance,
    /// Irradiance of surfaces: light that falls on them
    Irradiance,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum UnitName {
    /// Watts
    W,
    /// Lumens: lux, or candela per square metre
    Lux,
}

#[derive(Clone, Copy)]
struct PositiveOrAuto(Option<f32>);

fn positive_or_auto(text: &str) -> Result<PositiveOrAuto, String> {
    if text == "auto" {
        return Ok(PositiveOrAuto(None));
    }
    let number: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    let valid = number > 0.0 && number.is_finite();
    valid.then_some(PositiveOrAuto(Some(number))).ok_or("must be finite and above 0".into())
}

fn vector(text: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|&x| (x as f32).is_finite()) => Ok([x, y, z]),
        _ => Err("three finite numbers are needed, as 1,2,3".to_owned()),
    }
}

impl Render {
    /// Runs the command, which these arguments of the program named, with a team.
    ///
    /// # Errors
    /// If the scene cannot be loaded, a file cannot be written, or options contradict each other.
    pub fn run(&self, arguments: &[OsString], team: Team) -> anyhow::Result<()> {
        self.run_with(arguments, team, None)
    }

    /// Makes the picture of the sums of parts that this command shot, as one run of it does, and writes the files of a
    /// merge.
    ///
    /// # Errors
    /// If a file cannot be read or written, or the parts are of another job.
    pub fn finish(&mut self, outputs: &MergeOutputs, merged: MergedJob) -> anyhow::Result<()> {
        outputs.check_out(JobKind::Render, &["png"])?;
        outputs.refuse(JobKind::Render, &["--points"])?;
        self.out.clone_from(&outputs.out);
        self.values.clone_from(&outputs.values);
        outputs.redirect(&mut self.scene, &mut self.lighting, &mut self.part);
        self.run_with(&[], Team::Alone, Some(merged))
    }

    fn run_with(
        &self,
        arguments: &[OsString],
        team: Team,
        merged: Option<MergedJob>,
    ) -> anyhow::Result<()> {
        let map = &self.lighting.estimator.save_map;
        let files = [&self.out, &self.values, map, &self.part.part, &self.part.checkpoint];
        let inputs = [self.scene.inputs()?, self.lighting.inputs()].concat();
        check_outputs(files.into_iter().flatten(), &inputs)?;
        self.part.check()?;
        ensure!(
            self.final_gather.is_none() || self.lighting.estimator.bounces() == Bounces::All,
            "--final-gather shows all light: it cannot be used with --bounces"
        );
        self.lighting.photons.run(|| self.picture(arguments, team, merged))
    }

    fn picture(
        &self,
        arguments: &[OsString],
        team: Team,
        mut merged: Option<MergedJob>,
    ) -> anyhow::Result<()> {
        let lit = LitScene::load(&self.scene, &self.lighting)?;
        lit.with_source(&self.lighting, |source| -> anyhow::Result<_> {
            let estimator = self.lighting.estimator.resolve(source, KernelName::Epanechnikov)?;
            let mut passes = Passes {
                source: source.clone(),
                estimator,
                disc_kind: lit.disc_kind,
                light: PictureLight::Shot,
                camera: self.camera(source)?,
                sampling: self.sampling(source, &estimator),
                final_gather: self.final_gather.unwrap_or(0),
                passes: self.passes,
            };
            if merged.is_none() && self.part.in_parts(team) {
                let ground = passes.ground();
                let counter = ground.counter();
                let work = PartWork {
                    job: self.job(&lit, &passes)?,
                    arguments: recorded(arguments)?,
                    index: lit.index_name,
                    shoot: &|photons, progress| {
                        let sums = passes.harvest(counter.as_ref(), &photons, &progress)?;
                        Ok(PartSums::Light(sums))
                    },
                };
                merged = work.run(&self.part, team)?;
                if merged.is_none() {
                    return Ok(());
                }
            }
            passes.light = match (
                merged,
                lit.load_map(&self.lighting.estimator, self.lighting.photons.photons)?,
            ) {
                (Some(merged), _) => PictureLight::Sums(merged.light(&self.job(&lit, &passes)?)?),
                (None, Some(map)) => PictureLight::Map(map),
                (None, None) => PictureLight::Shot,
            };
            self.paint(&lit, passes)
        })
    }

    /// Renders the passes, and writes their picture.
    fn paint(&self, lit: &LitScene, passes: Passes<'_>) -> anyhow::Result<()> {
        let (look, estimator) = (self.look(), passes.estimator);
        let total = self.lighting.photons.photons.saturating_mul(self.passes.into());
        let [photons, estimates] = together([photon_bar(total, "photons"), count_bar("estimates")]);
        let listener = Listener { render: self, lit, look, photons, estimates };
        let (film, summary) = render(passes, &listener)?;
        listener.photons.finish_and_clear();
        listener.estimates.finish_and_clear();
        self.summarise(&film, &look, &summary, &estimator);
        Ok(())
    }

    /// Makes the job of all passes.
    fn job(&self, lit: &LitScene, passes: &Passes<'_>) -> anyhow::Result<Job> {
        let (width, height) = passes.camera.size();
        let options = vec![
            ("--size", format!("{width} x {height}")),
            ("the camera", passes.camera.described()),
            ("--samples", self.samples.to_string()),
            ("--final-gather", passes.final_gather.to_string()),
        ];
        let own = (&passes.source, &passes.estimator);
        lit.job(JobKind::Render, &self.lighting, own, self.passes, options)
    }

    fn look(&self) -> Look {
        Look {
            quantity: match self.quantity {
                QuantityName::Radiance => Quantity::Radiance,
                QuantityName::Irradiance => Quantity::Irradiance,
            },
            unit: match self.unit {
                UnitName::W => Unit::Watts,
                UnitName::Lux => Unit::Lumens(self.efficacy),
            },
            exposure: self.exposure.0,
            false_colour: self
                .false_colour
                .then_some(Range { largest: self.scale.0, decades: self.log }),
        }
    }

    fn camera(&self, source: &PhotonSource<'_>) -> anyhow::Result<Camera> {
        let model = source.model;
        let (up, size) = (self.scene.up.vector(model), (self.size[0], self.size[1]));
        let Some(eye) = self.eye else {
            let camera = viewpoint(source, up, size);
            let middle = camera.ray(size.0 as f32 * 0.5, size.1 as f32 * 0.5);
            middle.context(
                "the scene is too large for a camera that sees all of it: give it one with --eye, or scale it down",
            )?;
            return Ok(camera);
        };
        let place = |point: [f64; 3]| {
            Vec3::from_array([0, 1, 2].map(|axis| (point[axis] - model.origin[axis]) as f32))
        };
        let look_at = self.look_at.map_or(model.bounds().centre(), place);
        Camera::at(place(eye), look_at, up, self.fov, size).context(
            "the camera has no direction: --look-at is at the eye, or straight above or below it, or too far away",
        )
    }

    /// Returns the pattern of rays. The k nearest have no fixed radius, so it is that of a disc that holds k photons.
    fn sampling(&self, source: &PhotonSource<'_>, estimator: &Estimator) -> Sampling {
        let radius = match estimator {
            Estimator::PhotonMap(MapEstimator { gather: Gather::Nearest { k, .. }, .. }, _) => {
                automatic_radius(source, *k as f64)
            }
            _ => estimator.radius(),
        };
        Sampling::of_radius(self.samples, radius)
    }

    fn summarise(&self, film: &Film, look: &Look, summary: &Summary, estimator: &Estimator) {
        print_balance(&summary.balance);
        let radius = short_number(f64::from(estimator.radius()));
        let starved = 100.0 * summary.starved as f64 / summary.first_estimates.max(1) as f64;
        let method = match estimator {
            Estimator::PhotonMap(MapEstimator { gather: Gather::Nearest { k, .. }, .. }, _) => {
                format!("the {k} nearest within {radius}")
            }
            Estimator::PhotonMap(..) => format!("photons within {radius}"),
            Estimator::TangentPlane(_) => format!("crossings of discs of radius {radius}"),
        };
        say!(
            "{method}; {starved:.1}% of the estimates found fewer than {} photons",
            count(estimator.fewest().into())
        );
        if let Some([least, mean, largest]) = look.extrema(film) {
            let [least, mean, largest] =
                [least, mean, largest].map(|value| short_number(f64::from(value)));
            say!("least {least}, mean {mean}, largest {largest} {}", look.unit_name());
        }
        let rate = |number: u64, seconds: f64| count((number as f64 / seconds.max(1e-9)) as u64);
        let by_map = summary.estimate_seconds > 0.0;
        say!(
            "{} photons/s, {} estimates/s, {} primary rays, {}, {}{}",
            rate(summary.photons_shot, summary.photon_seconds),
            rate(
                summary.estimates,
                if by_map { summary.estimate_seconds } else { summary.photon_seconds }
            ),
            count(summary.primary_rays),
            bytes(summary.bytes),
            duration(summary.seconds),
            arrow_to(self.out.as_deref())
        );
        say!("digest of {} pixels: {}", count(film.pixels().len() as u64), film.digest());
    }

    fn write(&self, film: &Film, look: &Look) -> anyhow::Result<()> {
        if let Some(path) = &self.out {
            paint(film, look).save(path)?;
        }
        match &self.values {
            Some(path) => write_values(path, film, look),
            None => Ok(()),
        }
    }
}

/// Shows the progress, and writes the picture after each pass.
struct Listener<'r> {
    render: &'r Render,
    lit: &'r LitScene,
    look: Look,
    photons: ProgressBar,
    estimates: ProgressBar,
}

impl Progress for Listener<'_> {
    fn photons(&self, photons: u64) {
        self.photons.inc(photons);
    }

    fn estimates(&self, estimates: u64) {
        self.estimates.inc(estimates);
    }

    fn map(&self, pass: u32, map: &PhotonMap) -> anyhow::Result<()> {
        if pass == 0 {
            self.lit.save_map(map, &self.render.lighting.estimator)?;
        }
        Ok(())
    }

    fn pass(&self, passes: u32, film: &Film, summary: &Summary) -> anyhow::Result<()> {
        self.render.write(film, &self.look)?;
        let (all, seconds) = (self.render.passes, duration(summary.seconds));
        if all > 1 {
            let file = arrow_to(self.render.out.as_deref());
            log::info!("pass {passes} of {all}, {seconds}{file}");
        }
        Ok(())
    }
}
