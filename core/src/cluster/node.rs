//! The nodes of the cluster tree.

use bytemuck::{Pod, Zeroable};

use crate::geometry::Aabb;

/// A node of the cluster tree.
///
/// `u32` links: an index never needs more, and nodes stay small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(transparent)]
pub struct NodeId(pub u32);

impl NodeId {
    /// The parent of the root.
    pub const NONE: Self = Self(u32::MAX);
}

/// A cluster (leaf) or the join of two (inner node).
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ClusterNode {
    /// The smallest box around all triangles below.
    pub bounds: Aabb,
    /// Inner node: the two joined nodes. Leaf: the first word of the local index, and their number.
    pub links: [u32; 2],
    /// The node that this one was joined into.
    pub parent: NodeId,
}
