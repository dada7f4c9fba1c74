//! Clustering: from triangles to clusters, and from clusters to one binary tree.
//!
//! ```text
//! primitives --size_class--> at most 4 classes
//!            --corners-----> fragments: those of a class that share corners
//!            --proximity---> connected components = clusters
//! clusters   --join--------> in rounds, the closest two are joined --> one root
//! ```
//! A primitive is a triangle, or a whole object where the scene names objects. One cluster, one cluster for each
//! triangle and no cluster at all are valid results, not errors.
//!
//! # Source
//! F. Cazals, G. Drettakis, C. Puech, *Filtering, Clustering and Hierarchy Construction*, 1995, for
//! the two steps; N. Aguilera et al., *Representaciones Espaciales Para Escenas Constituidas
//! Mediante Agrupaciones de Objetos*, for the tree.

mod box_tree;
mod corners;
mod dual_join;
mod join;
mod near;
mod node;
mod proximity;
mod size_class;
mod tree;
mod union_find;

use crate::error::BuildError;
use crate::geometry::{Aabb, Box4};
use crate::input::{Executor, Mesh, Options, Scene, Sequential};
use crate::memory::{Arena, put, size_of_slice};
use dual_join::{Join, JoinAll, Part};
use size_class::MOST_CLASSES;

pub(crate) use join::join_bytes;
pub use node::{ClusterNode, NodeId};
pub use tree::{ClusterTree, TreeNode};

/// Largest depth of a cluster tree. Joining halves the number of nodes in each round, so 2^30 triangles need 30 rounds.
pub(crate) const MAX_TREE_DEPTH: usize = 30;

/// Partition of the triangles into clusters. Clusters are numbered in the order of their lowest triangle.
#[derive(Debug)]
pub struct Clusters<'s> {
    order: &'s [u32],
    ends: &'s [u32],
    classes: &'s [u32],
    class_count: u32,
    is_cut_short: bool,
}

impl Clusters<'_> {
    /// The number of clusters.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// The number of nodes of the tree over the clusters.
    pub(crate) fn node_count(&self) -> usize {
        (2 * self.count()).saturating_sub(1)
    }

    /// The number of triangles in all clusters.
    pub fn triangle_count(&self) -> usize {
        self.order.len()
    }

    /// The number of size classes that the primitives fell into; 0 for an empty scene.
    pub fn class_count(&self) -> u32 {
        self.class_count
    }

    /// True if the search ended at the bound of its work, so that some primitives which are near each other may be in
    /// two clusters. See [`find`].
    pub fn is_cut_short(&self) -> bool {
        self.is_cut_short
    }

    /// The size class of each cluster; 0 is the class of the smallest primitives.
    pub fn classes(&self) -> &[u32] {
        self.classes
    }

    /// The triangle ids of each cluster, ascending, in the order of the clusters.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let first = core::mem::replace(&mut start, end);
            self.order.get(first as usize..end as usize).unwrap_or(&[])
        })
    }

    /// The triangle ids of one cluster, ascending; empty if there is no such cluster.
    pub fn get(&self, cluster: usize) -> &[u32] {
        let start = cluster.checked_sub(1).map_or(Some(0), |before| self.ends.get(before).copied());
        let ends = start.zip(self.ends.get(cluster).copied());
        ends.and_then(|(start, end)| self.order.get(start as usize..end as usize)).unwrap_or(&[])
    }
}

/// Makes the tree over clusters, in as many nodes as [`Clusters::node_count`] says. `None` if the scratch is below
/// [`join_bytes`].
pub(crate) fn make_tree(
    triangles: Mesh<'_>,
    clusters: &Clusters<'_>,
    nodes: &mut [ClusterNode],
    scratch: &mut [u8],
) -> Option<()> {
    for (leaf, ids) in nodes.iter_mut().zip(clusters.iter()) {
        let bounds = bounds_of(triangles, ids);
        *leaf = ClusterNode { bounds, links: [0; 2], parent: NodeId::NONE };
    }
    join::join(nodes, clusters.count(), scratch)
}

/// The smallest box around some triangles.
pub(crate) fn bounds_of(triangles: Mesh<'_>, ids: &[u32]) -> Aabb {
    let boxes = ids.iter().filter_map(|&id| triangles.get(id)).map(|one| Box4::of_triangle(&one));
    boxes.fold(Box4::EMPTY, Box4::union).aabb()
}

/// The scratch bytes that [`find`] needs for `triangle_count` triangles.
pub const fn scratch_capacity(triangle_count: usize) -> usize {
    size_of_slice::<u32>(triangle_count)
        .saturating_add(division_bytes(triangle_count))
        .saturating_add(detect_bytes(triangle_count))
}

