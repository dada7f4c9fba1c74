//! The cluster tree as its users see it.

use super::node::{ClusterNode, NodeId};
use crate::geometry::Aabb;

/// Cluster tree of an index: a binary tree whose leaves are the clusters.
///
/// Nodes are numbered from 0, the clusters first and in their order, children before their parents, the root last. A
/// tree over `n` clusters has `2 n - 1` nodes; one without clusters is empty.
///
/// # Examples
/// ```
/// use arboleda::{Block, Index, Options, Scene, Triangle, Vec3};
/// use arboleda::kinds::{Bvh, Clustered};
///
/// let near = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
/// let far = Triangle::new(Vec3::splat(9.0), Vec3::splat(9.0) + Vec3::X, Vec3::splat(9.0) + Vec3::Y);
/// let triangles = [near, far];
/// let (mut arena, mut scratch) = ([Block::ZERO; 16], [Block::ZERO; 64]);
/// let index = Index::<Clustered<Bvh>>::build(
///     &Scene::new(&triangles), &Options::DEFAULT,
///     Block::bytes(&mut arena), Block::bytes(&mut scratch))?;
///
/// let tree = index.cluster_tree();
/// assert_eq!((tree.cluster_count(), tree.depth()), (2, 1));
/// let root = tree.iter().last().expect("two clusters have a root");
/// let [left, _] = root.children.expect("the root joins both");
/// assert_eq!(tree.node(left).map(|cluster| cluster.bounds), Some(near.bounds()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ClusterTree<'a> {
    nodes: &'a [ClusterNode],
    cluster_count: u32,
}

/// Node of a [`ClusterTree`]: a cluster, or the join of two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeNode {
    /// The smallest box around all triangles below.
    pub bounds: Aabb,
    /// The join that the node is part of; `None` for the root.
    pub parent: Option<NodeId>,
    /// The two nodes that were joined; `None` for a cluster, whose number is its id.
    pub children: Option<[NodeId; 2]>,
}

impl<'a> ClusterTree<'a> {
    pub(crate) fn new(nodes: &'a [ClusterNode], cluster_count: u32) -> Self {
        Self { nodes, cluster_count }
    }

    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Tells whether there are no clusters.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The number of clusters.
    pub fn cluster_count(&self) -> u32 {
        self.cluster_count
    }

    /// The node of an id; `None` if there is none.
    pub fn node(&self, id: NodeId) -> Option<TreeNode> {
        let node = self.nodes.get(id.0 as usize)?;
        Some(TreeNode {
            bounds: node.bounds,
            parent: (node.parent != NodeId::NONE).then_some(node.parent),
            children: (id.0 >= self.cluster_count).then_some(node.links.map(NodeId)),
        })
    }

    /// The nodes in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = TreeNode> + use<'a> {
        let tree = *self;
        (0..tree.nodes.len() as u32).filter_map(move |id| tree.node(NodeId(id)))
    }

    /// The most joins above a cluster; 0 for at most one cluster. Cost: the depth, for each cluster.
    pub fn depth(&self) -> u32 {
        let above = |id: u32| {
            let parents = core::iter::successors(Some(NodeId(id)), |&id| self.node(id)?.parent);
            parents.skip(1).fold(0, |count, _| count + 1)
        };
        (0..self.cluster_count).map(above).max().unwrap_or(0)
    }
}
