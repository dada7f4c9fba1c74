//! `arboleda compare --peers`: other people's libraries on the same rays.

#[cfg(not(feature = "peers"))]
use std::path::Path;

use clap::Args;

use super::values::whole;
#[cfg(not(feature = "peers"))]
use crate::scene::Model;

/// The most rays of a mode: each is kept, with the answers of every contender.
const MOST_RAYS: u64 = 100_000_000;

/// Which libraries and which of ours.
#[derive(Args)]
pub struct PeerArguments {
    /// Compare with Embree 4, obvhs, parry3d, bvh and tinybvh instead: the same rays, answers and leaks
    /// first. Needs a build with `--features peers`, or `tinybvh` for all five (and a C++20 compiler).
    /// With --out, writes compare.csv and peers.md. Scenes if none are named: fig3, fig4a to fig4e, city,
    /// sphere, mesh, city-1000000
    #[arg(long, conflicts_with = "photons")]
    pub peers: bool,
    /// With --peers: only these libraries: embree4-medium, embree4-high, embree4-robust, embree4-compact, obvhs,
    /// parry3d, bvh, tinybvh
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "peers")]
    against: Vec<String>,
    /// With --peers: these indices of ours; the first is the one held against the others in peers.md
    /// [default: wide-bvh,wide-bvh-hierarchy,bvh,octree-hierarchy]; in the tables `bvh` is the crate, ours is
    /// `arboleda-bvh`
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "peers")]
    index: Vec<String>,
    /// With --peers: rays in each mode
    #[arg(long, value_name = "N", default_value_t = 500_000, requires = "peers",
        value_parser = whole::<usize>(1..=MOST_RAYS))]
    rays: usize,
    /// With --peers: rays from inside scenes that are closed meshes, all of which must hit
    #[arg(long, value_name = "N", default_value_t = 1_000_000, requires = "peers",
        value_parser = whole::<usize>(0..=MOST_RAYS))]
    leak_rays: usize,
    /// With --peers: also the first of ours and Embree from 1,000 triangles to N, ten times as many each
    /// step; 10000000 if N is left out
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "10000000", requires = "peers",
        value_parser = whole::<u32>(1000..=100_000_000))]
    pub growth: Option<u32>,
}

/// The scenes if none are named: the paper's, one closed, one large mesh, one that fits no cache.
pub const SCENES: [&str; 10] =
    ["fig3", "fig4a", "fig4b", "fig4c", "fig4d", "fig4e", "city", "sphere", "mesh", "city-1000000"];

#[cfg(feature = "peers")]
pub use with_peers::run;

/// Says how to get a program that can.
///
/// # Errors
/// Always.
#[cfg(not(feature = "peers"))]
pub fn run(
    _: &PeerArguments,
    _: impl FnOnce() -> anyhow::Result<Vec<Model>>,
    _seed: u64,
    _rounds: usize,
    _folder: Option<&Path>,
) -> anyhow::Result<()> {
    anyhow::bail!(
        "this program was built without the other libraries. With them:\n    cargo run --release -p \
         arboleda-host --features peers -- compare --peers --out DIR\nor, with a C++20 compiler and \
         tinybvh too, --features tinybvh"
    )
}

#[cfg(feature = "peers")]
mod with_peers {
    use std::path::Path;

    use anyhow::bail;
    use arboleda::IndexKind;

    use super::super::output::{count, say};
    use super::PeerArguments;
    use crate::bench::progress::step_bar;
    use crate::bench::provenance::Provenance;
    use crate::contenders::{PEERS, Peer, PeerError, ours};
    use crate::file_output::{make_folder, write_file};
    use crate::owned_index::{kind_by_name, kind_names};
    use crate::report::peers_page::{Evidence, absent, page};
    use crate::report::peers_table::{LEGEND, table, write_csv};
    use crate::scene::Model;
    use crate::studies::peers::{self, Comparison, ComparisonOptions, USUAL_KINDS};
    use crate::studies::peers_growth as growth;

