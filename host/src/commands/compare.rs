//! `arboleda compare`: every index on every scene, and what that depends on.

use std::path::{Path, PathBuf};

use anyhow::ensure;
use arboleda::{IndexKind, Options};
use clap::{Args, ValueEnum};

use super::arguments::{MeasureArguments, OriginArgument};
use super::cluster_picture::paint_model;
use super::compare_peers::{self, PeerArguments};
use super::output::{bytes, count, duration, say, table};
use super::separation::{record as record_separation, separation_effort};
use crate::bench::plan::{Effort, Share};
use crate::bench::progress::step_bar;
use crate::bench::record::Recorder;
use crate::file_output::make_folder;
use crate::report::{Canvas, CompareEvidence, compare_page};
use crate::scene::{self, Model, UpAxis, builtin};
use crate::studies::indices::{self, SceneComparison};
use crate::studies::levels::{self, LevelCheck};
use crate::studies::{calibration, counters, growth, separation};

/// Photons on which a level is counted and timed: some 6,000 rays, the same for all.
const LEVEL_PHOTONS: u64 = 3_000;
/// Pixels of a picture in the page.
const PICTURE: [u32; 2] = [600, 480];

/// Compare every index on every scene: time, spread, memory, counters; with a page and a file
#[derive(Args)]
pub struct Compare {
    /// Scene files, beside the built-in scenes
    #[arg(value_name = "SCENE")]
    files: Vec<PathBuf>,
    /// Only these built-in scenes, separated by commas; `none` for the files alone
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    scenes: Vec<String>,
    #[command(flatten)]
    origin: OriginArgument,
    #[command(flatten)]
    measure: MeasureArguments,
    /// Write the page index.html, compare.csv and pictures of the clusters to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// With --out: studies to add to the page, separated by commas. Each takes a minute or more
    #[arg(long, value_name = "STUDY,...", value_enum, value_delimiter = ',', requires = "out")]
    studies: Vec<Study>,
    /// Print only figures that are the same on every machine and in every run: for a diff
    #[arg(long, conflicts_with_all = ["files", "scenes", "photons", "repetitions", "seed", "out", "peers"])]
    counters: bool,
    #[command(flatten)]
    peers: PeerArguments,
    /// Only check the automatic levels and resolutions against all others
    #[arg(long, conflicts_with = "out")]
    levels: bool,
    /// Only measure what a ray, a node and a test take in each index, and print the table of the automatic selection
    #[arg(long, conflicts_with_all = ["out", "levels", "photons", "repetitions"])]
    calibrate: bool,
}

/// A study that the page may show besides the comparison.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Study {
    /// Every index on cities and mixed scenes from small to large
    Growth,
    /// The automatic levels and resolutions against all others
    Levels,
    /// Each index and its hierarchy on clusters that move apart
    Separation,
    /// All of these
    All,
}

impl Compare {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or a file cannot be read or written.
    pub fn run(&self) -> anyhow::Result<()> {
        if self.counters {
            say!("{}", counters::lines()?.trim_end());
            return Ok(());
        }
        if self.peers.peers {
            let models = || self.models(compare_peers::SCENES);
            let folder = self.out.as_deref();
            return compare_peers::run(
                &self.peers,
                models,
                self.measure.seed,
                self.measure.repetitions,
                folder,
            );
        }
        if let Some(folder) = &self.out {
            make_folder(folder)?;
        }
        let models = self.models(builtin::names())?;
        if self.levels {
            print_checks(&self.check_levels(&models)?);
            return Ok(());
        }
        if self.calibrate {
            let bar = step_bar(calibration::steps(&models), "calibration");
            let fits =
                calibration::run(&models, &calibration::EFFORT, self.measure.seed, &|| bar.inc(1))?;
            bar.finish_and_clear();
            say!("{}", calibration::lines(&fits).trim_end());
            return Ok(());
        }
        let effort = Effort {
            photons: self.measure.photons,
            repetitions: self.measure.repetitions,
            seconds: 0.1,
            share: Share::Own,
        };
        let mut recorder = Recorder::new(self.measure.seed);
        let mut scenes = Vec::new();
        for model in &models {
            let bar = step_bar(indices::steps(), &model.name);
            let scene = indices::run(model, &effort, self.measure.seed, &mut || bar.inc(1))?;
            bar.finish_and_clear();
            print_scene(&scene);
            recorder.add("compare", &scene.scene, &scene.measured);
            scenes.push(scene);
        }
        print_selections(&scenes);
        match &self.out {
            Some(folder) => self.write(folder, &models, &scenes, &effort, recorder),
            None => Ok(()),
        }
    }

