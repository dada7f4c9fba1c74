//! `arboleda paper`: the paper's figure 3 and tables 1 to 3, measured again.

use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::MeasureArguments;
use super::output::{bytes, count, say, table};
use super::separation;
use crate::bench::plan::{Effort, Share};
use crate::bench::progress::with_bar;
use crate::bench::record::Recorder;
use crate::files::output::make_folder;
use crate::report::pages::{PaperEvidence, paper_page};
use crate::studies::paper::figure3::{self, Figure3};
use crate::studies::paper::tables::{self, PUBLISHED, SceneTable};

/// The most photons in the study of clusters that move apart.
const SEPARATION_PHOTONS: u64 = 30_000;

/// Measure the paper's figure 3 and tables 1 to 3 again, and compare with its figures
#[derive(Args)]
pub struct Paper {
    #[command(flatten)]
    measure: MeasureArguments,
    /// Write the page index.html and paper.csv to this folder; both also have the study `separation`, on at most
    /// 30,000 photons
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
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
        let effort = self.measure.effort(0.15, Share::Common);
        let own = Effort { share: Share::Own, ..effort };
        let steps = figure3::steps() + PUBLISHED.len() as u64 * tables::steps();
        let (measured, scenes) = with_bar(steps, "paper", |progress| {
            let measured = figure3::run(&own, progress)?;
            let table = |published| tables::run(published, &effort, progress);
            let scenes = PUBLISHED.into_iter().map(table).collect::<anyhow::Result<Vec<_>>>()?;
            anyhow::Ok((measured, scenes))
        })?;
        print_figure3(&measured);
        for table in &scenes {
            print_table(table);
        }
        match &self.out {
            Some(folder) => self.write(folder, &measured, &scenes),
            None => Ok(()),
        }
    }

    /// Writes the page and the file.
    fn write(&self, folder: &Path, figure3: &Figure3, tables: &[SceneTable]) -> anyhow::Result<()> {
        let effort = self.measure.effort(0.1, Share::Own);
        let photons = effort.photons.min(SEPARATION_PHOTONS);
        let apart = separation::measure(&Effort { photons, ..effort })?;

        let mut recorder = Recorder::new(effort.seed);
        recorder.add("figure 3", "fig3", &figure3.hierarchy);
        recorder.add("figure 3", "fig3", &figure3.single);
        for table in tables {
            for row in &table.rows {
                let pair = [row.octree.clone(), row.grid.clone()];
                recorder.add("tables 1 to 3", table.published.scene, &pair);
            }
        }
        separation::record(&mut recorder, &apart);
        let evidence = PaperEvidence {
            figure3,
            tables,
            separation: &apart,
            provenance: recorder.provenance(),
            command: &self.measure.command("paper"),
        };
        let page = folder.join("index.html");
        paper_page(&evidence).save(&page)?;
        let file = folder.join("paper.csv");
        recorder.write_csv(&file)?;
        log::info!("page: {}, measurements: {}", page.display(), file.display());
        Ok(())
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

fn print_table(scene: &SceneTable) {
    let mut lines = table(&[
        scene.published.scene,
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
        "best against best: {:.1}%; against grids as large as octrees with pointers: {:.1}%; in the paper: {:.1}%",
        scene.best_gain(),
        scene.best_pointer_gain(),
        scene.published.gain()
    );
}