    /// Runs the comparison; `models` are asked for once all names are known to be right.
    ///
    /// # Errors
    /// If a name is not known, a scene cannot be indexed, or a file cannot be written.
    pub fn run(
        arguments: &PeerArguments,
        models: impl FnOnce() -> anyhow::Result<Vec<Model>>,
        seed: u64,
        rounds: usize,
        folder: Option<&Path>,
    ) -> anyhow::Result<()> {
        let (libraries, kinds) = (arguments.libraries()?, arguments.kinds()?);
        if let Some(folder) = folder {
            make_folder(folder)?;
        }
        let models = models()?;
        let options = ComparisonOptions {
            ray_count: arguments.rays,
            rounds,
            leak_ray_count: arguments.leak_rays,
            seed,
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
        let mut run = Run {
            command: command(),
            provenance,
            effort: effort(&options),
            ours: kinds.first().map_or("", |&kind| ours::name(kind)),
            comparisons: Vec::new(),
            growth: Vec::new(),
        };

        // 1. The scenes. The files are written after each, for those who do not wait for the last.
        for model in &models {
            let bar = step_bar(peers::steps(&options), &model.name);
            let comparison = peers::compare(model, &options, &mut || bar.inc(1))?;
            bar.finish_and_clear();
            let triangles = count(comparison.triangle_count as u64);
            say!("\n{}, {triangles} triangles\n{}", model.name, table(&comparison));
            run.comparisons.push(comparison);
            if run.comparisons.len() == 1 {
                run.print_absent();
            }
            run.write(folder)?;
        }
        if !run.comparisons.is_empty() {
            say!("\n* fastest, ! ours and slower than Embree; {LEGEND}");
        }

        // 2. The same kind of scene, larger and larger.
        if let Some(largest) = arguments.growth {
            let bar = step_bar(growth::scene_count(largest) as u64, "growth");
            for model in growth::scenes(largest) {
                run.growth.push(growth::one(&model, &options)?);
                run.write(folder)?;
                bar.inc(1);
            }
            bar.finish_and_clear();
            say!("\ngrowth\n{}\n{}", growth::table(&run.growth), growth::LEGEND);
        }

        // 3. Who was not there.
        run.print_absent();
        if let Some(folder) = folder {
            let [rows, page] = FILES.map(|name| folder.join(name));
            log::info!("measurements: {}, page: {}", rows.display(), page.display());
        }
        Ok(())
    }

    impl PeerArguments {
        fn libraries(&self) -> anyhow::Result<Vec<Peer>> {
            let find = |name: &String| {
                let found = PEERS.iter().find(|peer| peer.name == name).copied();
                found.ok_or_else(|| PeerError::unknown(name).into())
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

    fn effort(options: &ComparisonOptions<'_>) -> String {
        format!(
            "{} rays of photons in each mode, {} rounds, seed {}; {} rays from inside closed meshes",
            count(options.ray_count as u64),
            options.rounds,
            options.seed,
            count(options.leak_ray_count as u64)
        )
    }

    /// How this program was called, as `cargo run` would.
    fn command() -> String {
        let feature = if cfg!(feature = "tinybvh") { "tinybvh" } else { "peers" };
        let arguments = std::env::args().skip(1).collect::<Vec<_>>().join(" ");
        format!("cargo run --release -p arboleda-host --features {feature} -- {arguments}")
    }

    const FILES: [&str; 2] = ["compare.csv", "peers.md"];

    /// What came of it so far.
    struct Run<'r> {
        command: String,
        provenance: Provenance,
        effort: String,
        ours: &'r str,
        comparisons: Vec<Comparison>,
        growth: Vec<Comparison>,
    }

    impl Run<'_> {
        fn print_absent(&self) {
            let all: Vec<&Comparison> = self.comparisons.iter().chain(&self.growth).collect();
            for line in absent(&all) {
                say!("{line}");
            }
        }

        fn write(&self, folder: Option<&Path>) -> anyhow::Result<()> {
            let Some(folder) = folder else {
                return Ok(());
            };
            let [rows, page_file] = FILES.map(|name| folder.join(name));
            let all = self.comparisons.iter().chain(&self.growth);
            let mut text = Vec::new();
            write_csv(&mut text, all.flat_map(|comparison| &comparison.rows))?;
            write_file(&rows, |file| file.write_all(&text))?;
            let text = page(&Evidence {
                command: &self.command,
                provenance: &self.provenance,
                effort: &self.effort,
                ours: self.ours,
                comparisons: &self.comparisons,
                growth: &self.growth,
            });
            write_file(&page_file, |file| file.write_all(text.as_bytes()))
        }
    }
}
