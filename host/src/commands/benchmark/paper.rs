//! `arboleda paper`: the paper's figure 3 and tables 1 to 3, measured again.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::separation;
use crate::benchmark::harness::plan::{Effort, Share};
use crate::benchmark::harness::progress::{during, with_bar};
use crate::benchmark::harness::record::Recorder;
use crate::benchmark::studies::paper::equal_bytes_tables::{self, SceneTable};
use crate::benchmark::studies::paper::figure3::{self, Figure3};
use crate::benchmark::studies::paper::figure3_apart::{self, ApartRow};
use crate::benchmark::studies::paper::lit::render_scenes;
use crate::benchmark::studies::paper::printed::{PRINTED, PrintedTable};
use crate::benchmark::studies::paper::protocol::{self, LEAF_CAPACITIES, ProtocolTable};
use crate::benchmark::studies::paper::table_file::write_tables;
use crate::benchmark::studies::paper::verdict::{Costs, Verdict};
use crate::benchmark::studies::separation::SeparationRow;
use crate::commands::arguments::MeasureArguments;
use crate::commands::output::{bytes, count, say, table};
use crate::files::output::make_folder;
use crate::report::pages::{PaperEvidence, paper_page};

/// The most photons in the study of clusters that move apart.
const SEPARATION_PHOTONS: u64 = 30_000;
/// Photons of `--quick`, once each.
const QUICK_PHOTONS: u64 = 100;
/// About how long a repetition may take, in seconds; with `--quick`, the second.
const SECONDS: [f64; 2] = [0.1, 0.002];

/// Measure the paper's figure 3 and tables 1 to 3 again, and compare with its figures
///
/// Tables 1 to 3 are measured as printed: octrees of each level against grids of the subdivision beside it, with leaves
/// of 1 and of 12 triangles. Then the same with grids of equal bytes; then figure 3, with its clusters at other
/// distances.
#[derive(Args)]
pub struct Paper {
    #[command(flatten)]
    measure: MeasureArguments,
    /// Measure 100 photons once, and leave out the tables by bytes and the study `separation`: for a look, since its
    /// times mean little
    #[arg(long, conflicts_with_all = ["photons", "repetitions"])]
    quick: bool,
    /// Only these scenes of tables 1 to 3, separated by commas: fig4a to fig4e
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = scene_names())]
    scenes: Vec<String>,
    /// Write the page index.html, tables.csv, paper.csv and a picture of each scene by photons to this folder, also
    /// with the study `separation`, on at most 30,000 photons. tables.csv has a line for each scene, level and leaf
    /// capacity of tables 1 to 3; nodes and tests are per ray, bytes beside the triangles
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Accepts the names of the scenes of tables 1 to 3.
fn scene_names() -> PossibleValuesParser {
    PossibleValuesParser::new(PRINTED.iter().map(|printed| printed.scene))
}

/// All measurements.
struct Evidence {
    tables: Vec<ProtocolTable>,
    /// Empty with `--quick`.
    equal_bytes: Vec<SceneTable>,
    figure3: Figure3,
    apart: Vec<ApartRow>,
    /// Empty with `--quick`, and where no page is asked for.
    separation: Vec<SeparationRow>,
}

