//! Picture of a model's clusters.

use arboleda::{Block, IndexKind, Options, Scene, Vec3, clusters as cluster};

use crate::TimedIndex;
use crate::commands::arguments::unbuilt;
use crate::commands::output::count;
use crate::report::{Canvas, paint_clusters};
use crate::scene::Model;

/// Allocates the scratch memory in which the clusters of a model are found.
pub fn cluster_scratch(model: &Model) -> Vec<Block> {
    vec![Block::ZERO; Block::count(cluster::scratch_capacity(model.triangles.len()))]
}

/// Paints the clusters of a model and returns the picture's title. `scene` is the model as indices see it.
///
/// # Errors
/// If the scene cannot be indexed.
pub fn paint_model(
    canvas: &mut Canvas,
    model: &Model,
    scene: &Scene<'_>,
    options: &Options,
    up: Vec3,
) -> anyhow::Result<String> {
    let mut scratch = cluster_scratch(model);
    let clusters = cluster::find(scene, options, Block::bytes(&mut scratch));
    let clusters = clusters.map_err(|error| unbuilt(&error))?;
    let mut cluster_of = vec![0; model.triangles.len()];
    for (number, ids) in (0..).zip(clusters.iter()) {
        for &id in ids {
            cluster_of[id as usize] = number;
        }
    }
    let (cluster_count, class_count) = (clusters.count() as u64, clusters.class_count());
    let title = format!(
        "{}: {} triangles, {} cluster{} in {class_count} size class{}",
        model.name,
        count(model.triangles.len() as u64),
        count(cluster_count),
        if cluster_count == 1 { "" } else { "s" },
        if class_count == 1 { "" } else { "es" },
    );
    let owned = TimedIndex::build(IndexKind::BvhHierarchy, scene, options);
    let owned = owned.map_err(|error| unbuilt(&error))?;
    let index = owned.index();
    paint_clusters(
        canvas,
        index.as_ray_index(),
        &model.triangles,
        index.cluster_tree(),
        &cluster_of,
        up,
        &title,
    );
    Ok(title)
}
