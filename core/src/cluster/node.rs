//! The nodes of the cluster tree.

use bytemuck::{Pod, Zeroable};

use crate::geometry::Aabb;

/// Id of a node of the cluster tree: its index in [`Sections::nodes`](crate::custom::Sections::nodes).
///
/// `u32`: an index never needs more, and nodes stay small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(transparent)]
pub struct NodeId(pub u32);

impl NodeId {
    /// The id that stands for the parent of the root.
    pub const NONE: Self = Self(u32::MAX);
}

/// Node of the cluster tree: a cluster (leaf), or the join of two nodes (inner node).
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ClusterNode {
    /// The smallest box around all triangles below.
    pub bounds: Aabb,
    /// Inner node: the ids of the two nodes that were joined. Leaf: the offset of the first word of the cluster's local
    /// index, and the number of words.
    pub links: [u32; 2],
    /// The id of the inner node that this node was joined into; [`NodeId::NONE`] for the root.
    pub parent: NodeId,
}
