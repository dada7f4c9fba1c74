//! Partition of the primitives, top-down, until a subset has eight or fewer.
//!
//! - A join of clusters is split into the two nodes that were joined.
//! - Any other subset is split by the plane of least SAH cost on all axes; see `binned_sah`.
//!
//! One to eight triangles cost the same to test. So SAH counts are rounded up to full leaves, which fills leaves.

use arrayvec::ArrayVec;

use glam::Vec4;

use super::BALANCED_FROM;
use super::binned_sah::{split_by_sah, split_equally};
use super::bins::cost_of;
use super::primitive::{Primitive, PrimitiveBounds};
use crate::cluster::{ClusterNode, Clusters, MAX_TREE_DEPTH, NodeId};
use crate::geometry::Box4;
use crate::input::{Mesh, SimdLevel};
use crate::memory::put;

/// Subset of the primitives, and how it is to be split.
#[derive(Clone, Copy)]
pub(crate) enum Subset {
    /// A join of clusters: an inner node of the cluster tree.
    Join(NodeId),
    /// A subset of a cluster, at this depth of splits below the cluster.
    Inside(PrimitiveBounds, u32),
}

/// Splitter of subsets.
pub(crate) struct Divider<'b> {
    nodes: &'b [ClusterNode],
    /// The number of triangles below each node of the cluster tree.
    counts: &'b [u32],
    level: SimdLevel,
}

impl<'b> Divider<'b> {
    /// Fills `primitives`, so that each node of the cluster tree has a run of its own. `counts` is as long as `nodes`.
    pub fn new(
        primitives: &mut [Primitive],
        counts: &'b mut [u32],
        triangles: Mesh<'_>,
        clusters: &Clusters<'_>,
        nodes: &'b [ClusterNode],
    ) -> Self {
        count_triangles(counts, clusters, nodes);
        let divider = Self { nodes, counts, level: SimdLevel::detect() };
        divider.file(primitives, triangles, clusters);
        divider
    }

    /// A splitter of subsets inside of a cluster alone.
    pub fn of_parts() -> Self {
        Self { nodes: &[], counts: &[], level: SimdLevel::detect() }
    }

    /// The subset of all primitives.
    pub fn root(&self, primitives: &[Primitive]) -> Subset {
        self.subset_of((self.nodes.len() as u32).saturating_sub(1), primitives)
    }

    /// The subset below a node of the cluster tree.
    fn subset_of(&self, id: u32, primitives: &[Primitive]) -> Subset {
        // Leaves come first, and there is one more of them than of joins.
        if id as usize > self.nodes.len() / 2 {
            Subset::Join(NodeId(id))
        } else {
            Subset::Inside(PrimitiveBounds::around(primitives), 0)
        }
    }

    /// The box of a subset.
    pub fn bounds(&self, subset: &Subset) -> Box4 {
        match *subset {
            Subset::Inside(part, _) => part.bounds,
            Subset::Join(join) => self.bounds_of(join.0),
        }
    }

    /// The box of a node of the cluster tree.
    fn bounds_of(&self, id: u32) -> Box4 {
        self.nodes.get(id as usize).map_or(Box4::at(Vec4::ZERO), |node| Box4::of(&node.bounds))
    }

    /// Fills `primitives` in the order of a traversal of the cluster tree.
    fn file(&self, primitives: &mut [Primitive], triangles: Mesh<'_>, clusters: &Clusters<'_>) {
        let mut slots = primitives.iter_mut();
        let mut stack = ArrayVec::<usize, { MAX_TREE_DEPTH + 1 }>::new();
        let mut next = self.nodes.len().checked_sub(1);
        while let Some(at) = next.or_else(|| stack.pop()) {
            next = None;
            if at < clusters.count() {
                for (&id, slot) in clusters.get(at).iter().zip(slots.by_ref()) {
                    let triangle = triangles.get(id).unwrap_or_default();
                    *slot = Primitive::new(&triangle, id);
                }
            } else if let Some(node) = self.nodes.get(at) {
                let [first, second] = self.cheaper_first(node).map(|link| link as usize);
                let pushed = stack.try_push(second).is_ok();
                debug_assert!(pushed, "one for each level");
                next = Some(first);
            }
        }
    }

    /// The two nodes that a node of the cluster tree joins, the one that costs less to test first.
    fn cheaper_first(&self, node: &ClusterNode) -> [u32; 2] {
        let cost = |link: u32| {
            let count = self.counts.get(link as usize).copied().unwrap_or(0);
            self.bounds_of(link).half_area() * cost_of(count)
        };
        let [left, right] = node.links;
        if cost(right) < cost(left) { [right, left] } else { [left, right] }
    }

    /// Splits more than eight primitives into two subsets, one behind the other, and returns the length of the first,
    /// which is the one that costs less.
    ///
    /// The cheaper subset gets the lower lane. Of two boxes that a ray enters at once, as a ray that begins in both
    /// does, the lower lane is entered first.
    pub fn divide(&self, primitives: &mut [Primitive], subset: &Subset) -> (usize, [Subset; 2]) {
        match *subset {
            Subset::Join(join) => {
                let node = self.nodes.get(join.0 as usize);
                let links = node.map_or([0; 2], |node| self.cheaper_first(node));
                let length = self.counts.get(links[0] as usize).map_or(0, |&count| count as usize);
                let (left, right) = primitives.split_at_checked(length).unwrap_or_default();
                (length, [self.subset_of(links[0], left), self.subset_of(links[1], right)])
            }
            Subset::Inside(ref part, depth) => {
                let (length, parts) = if depth < BALANCED_FROM {
                    split_by_sah(primitives, part, self.level)
                } else {
                    split_equally(primitives)
                };
                (length, parts.map(|part| Subset::Inside(part, depth + 1)))
            }
        }
    }
}

/// Counts the triangles below each node of the cluster tree.
fn count_triangles(counts: &mut [u32], clusters: &Clusters<'_>, nodes: &[ClusterNode]) {
    for at in 0..counts.len() {
        let count = if at < clusters.count() {
            clusters.get(at).len() as u32
        } else {
            let below = |link: u32| counts.get(link as usize).copied().unwrap_or(0);
            nodes.get(at).map_or(0, |node| below(node.links[0]) + below(node.links[1]))
        };
        put(counts, at, count);
    }
}
