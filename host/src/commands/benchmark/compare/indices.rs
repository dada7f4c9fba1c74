//! `arboleda compare` alone: every index on every scene, and what that depends on.

use std::path::{Path, PathBuf};

use arboleda::{IndexKind, Options};
use clap::{Args, ValueEnum};

use super::levels::{self, check_levels, print_checks};
use super::scenes::SceneChoice;
use crate::benchmark::harness::plan::{Effort, Share};
use crate::benchmark::harness::progress::with_bar;
use crate::benchmark::harness::record::Recorder;
use crate::benchmark::studies::growth;
use crate::benchmark::studies::indices::{self, SceneComparison};
use crate::commands::arguments::MeasureArguments;
use crate::commands::benchmark::separation;
use crate::commands::output::cluster_picture::paint_model;
use crate::commands::output::{bytes, count, duration, say, table};
use crate::files::output::make_folder;
use crate::report::Canvas;
use crate::report::pages::{CompareEvidence, compare_page};
use crate::scene::{Model, UpAxis, builtin};

/// The most photons in the study of levels: some 6,000 rays, the same for all.
const LEVEL_PHOTONS: u64 = 3_000;
/// Pixels of a picture in the page.
const PICTURE: [u32; 2] = [600, 480];

/// Scenes, effort and outputs.
#[derive(Args)]
pub struct Indices {
    #[command(flatten)]
    scenes: SceneChoice,
    #[command(flatten)]
    measure: MeasureArguments,
    /// Write the page index.html, compare.csv and pictures of the clusters to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// With --out: studies to add to the page, separated by commas. Each takes a minute or more
    #[arg(long, value_name = "STUDY,...", value_enum, value_delimiter = ',', requires = "out")]
    studies: Vec<Study>,
}

/// Study that the page may show besides the comparison.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Study {
    /// Every index on cities and mixed scenes from small to large
    Growth,
    /// The automatic levels and resolutions against all others, on at most 3,000 photons
    Levels,
    /// Each index and its hierarchy on clusters that move apart
    Separation,
    /// All of these
    All,
}

impl Indices {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or a file cannot be read or written.
    pub fn run(&self) -> anyhow::Result<()> {
        if let Some(folder) = &self.out {
            make_folder(folder)?;
        }
        let models = self.scenes.models(builtin::names())?;
        let effort = self.measure.effort(0.1, Share::Own);
        let mut recorder = Recorder::new(effort.seed);
        let mut scenes = Vec::new();
        for model in &models {
            let scene = with_bar(indices::steps(), &model.name, |progress| {
                indices::run(model, &effort, progress)
            })?;
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

    /// Makes the studies asked for, and writes the files.
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
            let brief = Effort { seconds: 0.05, ..*effort };
            growth = with_bar(growth::steps(), "growth", |progress| growth::run(&brief, progress))?;
            for row in &growth {
                recorder.add("growth", row.family, &row.measured);
            }
        }

        let mut checks = Vec::new();
        if self.adds(Study::Levels, "automatic levels against all others") {
            let photons = effort.photons.min(LEVEL_PHOTONS);
            checks =
                check_levels(models, &Effort { photons, seconds: levels::SECONDS, ..*effort })?;
            for check in &checks {
                recorder.add("levels", &check.scene, std::slice::from_ref(&check.automatic));
                recorder.add("levels", &check.scene, &check.tried);
            }
            print_checks(&checks);
        }

        let mut apart = Vec::new();
        if self.adds(Study::Separation, "clusters that move apart") {
            apart = separation::measure(effort)?;
            separation::record(&mut recorder, &apart);
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
            separation: &apart,
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