impl Paper {
    /// Runs the command.
    ///
    /// # Errors
    /// If two indices do not agree, or a file cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        if let Some(folder) = &self.out {
            make_folder(folder)?;
        }
        let effort = self.effort();
        log::info!("this takes about {}", format_args!("{:.0} s", self.estimated_seconds(&effort)));
        let mut evidence = self.measure(&effort)?;
        if self.out.is_some() && !self.quick {
            let photons = effort.photons.min(SEPARATION_PHOTONS);
            evidence.separation = separation::measure(&Effort { photons, ..effort })?;
        }
        let costs = Costs::fit(&evidence.tables);
        for table in &evidence.tables {
            print_table(table, &costs);
        }
        for table in &evidence.equal_bytes {
            print_equal_bytes(table);
        }
        print_figure3(&evidence.figure3);
        print_apart(&evidence.apart);
        match &self.out {
            Some(folder) => self.write(folder, &effort, &evidence),
            None => Ok(()),
        }
    }

    /// Tells whether the tables of a scene are asked for.
    fn is_asked(&self, scene: &str) -> bool {
        self.scenes.is_empty() || self.scenes.iter().any(|name| name == scene)
    }

    fn effort(&self) -> Effort {
        let effort = self.measure.effort(SECONDS[0], Share::Common);
        if self.quick {
            Effort { photons: QUICK_PHOTONS, repetitions: 1, seconds: SECONDS[1], ..effort }
        } else {
            effort
        }
    }

    /// Measures everything but the study `separation`, with a bar.
    fn measure(&self, effort: &Effort) -> anyhow::Result<Evidence> {
        let own = Effort { share: Share::Own, ..*effort };
        let printed: Vec<&PrintedTable> =
            PRINTED.iter().filter(|printed| self.is_asked(printed.scene)).collect();
        let by_bytes = if self.quick { &[] } else { printed.as_slice() };
        let steps = printed.iter().map(|printed| protocol::steps(printed, effort)).sum::<u64>()
            + by_bytes.len() as u64 * equal_bytes_tables::steps()
            + figure3::steps()
            + figure3_apart::steps();
        with_bar(steps, "paper", |progress| {
            let tables = printed.iter().map(|printed| protocol::run(printed, effort, progress));
            let tables = tables.collect::<anyhow::Result<_>>()?;
            let equal_bytes =
                by_bytes.iter().map(|printed| equal_bytes_tables::run(printed, effort, progress));
            Ok(Evidence {
                tables,
                equal_bytes: equal_bytes.collect::<anyhow::Result<_>>()?,
                figure3: figure3::run(&own, progress)?,
                apart: figure3_apart::run(effort, progress)?,
                separation: Vec::new(),
            })
        })
    }

    /// Writes the command line that repeats the measurement.
    fn command(&self) -> String {
        let command = if self.quick {
            "arboleda paper --quick".to_owned()
        } else {
            self.measure.command("paper")
        };
        match self.scenes.as_slice() {
            [] => command,
            scenes => format!("{command} --scenes {}", scenes.join(",")),
        }
    }

    /// Estimates the seconds of the run, from runs on one core of a Xeon: builds and searches of grids, which do not
    /// depend on the photons, and repetitions, which do up to the time that one may take.
    fn estimated_seconds(&self, effort: &Effort) -> f64 {
        let scenes = if self.scenes.is_empty() { PRINTED.len() } else { self.scenes.len() } as f64;
        let pictures = if self.out.is_some() { scenes + 2.0 } else { 0.0 };
        if self.quick {
            return 10.0 + 12.0 * scenes + 1.5 * pictures;
        }
        let rounds = effort.repetitions as f64 * (effort.photons as f64 / 30_000.0).min(2.0);
        let separation = if self.out.is_some() { 40.0 } else { 0.0 };
        scenes * (25.0 + 2.0 * rounds) + 20.0 + 2.0 * rounds + separation + 6.0 * pictures
    }

    /// Writes the page and the files.
    fn write(&self, folder: &Path, effort: &Effort, evidence: &Evidence) -> anyhow::Result<()> {
        let mut recorder = Recorder::new(effort.seed);
        record(&mut recorder, evidence);
        let lit = during("rendering the scenes", || {
            render_scenes(folder, |scene| self.is_asked(scene), effort.seed, self.quick)
        })?;
        let page = PaperEvidence {
            tables: &evidence.tables,
            equal_bytes: &evidence.equal_bytes,
            figure3: &evidence.figure3,
            apart: &evidence.apart,
            separation: &evidence.separation,
            lit: &lit,
            provenance: recorder.provenance(),
            command: &self.command(),
        };
        let [index, tables, all] =
            ["index.html", "tables.csv", "paper.csv"].map(|name| folder.join(name));
        paper_page(&page)?.save(&index)?;
        write_tables(&tables, &evidence.tables)?;
        recorder.write_csv(&all)?;
        log::info!(
            "page: {}, tables 1 to 3: {}, all measurements: {}",
            index.display(),
            tables.display(),
            all.display()
        );
        Ok(())
    }
}

/// Adds all measurements to the records.
fn record(recorder: &mut Recorder, evidence: &Evidence) {
    for table in &evidence.tables {
        for row in &table.rows {
            recorder.add("tables 1 to 3", table.printed.scene, &row.octrees);
            recorder.add("tables 1 to 3", table.printed.scene, std::slice::from_ref(&row.grid));
        }
    }
    for table in &evidence.equal_bytes {
        for row in &table.rows {
            let three = [row.octree.clone(), row.grid.clone(), row.pointer_grid.clone()];
            recorder.add("equal bytes", table.printed.scene, &three);
        }
    }
    let scene = format!("fig3 at {:.1} sizes", evidence.figure3.gap);
    recorder.add("figure 3", &scene, &evidence.figure3.hierarchy);
    recorder.add("figure 3", &scene, &evidence.figure3.single);
    for row in &evidence.apart {
        let scene = format!("fig3 at {:.1} sizes", row.gap);
        let all = [&row.hierarchy, &row.cubic].into_iter().chain(&row.in_proportion);
        let all: Vec<_> = all.map(|one| one.figures.clone()).collect();
        recorder.add("figure 3 apart", &scene, &all);
    }
    separation::record(recorder, &evidence.separation);
}