    /// Writes the command line that makes the same page again, without the scenes.
    fn command(&self) -> String {
        let studies = self.studies.iter().filter_map(ValueEnum::to_possible_value);
        let studies: Vec<String> = studies.map(|study| study.get_name().to_owned()).collect();
        let mut command = format!("{} --out DIR", self.measure.command("compare"));
        if !studies.is_empty() {
            command = format!("{command} --studies {}", studies.join(","));
        }
        command
    }

    /// Tells whether a study is to be added, and if so logs that it takes a while.
    fn adds(&self, study: Study, what: &str) -> bool {
        let added = self.studies.contains(&study) || self.studies.contains(&Study::All);
        if added {
            log::info!("{what}: this takes a minute or more");
        }
        added
    }

    /// The scenes named, or the `usual` ones, and the files, each with a light.
    fn models(&self, usual: impl IntoIterator<Item = &'static str>) -> anyhow::Result<Vec<Model>> {
        let names: Vec<&str> = match self.scenes.as_slice() {
            [] => usual.into_iter().collect(),
            [only] if only == "none" => Vec::new(),
            names => names.iter().map(String::as_str).collect(),
        };
        let mut models = Vec::new();
        for name in names {
            models.push(builtin::require(name)?);
        }
        for path in &self.files {
            models.push(scene::load(path, self.origin.get())?);
        }
        ensure!(!models.is_empty() || self.peers.growth.is_some(), "no scene is named");
        Ok(models.into_iter().map(|model| model.with_default_light(UpAxis::Auto)).collect())
    }

    /// The automatic choices of every index against all others.
    fn check_levels(&self, models: &[Model]) -> anyhow::Result<Vec<LevelCheck>> {
        let effort = Effort {
            photons: self.measure.photons.min(LEVEL_PHOTONS),
            repetitions: self.measure.repetitions,
            seconds: 0.3,
            share: Share::Own,
        };
        let mut checks = Vec::new();
        for model in models {
            let bar = step_bar(levels::steps(), &format!("{}, levels", model.name));
            checks.extend(levels::run(model, &effort, self.measure.seed, &|| bar.inc(1))?);
            bar.finish_and_clear();
        }
        Ok(checks)
    }

    /// The rest of the studies, and the files.
    fn write(
        &self,
        folder: &Path,
        models: &[Model],
        scenes: &[SceneComparison],
        effort: &Effort,
        mut recorder: Recorder,
    ) -> anyhow::Result<()> {
        let mut growth = Vec::new();
        if self.adds(Study::Growth, "every index on larger and larger scenes") {
            let bar = step_bar(growth::steps(), "growth");
            let brief = Effort { seconds: 0.05, ..*effort };
            growth = growth::run(&brief, self.measure.seed, &mut || bar.inc(1))?;
            bar.finish_and_clear();
            for row in &growth {
                recorder.add("growth", row.family, &row.measured);
            }
        }

        let mut checks = Vec::new();
        if self.adds(Study::Levels, "automatic levels against all others") {
            checks = self.check_levels(models)?;
            for check in &checks {
                recorder.add("levels", &check.scene, std::slice::from_ref(&check.automatic));
                recorder.add("levels", &check.scene, &check.tried);
            }
            print_checks(&checks);
        }

        let mut separation = Vec::new();
        if self.adds(Study::Separation, "clusters that move apart") {
            let bar = step_bar(separation::steps(), "separation");
            let apart = separation_effort(self.measure.photons, self.measure.repetitions);
            separation = separation::run(&apart, self.measure.seed, &mut || bar.inc(1))?;
            bar.finish_and_clear();
            record_separation(&mut recorder, &separation);
        }

        let pictures = models
            .iter()
            .map(|model| picture(folder, model))
            .collect::<anyhow::Result<Vec<_>>>()?;
        let pictures: Vec<(&Path, String)> =
            pictures.iter().map(|(path, line)| (path.as_path(), line.clone())).collect();
        let evidence = CompareEvidence {
            scenes,
            growth: &growth,
            separation: &separation,
            levels: &checks,
            pictures: &pictures,
            provenance: recorder.provenance(),
            command: &self.command(),
        };
        let page = folder.join("index.html");
        compare_page(&evidence)?.save(&page)?;
        let file = folder.join("compare.csv");
        recorder.write_csv(&file)?;
        log::info!("page: {}, measurements: {}", page.display(), file.display());
        Ok(())
    }
}