/// Finds the clusters of a scene.
///
/// Two primitives are in one cluster if they are of one size class, and a chain of primitives leads from one to the other
/// in which each box is at most `delta` from the next: [`Options::proximity`] times the median box diagonal of the class.
///
/// The result depends on the scene, `Options::proximity` and [`Options::size_classes`] only. Cost: near-linear, by
/// sorting and a tree of boxes; at most a multiple of `n log n`, which [`Options::work_limit`] does not count. Where long
/// boxes cross in layers that are further apart than `delta`, by the ten thousand, the tree tells too little. There the
/// search ends at its bound, and [`Clusters::is_cut_short`]. No hit depends on the clusters.
///
/// # Errors
/// [`BuildError::ScratchFull`] below [`scratch_capacity`] bytes, [`BuildError::Misaligned`], and the errors of the
/// scene and the options: [`BuildError::Mesh`], [`BuildError::ObjectsMismatch`], [`BuildError::ObjectOutOfRange`],
/// [`BuildError::InvalidOption`].
pub fn find<'s>(
    scene: &Scene<'_>,
    options: &Options,
    scratch: &'s mut [u8],
) -> Result<Clusters<'s>, BuildError> {
    find_with(scene, options, scratch, &Sequential)
}

/// Finds the clusters of a scene, as [`find`] does and with the same result, with the help of an executor.
///
/// Boxes are compared in branches that may run in parallel; sizes and corners are not.
///
/// # Errors
/// The errors of [`find`].
pub fn find_with<'s>(
    scene: &Scene<'_>,
    options: &Options,
    scratch: &'s mut [u8],
    executor: &impl Executor,
) -> Result<Clusters<'s>, BuildError> {
    scene.check()?;
    options.check()?;
    let (needed, given) = (scratch_capacity(scene.triangles.len()), scratch.len());
    let full = BuildError::ScratchFull { needed, given };
    if given < needed {
        return Err(full);
    }
    let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
    let classes = arena.take::<u32>(scene.triangles.len()).ok_or(full)?;
    Ok(detect(scene, options, classes, arena, executor).ok_or(full)?.0)
}

/// Scratch bytes that a partition of `triangle_count` triangles occupies as long as it is used, without the classes.
pub(crate) const fn division_bytes(triangle_count: usize) -> usize {
    size_of_slice::<u32>(triangle_count).saturating_mul(2)
}

/// Scratch bytes that the partition into a single cluster occupies.
pub(crate) const fn whole_bytes(triangle_count: usize) -> usize {
    size_of_slice::<u32>(triangle_count).saturating_add(size_of_slice::<u32>(1))
}

/// Scratch bytes that [`detect`] needs in addition to the partition.
pub(crate) const fn detect_bytes(count: usize) -> usize {
    size_of_slice::<Aabb>(count)
        .saturating_add(size_of_slice::<u32>(count))
        .saturating_add(proximity::scratch_bytes(count))
}

/// Makes the partition into a single cluster (none for an empty scene), and returns the scratch that is left.
pub(crate) fn whole<'s>(
    scene: &Scene<'_>,
    mut arena: Arena<'s>,
) -> Option<(Clusters<'s>, &'s mut [u8])> {
    let count = scene.triangles.len();
    let order = arena.take::<u32>(count)?;
    let ends = arena.take::<u32>(count.min(1))?;
    for (id, slot) in (0..).zip(order.iter_mut()) {
        *slot = id;
    }
    ends.fill(count as u32);
    let class_count = ends.len() as u32;
    let clusters = Clusters { order, ends, classes: &[], class_count, is_cut_short: false };
    Some((clusters, arena.into_rest()))
}

/// Finds the clusters as [`find`] does, and returns the scratch that is left. `None` if the scratch is too small.
/// `classes` is empty if the caller needs none, else as long as there are triangles.
pub(crate) fn detect<'s>(
    scene: &Scene<'_>,
    options: &Options,
    classes: &'s mut [u32],
    mut arena: Arena<'s>,
    executor: &impl Executor,
) -> Option<(Clusters<'s>, &'s mut [u8])> {
    let count = scene.triangles.len();
    let order = arena.take::<u32>(count)?;
    let ends = arena.take::<u32>(count)?;
    let rest = arena.into_rest();
    // Only this depends on the executor: the rest is compiled here, whatever the caller's is, with all that it inlines.
    let join = |join: &Join<'_>, part: &mut Part<'_>| join.all(part, executor);
    let found = divide(scene, options, order, ends, classes, Arena::new(&mut *rest)?, &join)?;
    let ends = ends.get(..found.cluster_count as usize)?;
    let classes = classes.get(..found.cluster_count as usize).unwrap_or_default();
    let Found { class_count, is_cut_short, .. } = found;
    Some((Clusters { order, ends, classes, class_count, is_cut_short }, rest))
}

