//! `arboleda inspect`: contents of a scene, its clusters, and the sizes of indices over it.

use std::path::PathBuf;

use anyhow::ensure;
use arboleda::clusters::Clusters;
use arboleda::{Aabb, Block, IndexKind, clusters as cluster};
use clap::Args;

use super::arguments::values::{PIXELS, file_ending_in, whole};
use super::arguments::{BuildArguments, IndexChoice, SceneArguments, unbuilt};
use super::output::cluster_picture::{cluster_scratch, paint_model};
use super::output::{bytes, count, duration, say, table};
use super::pack::describe_file;
use crate::TimedIndex;
use crate::benchmark::harness::progress::during;
use crate::files::output::check_writable;
use crate::report::{Canvas, four_decimals};
use crate::scene::{Census, Model};

/// Most clusters with a row of their own in the table.
const ROWS: usize = 12;
/// Indices shown beside the chosen one: the paper's octree hierarchy, and the octree that the paper compares it with.
pub const ALWAYS: [IndexKind; 2] = [IndexKind::OctreeHierarchy, IndexKind::Octree];

/// Show the clusters of a scene, the cluster tree, and levels and memory of indices; with --picture, paint the clusters
///
/// Of a file X.arb that `pack` wrote: the index, its nodes, and its BLAKE3 hash.
#[derive(Args)]
pub struct Inspect {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    build: BuildArguments,
    #[command(flatten)]
    index: IndexChoice,
    /// Write a picture of the clusters, their bounding boxes and the cluster tree
    #[arg(long, value_name = "FILE.png", value_parser = file_ending_in(&["png"]))]
    picture: Option<PathBuf>,
    /// Width and height of the picture in pixels, 64 to 8192
    #[arg(long, num_args = 2, value_names = ["WIDTH", "HEIGHT"], default_values_t = [1280, 900],
        value_parser = whole::<u32>(PIXELS))]
    size: Vec<u32>,
}

impl Inspect {
    /// Runs the command.
    ///
    /// # Errors
    /// If the scene cannot be loaded, an index cannot be built, or the picture cannot be written.
    pub fn run(&self) -> anyhow::Result<()> {
        if let Some(path) = self.scene.index_file(&self.build)? {
            ensure!(
                self.picture.is_none(),
                "--picture paints the clusters of a scene, not of an index"
            );
            return describe_file(path);
        }
        if let Some(path) = &self.picture {
            check_writable(path)?;
        }
        let model = self.scene.load()?;
        let (scene, options) = (self.build.scene(&model), self.build.options());
        let mut kinds = self.index.kinds(&scene, &options)?;
        for kind in ALWAYS {
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        describe(&model, &self.build, &kinds)?;
        if let Some(path) = &self.picture {
            let mut canvas = Canvas::new(self.size[0], self.size[1]);
            let up = self.scene.up.vector(&model);
            during("painting", || {
                paint_model(&mut canvas, &model, &scene, &options, up)?;
                canvas.save(path)
            })?;
            log::info!("picture: {}", path.display());
        } else {
            log::info!("add --picture FILE.png for a picture");
        }
        Ok(())
    }
}

/// Prints the contents of a scene, its largest clusters, and the sizes of indices.
///
/// # Errors
/// If an option is out of range.
pub fn describe(model: &Model, build: &BuildArguments, kinds: &[IndexKind]) -> anyhow::Result<()> {
    let scene = build.scene(model);
    let options = build.options();
    let bounds = model.bounds();
    say!(
        "{}: {} triangles in {} object{}, {} light{}",
        model.name,
        count(model.triangles.len() as u64),
        count(model.object_names.len() as u64),
        if model.object_names.len() == 1 { "" } else { "s" },
        model.lights.len(),
        if model.lights.len() == 1 { "" } else { "s" },
    );
    say!("{}", Census::of(model));
    if !bounds.is_empty() {
        say!("box: {} to {}", bounds.lo, bounds.hi);
    }
    if model.origin != [0.0; 3] {
        let [x, y, z] = model.origin;
        say!("origin: {x},{y},{z} was subtracted; add it to get the file's coordinates");
    }

    let mut scratch = cluster_scratch(model);
    let start = std::time::Instant::now();
    let memory = Block::bytes(&mut scratch);
    let clusters = during("finding clusters", || cluster::find(&scene, &options, memory))
        .map_err(|error| unbuilt(&error))?;
    let seconds = start.elapsed().as_secs_f64();
    say!(
        "clusters: {} in {} size class{}, found in {}",
        count(clusters.count() as u64),
        clusters.class_count(),
        if clusters.class_count() == 1 { "" } else { "es" },
        duration(seconds),
    );
    say!("{}", cluster_table(model, &clusters));

    let mut sizes =
        table(&["index", "bytes", "B/triangle", "nodes", "leaves", "references", "level", "build"]);
    for &kind in kinds {
        let build = || TimedIndex::build(kind, &scene, &options);
        let owned =
            during(&format!("building {}", kind.name()), build).map_err(|error| unbuilt(&error))?;
        let index = owned.index();
        let parts = index.check()?;
        sizes.add_row([
            kind.name().to_owned(),
            bytes(owned.bytes()),
            format!("{:.0}", owned.bytes() as f64 / model.triangles.len().max(1) as f64),
            count(parts.inner_nodes),
            count(parts.leaves),
            count(parts.references),
            parts.deepest_level.to_string(),
            duration(owned.build_seconds()),
        ]);
        if kind == IndexKind::OctreeHierarchy {
            let tree = index.cluster_tree();
            say!("cluster tree: {} nodes, depth {}", tree.len(), tree.depth());
        }
    }
    say!("{sizes}");

    Ok(())
}

/// Makes a table of the clusters with the most triangles.
fn cluster_table(model: &Model, clusters: &Clusters<'_>) -> comfy_table::Table {
    let mut largest: Vec<(usize, &[u32])> = clusters.iter().enumerate().collect();
    largest.sort_by_key(|(number, ids)| (std::cmp::Reverse(ids.len()), *number));
    let mut rows = table(&["cluster", "class", "triangles", "size", "first object"]);
    for &(number, ids) in largest.iter().take(ROWS) {
        let bounds = ids
            .iter()
            .fold(Aabb::EMPTY, |all, &id| all.union(model.triangles[id as usize].bounds()));
        let [x, y, z] = bounds.extent().map(four_decimals);
        let object = model.objects[ids[0] as usize] as usize;
        rows.add_row([
            number.to_string(),
            clusters.classes()[number].to_string(),
            count(ids.len() as u64),
            format!("{x} x {y} x {z}"),
            model.object_names.get(object).cloned().unwrap_or_default(),
        ]);
    }
    if clusters.count() > ROWS {
        let rest: usize = largest.iter().skip(ROWS).map(|(_, ids)| ids.len()).sum();
        let label = format!("{} more", clusters.count() - ROWS);
        rows.add_row([label, String::new(), count(rest as u64), String::new(), String::new()]);
    }
    rows
}
