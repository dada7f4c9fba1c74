//! `arboleda compare peers`: other people's libraries on the same rays.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use arboleda::IndexKind;
use clap::Args;

use super::scenes::SceneChoice;
use crate::benchmark::contenders::{PEERS, Peer, PeerError, ours};
use crate::benchmark::harness::progress::with_bar;
use crate::benchmark::harness::provenance::Provenance;
use crate::benchmark::studies::growth::sized_scenes;
use crate::benchmark::studies::peers::{self, PeerComparison, PeerOptions, USUAL_KINDS};
use crate::commands::arguments::RepeatArguments;
use crate::commands::arguments::values::whole;
use crate::commands::output::{count, say};
use crate::files::output::{make_folder, write_file};
use crate::index::{kind_by_name, kind_names};
use crate::report::pages::peers_table::{
    GROWTH_LEGEND, SCENE_LEGEND, growth_grid, scene_grid, write_csv,
};
use crate::report::pages::{PeersEvidence, absent, peers_page};
use crate::scene::builtin;

/// The most rays of a mode: each is kept, with the answers of every contender.
const MOST_RAYS: u64 = 100_000_000;

/// The scenes if none are named: the paper's, one closed, one large mesh, one that fits no cache.
const SCENES: [&str; 10] =
    ["fig3", "fig4a", "fig4b", "fig4c", "fig4d", "fig4e", "city", "sphere", "mesh", "city-1000000"];
const FILES: [&str; 2] = ["compare.csv", "peers.md"];

/// Compare with Embree 4, obvhs, parry3d, bvh and tinybvh on the same rays: answers and leaks, then time
///
/// Needs a program built with `--features peers`, or with `--features tinybvh` for all five, which takes a C++20
/// compiler. Without --scenes: fig3, fig4a to fig4e, city, sphere, mesh, city-1000000.
#[derive(Args)]
pub struct Peers {
    #[command(flatten)]
    scenes: SceneChoice,
    /// Only these libraries: embree4-medium, embree4-high, embree4-robust, embree4-compact, obvhs, parry3d, bvh,
    /// tinybvh
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    against: Vec<String>,
    /// These indices of ours; the first is held against the others in peers.md. In the tables, `bvh` is the crate and
    /// `arboleda-bvh` is ours [default: wide-bvh,wide-bvh-hierarchy,bvh,octree-hierarchy]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    index: Vec<String>,
    /// Rays in each mode
    #[arg(long, value_name = "N", default_value_t = 500_000, value_parser = whole::<usize>(1..=MOST_RAYS))]
    rays: usize,
    /// Rays from inside each scene that is a closed mesh; each of them that hits nothing is a leak
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = whole::<usize>(0..=MOST_RAYS))]
    leak_rays: usize,
    #[command(flatten)]
    repeat: RepeatArguments,
    /// Also compare the first of ours with Embree on meshes and cities of 1,000 to N triangles, ten times as many each
    /// step; N is 10000000 if it is left out
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "10000000",
        value_parser = whole::<u32>(1000..=10_000_000))]
    growth: Option<u32>,
    /// Write compare.csv and peers.md to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Peers {
    /// Runs the command. Names are looked up before a scene is made.
    ///
    /// # Errors
    /// If a name is not known, a scene cannot be indexed, or a file cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        ensure!(
            cfg!(feature = "peers"),
            "this program was built without the other libraries. With them:\n    cargo run --release -p \
             arboleda-host --features peers -- compare peers --out DIR\nor, with a C++20 compiler and \
             tinybvh too, --features tinybvh"
        );
        let (libraries, kinds) = (self.libraries()?, self.kinds()?);
        let folder = self.out.as_deref();
        if let Some(folder) = folder {
            make_folder(folder)?;
        }
        let only_growth = self.growth.is_some() && self.scenes.is_none();
        let models = if only_growth { Vec::new() } else { self.scenes.models(SCENES)? };
        let options = PeerOptions {
            ray_count: self.rays,
            rounds: self.repeat.repetitions,
            leak_ray_count: self.leak_rays,
            seed: self.repeat.seed,
            peers: &libraries,
            kinds: &kinds,
        };
        let provenance = Provenance::gather();
        say!("{}", provenance.line());
        if cfg!(all(target_arch = "x86_64", not(target_feature = "avx2"))) {
            say!(
                "Built without this processor's instructions, the other crates are slower than they \
                 could be: set RUSTFLAGS=\"-C target-cpu=native\""
            );
        }
        let mut findings = Findings {
            command: command(),
            provenance,
            effort: effort(&options),
            ours: kinds.first().map_or("", |&kind| ours::name(kind)),
            comparisons: Vec::new(),
            growth: Vec::new(),
        };

        // 1. The scenes. The files are written after each, for those who do not wait for the last.
        for model in &models {
            let comparison = with_bar(peers::steps(&options), &model.name, |progress| {
                peers::run(model, &options, progress)
            })?;
            let triangles = count(comparison.triangle_count as u64);
            let table = scene_grid(&comparison).terminal();
            say!("\n{}, {triangles} triangles\n{table}", model.name);
            findings.comparisons.push(comparison);
            if findings.comparisons.len() == 1 {
                findings.print_absent();
            }
            findings.write(folder)?;
        }
        if !findings.comparisons.is_empty() {
            say!("\n* fastest, ! ours and slower than Embree; {SCENE_LEGEND}");
        }

        // 2. The same kind of scene, larger and larger.
        if let Some(largest) = self.growth {
            let names = sized_scenes(largest);
            with_bar(names.len() as u64, "growth", |progress| {
                for name in &names {
                    let model = builtin::require(name)?;
                    findings.growth.push(peers::run_briefly(&model, &options)?);
                    findings.write(folder)?;
                    progress();
                }
                anyhow::Ok(())
            })?;
            let table = growth_grid(&findings.growth).terminal();
            say!("\ngrowth\n{table}\n{GROWTH_LEGEND}");
        }

        // 3. Who was not there.
        findings.print_absent();
        if let Some(folder) = folder {
            let [rows, page] = FILES.map(|name| folder.join(name));
            log::info!("measurements: {}, page: {}", rows.display(), page.display());
        }
        Ok(())
    }

    fn libraries(&self) -> anyhow::Result<Vec<Peer>> {
        let find = |name: &String| {
            let found = PEERS.iter().find(|peer| peer.name == name).copied();
            found.with_context(|| PeerError::unknown(name))
        };
        if self.against.is_empty() {
            return Ok(PEERS.to_vec());
        }
        self.against.iter().map(find).collect()
    }

    fn kinds(&self) -> anyhow::Result<Vec<IndexKind>> {
        if self.index.is_empty() {
            return Ok(USUAL_KINDS.to_vec());
        }
        let mut kinds = Vec::new();
        for name in &self.index {
            let Some(kind) = kind_by_name(name) else {
                let names = kind_names().collect::<Vec<_>>().join(", ");
                bail!("there is no index {name:?}; there are {names}");
            };
            kinds.push(kind);
        }
        Ok(kinds)
    }
}

