//! The hierarchy: a cluster tree above local indices.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use super::ordered_traversal::{near_first, walk_near_first};
use crate::cluster::{MAX_TREE_DEPTH, bounds_of};
use crate::error::BuildError;
use crate::geometry::{RaySpan, Span};
use crate::input::{Executor, Options, SimdLevel};
use crate::memory::Words;
use crate::query::Query;
use crate::structure::{
    ClusterBuild, DividedScene, Group, Local, LocalIndex, Representation, Sections, Statistics,
    Structure,
};

/// Hierarchy: a structure `S` over the clusters of the scene.
///
/// `Clustered<Octree>` is the octree hierarchy of the paper: an octree for each cluster, below a binary tree of the
/// clusters.
pub struct Clustered<S>(PhantomData<S>);

impl<S: Structure> Representation for Clustered<S> {
    type Structure = S;
    const CLUSTERED: bool = true;
    const NAME: &'static str = S::HIERARCHY_NAME;
}

impl<L: LocalIndex> Structure for L {
    const READS_TREE: bool = false;
    const BUILD_CLUSTER: Option<ClusterBuild> = Some(L::build);

    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        L::scratch_bytes(triangle_count, options)
    }

    fn build(
        division: DividedScene<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
        _: &impl Executor,
    ) -> Result<(), BuildError> {
        let DividedScene { triangles, rays, clusters, nodes } = division;
        let mut leaves = nodes.iter_mut();
        for ids in clusters.iter() {
            let first = words.len();
            let leaf = leaves.next();
            let bounds = leaf.as_ref().map(|leaf| leaf.bounds);
            let bounds = bounds.unwrap_or_else(|| bounds_of(triangles, ids));
            L::build(&Group { triangles, rays, ids, bounds }, options, words, scratch)?;
            if let Some(leaf) = leaf {
                leaf.links = [first as u32, (words.len() - first) as u32];
            }
        }
        Ok(())
    }

    #[inline]
    fn traverse<Q: Query>(sections: &Sections<'_>, simd_level: SimdLevel, query: &mut Q) {
        // Both outcomes end the traversal; the query knows the answer.
        let (ControlFlow::Continue(()) | ControlFlow::Break(())) =
            walk::<L, Q>(sections, simd_level, query);
    }

    fn check(sections: &Sections<'_>) -> Result<Statistics, u32> {
        let mut sum = Statistics::default();
        for (cluster, leaf) in (0..sections.cluster_count()).zip(sections.nodes()) {
            sum = sum
                .joined(L::check(&Local::of(sections, leaf, SimdLevel::COMPILED)).ok_or(cluster)?);
        }
        Ok(sum)
    }
}

/// Traverses the cluster tree, and the local index of every cluster whose box the ray enters.
///
/// Children whose boxes the ray meets are entered, the nearer first; of two at the same distance, the left first. A
/// node is skipped only if it begins beyond [`RaySpan::last`].
///
/// # Source
/// Aguilera et al., algorithms 3 and 4; nearest first is an addition.
fn walk<L: LocalIndex, Q: Query>(
    sections: &Sections<'_>,
    simd_level: SimdLevel,
    query: &mut Q,
) -> ControlFlow<()> {
    const DEPTH: usize = MAX_TREE_DEPTH + 2;
    let Some(root) = sections.nodes().last() else {
        return ControlFlow::Continue(());
    };
    let ray = &RaySpan::new(query.ray(), &root.bounds);
    let nodes = sections.nodes();
    let clip = |id: u32, span: Span| {
        let node = nodes.get(id as usize)?;
        let span = ray.clip(&node.bounds, span);
        (!span.is_empty()).then_some((id, span))
    };
    let Some(root) = clip(nodes.len() as u32 - 1, ray.whole()) else {
        return ControlFlow::Continue(());
    };
    walk_near_first::<DEPTH, _, _>(root, ray, query, |id, span, query| {
        let Some(node) = nodes.get(id as usize) else {
            return ControlFlow::Continue((None, None));
        };
        if id < sections.cluster_count() {
            L::traverse(&Local::of(sections, node, simd_level), ray, span, query)?;
            return ControlFlow::Continue((None, None));
        }
        let [left, right] = node.links.map(|id| clip(id, span));
        ControlFlow::Continue(near_first(left, right))
    })
}