/// Paints the clusters of a model, and says what they are.
fn picture(folder: &Path, model: &Model) -> anyhow::Result<(PathBuf, String)> {
    let mut canvas = Canvas::new(PICTURE[0], PICTURE[1]);
    let up = UpAxis::Auto.vector(model);
    let line = paint_model(&mut canvas, model, &model.scene(), &Options::default(), up)?;
    let path = folder.join(format!("{}.clusters.png", model.name));
    canvas.save(&path)?;
    Ok((path, line))
}

fn print_scene(scene: &SceneComparison) {
    let mut lines = table(&[
        &scene.scene,
        "build",
        "bytes",
        "photons/s",
        "rays/s",
        "slowest/fastest",
        "nodes/ray",
        "tests/ray",
        "photons",
    ]);
    for one in &scene.measured {
        lines.add_row([
            one.case.kind.name().to_owned(),
            duration(one.build_seconds),
            bytes(one.bytes),
            count(one.photons_per_second() as u64),
            count(one.rays_per_second() as u64),
            format!("{:.2}", one.seconds.max / one.seconds.min),
            format!("{:.1}", one.nodes_per_ray()),
            format!("{:.1}", one.tests_per_ray()),
            count(one.photons),
        ]);
    }
    say!("{lines}");
}

fn print_selections(scenes: &[SceneComparison]) {
    let mut lines = table(&[
        "automatic selection",
        "by a sample",
        "estimated",
        "rays/s",
        "loss",
        "by photons",
        "rays/s",
        "loss",
        "fastest",
        "rays/s",
    ]);
    for scene in scenes {
        let rate = |kind| scene.of(kind).map_or(0, |one| one.rays_per_second() as u64);
        let fastest = scene.fastest().map_or(IndexKind::Linear, |one| one.case.kind);
        let (by_sample, by_rays) = (&scene.by_sample, &scene.by_rays);
        lines.add_row([
            scene.scene.clone(),
            by_sample.kind().name().to_owned(),
            format!("{:.2} us", by_sample.cost().nanoseconds / 1e3),
            count(rate(by_sample.kind())),
            format!("{:.1}%", scene.loss_percent(by_sample)),
            by_rays.kind().name().to_owned(),
            count(rate(by_rays.kind())),
            format!("{:.1}%", scene.loss_percent(by_rays)),
            fastest.name().to_owned(),
            count(rate(fastest)),
        ]);
    }
    say!("{lines}");
}

fn print_checks(checks: &[LevelCheck]) {
    let mut lines = table(&[
        "automatic choice",
        "level",
        "nodes",
        "tests",
        "cost/ray",
        "cheapest",
        "nodes",
        "tests",
        "cost/ray",
        "excess",
        "fastest",
        "excess time",
    ]);
    for check in checks {
        let (cheapest, fastest) = (check.best_by_counters(), check.best_by_time());
        lines.add_row([
            format!("{} {}", check.scene, check.automatic.case.kind.name()),
            check.automatic.deepest_level.to_string(),
            format!("{:.1}", check.automatic.nodes_per_ray()),
            format!("{:.1}", check.automatic.tests_per_ray()),
            format!("{:.2}", check.automatic.cost_per_ray()),
            cheapest.case.setting.clone(),
            format!("{:.1}", cheapest.nodes_per_ray()),
            format!("{:.1}", cheapest.tests_per_ray()),
            format!("{:.2}", cheapest.cost_per_ray()),
            format!("{:.1}%", check.excess_cost()),
            fastest.case.setting.clone(),
            format!("{:+.1}%", check.excess_time()),
        ]);
    }
    say!("{lines}");
}