fn effort(options: &PeerOptions<'_>) -> String {
    format!(
        "{} rays of photons in each mode, {} rounds, seed {}; {} rays from inside closed meshes",
        count(options.ray_count as u64),
        options.rounds,
        options.seed,
        count(options.leak_ray_count as u64)
    )
}

/// Writes how this program was called, as `cargo run` would.
fn command() -> String {
    let feature = if cfg!(feature = "tinybvh") { "tinybvh" } else { "peers" };
    let arguments = std::env::args().skip(1).collect::<Vec<_>>().join(" ");
    format!("cargo run --release -p arboleda-host --features {feature} -- {arguments}")
}

/// Comparisons so far, and what they come from.
struct Findings<'f> {
    command: String,
    provenance: Provenance,
    effort: String,
    ours: &'f str,
    comparisons: Vec<PeerComparison>,
    growth: Vec<PeerComparison>,
}

impl Findings<'_> {
    fn print_absent(&self) {
        let all: Vec<&PeerComparison> = self.comparisons.iter().chain(&self.growth).collect();
        for line in absent(&all) {
            say!("{line}");
        }
    }

    fn write(&self, folder: Option<&Path>) -> anyhow::Result<()> {
        let Some(folder) = folder else {
            return Ok(());
        };
        let [rows, page] = FILES.map(|name| folder.join(name));
        let all = self.comparisons.iter().chain(&self.growth);
        write_csv(&rows, all.flat_map(|comparison| &comparison.rows))?;
        let text = peers_page(&PeersEvidence {
            command: &self.command,
            provenance: &self.provenance,
            effort: &self.effort,
            ours: self.ours,
            comparisons: &self.comparisons,
            growth: &self.growth,
        });
        write_file(&page, |file| file.write_all(text.as_bytes()))
    }
}