/// Result of [`divide`].
struct Found {
    cluster_count: u32,
    class_count: u32,
    is_cut_short: bool,
}

/// Fills the lists of a partition, each as long as there are triangles; `classes` may be empty.
///
/// Earlier phases use `order` for the class of each primitive, and `ends` for the primitives of each class.
fn divide(
    scene: &Scene<'_>,
    options: &Options,
    order: &mut [u32],
    ends: &mut [u32],
    classes: &mut [u32],
    mut arena: Arena<'_>,
    join: &JoinAll<'_>,
) -> Option<Found> {
    let triangles = scene.triangles;
    let count = triangles.len();

    // 1. Compute the box of each primitive. An object number that no triangle has keeps the empty box.
    let boxes = arena.take::<Aabb>(count)?;
    let primitive_of = |triangle: usize| match scene.objects {
        Some(objects) => objects.get(triangle).map_or(0, |&object| object as usize),
        None => triangle,
    };
    if scene.objects.is_none() {
        for (bounds, triangle) in boxes.iter_mut().zip(triangles.iter()) {
            *bounds = Box4::of_triangle(&triangle).aabb();
        }
    } else {
        boxes.fill(Aabb::EMPTY);
        for (at, triangle) in triangles.iter().enumerate() {
            if let Some(bounds) = boxes.get_mut(primitive_of(at)) {
                *bounds = Box4::of(bounds).union(Box4::of_triangle(&triangle)).aabb();
            }
        }
    }

    // 2. Divide the primitives into size classes.
    let (class_of, members) = (order, ends);
    let component = arena.take::<u32>(count)?;
    for (id, slot) in (0..).zip(component.iter_mut()) {
        *slot = id;
    }
    let mut scratch = box_tree::Scratch::take(&mut arena, proximity::scratch_bytes(count))?;
    let [keys, buffer] = scratch.keys(count)?;
    let size_classes = size_class::divide(boxes, options, keys, buffer);
    let class_count = size_classes.len() as u32;
    // The members of a class are a run, in which they are listed as they lie in memory.
    let mut ends = [0; MOST_CLASSES];
    let mut sum = 0;
    for (end, class) in ends.iter_mut().zip(&size_classes) {
        *end = sum;
        sum += class.count;
    }
    class_of.fill(0);
    for (id, (bounds, class)) in (0..).zip(boxes.iter().zip(class_of.iter_mut())) {
        if !bounds.is_empty() {
            *class = size_class::class_of(bounds, &size_classes);
            let end = ends.get_mut(*class as usize)?;
            *members.get_mut(*end)? = id;
            *end += 1;
        }
    }

    // 3. Find the connected components of each class.
    let table = scratch.arena()?.take::<u32>(2 * count)?;
    corners::join_at_corners(triangles, primitive_of, class_of, component, table);
    let mut is_cut_short = false;
    for (class, end) in size_classes.iter().zip(ends) {
        let members = members.get_mut(end.checked_sub(class.count)?..end)?;
        let proximity = f64::from(options.proximity);
        let delta_squared = proximity * proximity * class.typical_size_squared;
        is_cut_short |=
            proximity::connect(boxes, members, delta_squared, component, &mut scratch, join)?;
    }

    // 4. Number the components in the order of their lowest triangle, and list the triangles of each.
    let (order, ends) = (class_of, members);
    let number_of: &mut [u32] = bytemuck::must_cast_slice_mut(boxes);
    let number_of = number_of.get_mut(..count)?;
    number_of.fill(u32::MAX);
    union_find::flatten(component);
    let root_of =
        |triangle: usize| component.get(primitive_of(triangle)).map(|&root| root as usize);
    let mut cluster_count = 0;
    ends.fill(0);
    for at in 0..count {
        let root = root_of(at)?;
        let number = number_of.get_mut(root)?;
        if *number == u32::MAX {
            *number = cluster_count;
            let class = *order.get(primitive_of(at))?;
            put(classes, cluster_count as usize, class);
            cluster_count += 1;
        }
        *ends.get_mut(*number as usize)? += 1;
    }
    let mut sum = 0;
    for end in ends.iter_mut().take(cluster_count as usize) {
        sum += core::mem::replace(end, sum);
    }
    for at in 0..count {
        let offset = ends.get_mut(*number_of.get(root_of(at)?)? as usize)?;
        *order.get_mut(*offset as usize)? = at as u32;
        *offset += 1;
    }
    Some(Found { cluster_count, class_count, is_cut_short })
}
