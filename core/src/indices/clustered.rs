//! The cluster tree above the local indices.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use super::{Division, Group, Local, LocalIndex, Statistics, Structure};
use crate::auto::CostModel;
use crate::cluster::MAX_TREE_DEPTH;
use crate::geometry::{RaySpan, Span};
use crate::index::Representation;
use crate::memory::{ClusterNode, Image, NodeId, Words};
use crate::query::Query;
use crate::{BuildError, Options, Vectors};

/// A structure `S` over the clusters of the scene.
///
/// `Clustered<Octree>` is the octree hierarchy of the paper: an octree for each cluster, below a binary
/// tree of the clusters.
pub struct Clustered<S>(PhantomData<S>);

impl<S: Structure> Representation for Clustered<S> {
    type Structure = S;
    const CLUSTERED: bool = true;
    const NAME: &'static str = S::HIERARCHY_NAME;
}

impl<L: LocalIndex> Structure for L {
    const NAME: &'static str = L::NAME;
    const HIERARCHY_NAME: &'static str = L::HIERARCHY_NAME;
    const KIND: u32 = L::KIND;
    const COST: CostModel = L::COST;

    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        L::scratch_bytes(triangle_count, options)
    }

    fn build(
        division: Division<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let triangles = division.triangles;
        for (leaf, ids) in division.nodes.iter_mut().zip(division.clusters.iter()) {
            let first = words.len();
            L::build(&Group { triangles, ids, bounds: leaf.bounds }, options, words, scratch)?;
            leaf.links = [first as u32, (words.len() - first) as u32];
        }
        Ok(())
    }

    #[inline]
    fn traverse<Q: Query>(image: &Image<'_>, _: Vectors, query: &mut Q) -> ControlFlow<()> {
        walk::<L, Q>(image, &RaySpan::new(query.ray()), query)
    }

    fn check(image: &Image<'_>) -> Result<Statistics, u32> {
        let mut sum = Statistics::default();
        for (cluster, leaf) in (0..image.cluster_count()).zip(image.nodes()) {
            sum = sum.joined(L::check(&Local::of(image, leaf)).ok_or(cluster)?);
        }
        Ok(sum)
    }
}

/// Walks the cluster tree, and the local index of every cluster whose box the ray enters.
///
/// Both children are entered if the ray meets both boxes, the nearer first (of two at the same
/// distance, the left). A node is skipped only if it begins beyond [`Query::last`].
///
/// # Source
/// Aguilera et al., algorithms 3 and 4; nearest first is an addition.
fn walk<L: LocalIndex, Q: Query>(
    image: &Image<'_>,
    ray: &RaySpan,
    query: &mut Q,
) -> ControlFlow<()> {
    // Each inner node replaces itself by at most two: one more entry for each level.
    let mut stack = heapless::Vec::<(&ClusterNode, bool, Span), { MAX_TREE_DEPTH + 2 }>::new();
    let is_leaf = |id: u32| id < image.cluster_count();
    let clip = |id: u32, span: Span| {
        let node = image.node(NodeId(id))?;
        let span = ray.clip(&node.bounds, span);
        (!span.is_empty()).then_some((node, is_leaf(id), span))
    };
    let Some(root) = (image.nodes().len() as u32).checked_sub(1) else {
        return ControlFlow::Continue(());
    };
    let mut next = clip(root, ray.whole());
    while let Some((node, leaf, span)) = next.or_else(|| stack.pop()) {
        next = None;
        if span.from > query.last() {
            continue;
        }
        query.enter();
        if leaf {
            L::traverse(&Local::of(image, node), ray, span, query)?;
            continue;
        }
        let [left, right] = node.links;
        let left = clip(left, span);
        let right = clip(right, span);
        let (near, far) = match (left, right) {
            (Some(l), Some(r)) if r.2.from < l.2.from => (right, left),
            (None, _) => (right, None),
            _ => (left, right),
        };
        if let Some(far) = far {
            let pushed = stack.push(far).is_ok();
            debug_assert!(pushed, "validation bounds the depth");
        }
        next = near;
    }
    ControlFlow::Continue(())
}
