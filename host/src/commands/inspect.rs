//! `arboleda inspect`: what a scene consists of, and how an index sees it.

use std::path::PathBuf;

use arboleda::cluster::{self, Clusters};
use arboleda::memory::Image;
use arboleda::{Aabb, Block, IndexKind, RayIndex};
use clap::Args;

use super::arguments::{BuildArguments, IndexChoice, SceneArguments};
use super::output::{bytes, count, duration, say, table};
use crate::OwnedIndex;
use crate::report::{Canvas, paint_clusters};
use crate::scene::{Census, Model};

/// Clusters with a row of their own in the table.
const ROWS: usize = 12;
/// What is shown beside the index that was chosen: the paper's, and what it is compared with.
pub const ALWAYS: [IndexKind; 2] = [IndexKind::OctreeHierarchy, IndexKind::Octree];

#[derive(Args)]
pub struct Inspect {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    build: BuildArguments,
    #[command(flatten)]
    index: IndexChoice,
    /// The picture of the clusters, their boxes and the cluster tree [default: NAME.clusters.png]
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// Pixels across and down
    #[arg(long, num_args = 2, value_names = ["WIDTH", "HEIGHT"], default_values_t = [1280, 900])]
    size: Vec<u32>,
}

impl Inspect {
    /// Runs the command.
    ///
    /// # Errors
    /// If the scene cannot be loaded or the picture not be written.
    pub fn run(&self) -> anyhow::Result<()> {
        let model = self.scene.load()?;
        let path = match &self.picture {
            Some(path) => path.clone(),
            None => PathBuf::from(format!("{}.clusters.png", model.name)),
        };
        let up = self.scene.up.vector(&model);
        let (scene, options) = (self.build.scene(&model), self.build.options());
        let mut kinds = self.index.kinds(&scene, &options)?;
        for kind in ALWAYS {
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        let mut canvas = Canvas::new(self.size[0].max(64), self.size[1].max(64));
        describe(&model, &self.build, &kinds, |index, image, cluster_of| {
            paint_clusters(&mut canvas, index, &model.triangles, image, cluster_of, up);
        })?;
        canvas.save(&path)?;
        say!("picture: {}", path.display());
        Ok(())
    }
}

/// Prints what a scene consists of and how large the indices are, and hands the octree hierarchy to `paint` with the cluster of each
/// triangle.
///
/// # Errors
/// If an option is out of range.
pub fn describe(
    model: &Model,
    build: &BuildArguments,
    kinds: &[IndexKind],
    paint: impl FnOnce(&(dyn RayIndex + Sync), &Image<'_>, &[u32]),
) -> anyhow::Result<()> {
    let scene = build.scene(model);
    let options = build.options();
    let bounds = model.bounds();
    say!(
        "{}: {} triangles in {} objects, {} light{}",
        model.name,
        count(model.triangles.len() as u64),
        count(model.object_names.len() as u64),
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

    let mut scratch =
        vec![Block::ZERO; Block::count(cluster::scratch_capacity(model.triangles.len()))];
    let start = std::time::Instant::now();
    let clusters = cluster::find(&scene, &options, Block::bytes(&mut scratch))?;
    let seconds = start.elapsed().as_secs_f64();
    say!(
        "clusters: {} in {} size class{}, found in {}",
        count(clusters.count() as u64),
        clusters.class_count(),
        if clusters.class_count() == 1 { "" } else { "es" },
        duration(seconds),
    );
    say!("{}", cluster_table(model, &clusters));

    let mut memory =
        table(&["index", "bytes", "B/triangle", "nodes", "leaves", "references", "level", "build"]);
    for &kind in kinds {
        let owned = OwnedIndex::build(kind, &scene, &options)?;
        let index = owned.index();
        let parts = index.check()?;
        memory.add_row([
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
            let image = index.image();
            say!("cluster tree: {} nodes, depth {}", image.nodes().len(), depth(image));
        }
    }
    say!("{memory}");

    let owned = OwnedIndex::build(IndexKind::OctreeHierarchy, &scene, &options)?;
    let index = owned.index();
    let mut cluster_of = vec![0; model.triangles.len()];
    for (number, ids) in (0..).zip(clusters.iter()) {
        for &id in ids {
            cluster_of[id as usize] = number;
        }
    }
    paint(index.as_ray_index(), index.image(), &cluster_of);
    Ok(())
}

/// The largest clusters, by triangles.
fn cluster_table(model: &Model, clusters: &Clusters<'_>) -> comfy_table::Table {
    let mut largest: Vec<(usize, &[u32])> = clusters.iter().enumerate().collect();
    largest.sort_by_key(|(number, ids)| (std::cmp::Reverse(ids.len()), *number));
    let mut rows = table(&["cluster", "class", "triangles", "size", "first object"]);
    for &(number, ids) in largest.iter().take(ROWS) {
        let bounds = ids
            .iter()
            .fold(Aabb::EMPTY, |all, &id| all.union(model.triangles[id as usize].bounds()));
        let [x, y, z] = bounds.extent();
        let object = model.objects[ids[0] as usize] as usize;
        rows.add_row([
            number.to_string(),
            clusters.classes()[number].to_string(),
            count(ids.len() as u64),
            format!("{x:.4} x {y:.4} x {z:.4}"),
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

/// The length of the longest way from the root to a leaf.
fn depth(image: &Image<'_>) -> u32 {
    let nodes = image.nodes();
    let mut depths = vec![0_u32; nodes.len()];
    for at in (0..nodes.len().saturating_sub(1)).rev() {
        depths[at] = depths[nodes[at].parent.0 as usize] + 1;
    }
    depths.into_iter().max().unwrap_or(0)
}