fn print_table(table_of: &ProtocolTable, costs: &Costs) {
    let mut lines = table(&[
        table_of.printed.scene,
        "grid",
        "paper",
        "leaves of 1",
        "leaves of 12",
        "us/photon",
        "12",
        "grid",
        "nodes",
        "12",
        "cells",
        "tests",
        "12",
        "grid",
        "verdict",
    ]);
    for row in &table_of.rows {
        let [one, twelve] = &row.octrees;
        let mut cells = vec![
            row.printed.level.to_string(),
            row.printed.grid.to_string(),
            format!("{:+.1}%", row.printed.gain_percent),
        ];
        cells.extend(row.gains().map(|gain| format!("{gain:+.1}%")));
        let three = [one, twelve, &row.grid];
        cells.extend(three.map(|one| format!("{:.3}", one.microseconds_per_photon())));
        cells.extend(three.map(|one| format!("{:.1}", one.nodes_per_ray())));
        cells.extend(three.map(|one| format!("{:.1}", one.tests_per_ray())));
        cells.push(Verdict::of(row, 0, costs).words());
        lines.add_row(cells);
    }
    say!("{lines}");
    let printed = table_of.printed;
    say!("best against best: {:+.1}% in the paper", printed.best_gain());
    for (best, capacity) in table_of.best().iter().flatten().zip(LEAF_CAPACITIES) {
        say!(
            "{:+.1}% with leaves of {capacity}: level {} against {} cells",
            best.gain(),
            best.octree_level,
            best.cells
        );
    }
}

fn print_figure3(figure3: &Figure3) {
    let mut lines = table(&["figure 3", "level", "photons/s", "nodes/ray", "tests/ray", "bytes"]);
    for one in figure3.hierarchy.iter().chain(&figure3.single) {
        lines.add_row([
            one.case.kind.name().to_owned(),
            one.deepest_level.to_string(),
            count(one.photons_per_second() as u64),
            format!("{:.1}", one.nodes_per_ray()),
            format!("{:.1}", one.tests_per_ray()),
            bytes(one.bytes),
        ]);
    }
    say!("{lines}");
    for (level, gain) in figure3.gains() {
        say!("level {level}: the hierarchy saves {gain:.1}%");
    }
}

fn print_apart(rows: &[ApartRow]) {
    let mut lines =
        table(&["gap", "nearly cubic: level", "saved", "in proportion: level", "saved"]);
    for row in rows {
        let (level, gain) = match (&row.in_proportion, row.proportion_gain()) {
            (Some(single), Some(gain)) => {
                (single.figures.deepest_level.to_string(), format!("{gain:.1}%"))
            }
            _ => (String::new(), String::new()),
        };
        lines.add_row([
            format!("{:.1}", row.gap),
            row.cubic.figures.deepest_level.to_string(),
            format!("{:.1}%", row.cubic_gain()),
            level,
            gain,
        ]);
    }
    say!("{lines}");
}

fn print_equal_bytes(scene: &SceneTable) {
    let mut lines = table(&[
        scene.printed.scene,
        "us/photon",
        "grid",
        "gain",
        "large grid",
        "gain",
        "nodes",
        "grid",
        "large",
        "tests",
        "grid",
        "large",
        "bytes",
        "excess",
        "large",
    ]);
    for row in &scene.rows {
        lines.add_row([
            row.level.to_string(),
            format!("{:.3}", row.octree.microseconds_per_photon()),
            format!("{:.3}", row.grid.microseconds_per_photon()),
            format!("{:.1}%", row.gain()),
            format!("{:.3}", row.pointer_grid.microseconds_per_photon()),
            format!("{:.1}%", row.pointer_gain()),
            format!("{:.1}", row.octree.nodes_per_ray()),
            format!("{:.1}", row.grid.nodes_per_ray()),
            format!("{:.1}", row.pointer_grid.nodes_per_ray()),
            format!("{:.1}", row.octree.tests_per_ray()),
            format!("{:.1}", row.grid.tests_per_ray()),
            format!("{:.1}", row.pointer_grid.tests_per_ray()),
            bytes(row.octree.subdivision_bytes),
            format!("{:+.1}%", row.excess_bytes_percent()[0]),
            bytes(row.pointer_grid.subdivision_bytes),
        ]);
    }
    say!("{lines}");
    say!(
        "best against best of equal bytes: {:.1}%; against grids as large as octrees with pointers: {:.1}%; in the \
         paper: {:.1}%",
        scene.best_gain(),
        scene.best_pointer_gain(),
        scene.printed.best_gain()
    );
}
