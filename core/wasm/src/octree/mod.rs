//! Octrees as they lie in an index: one, or one for each cluster; with planes at the midpoints or, of an octree-R,
//! stored.
//!
//! ```text
//! words:  root: a link; then the nodes
//! inner:  child mask, from bit 8 a bit for each divided axis | the planes, if stored | a link to each child
//! leaf:   count | the ids of the triangles
//! link:   offset of the node, the highest bit set for a leaf
//! ```
//! The core describes this layout in `indices/cells/octant_tree.rs`, and checks it whenever an index is opened. Here it
//! is read again, because a query of the core does not say which node it enters. Tests compare the number of nodes and
//! of triangle tests, for every ray, with the counters of the core's query.

mod cells;
mod path;

pub use cells::arb_octree_cells;
pub use path::arb_path;

use arboleda::clusters::NodeId;
use arboleda::custom::{ClusterNode, Sections};
use arboleda::{AnyIndex, BuildError, Vec3};
use arboleda_ffi::parts::Failure;

/// Highest bit of a link: the node is a leaf.
const LEAF: u32 = 1 << 31;
/// Bit of an inner node's first word that says that the first axis is divided.
const AXES_SHIFT: u32 = 8;
/// Nodes that wait while one is visited: up to seven on each of 21 levels, and the eight of the last.
const WAITING: usize = 8 * 21;

/// Octrees of an index.
#[derive(Clone, Copy)]
struct Octrees<'a> {
    sections: Sections<'a>,
    stores_planes: bool,
}

/// Octree of a cluster.
#[derive(Clone, Copy)]
struct Octree<'a> {
    words: &'a [u32],
    stores_planes: bool,
}

/// Closed cell.
#[derive(Clone, Copy)]
struct Cell {
    lo: [f32; 3],
    hi: [f32; 3],
}

/// Node of an octree.
enum Node<'a> {
    /// The triangles that are filed in the cell.
    Leaf(&'a [u32]),
    Inner(Inner),
}

/// Node with children.
#[derive(Clone, Copy)]
struct Inner {
    /// Where the cell is divided; NaN on an axis on which it is not.
    planes: [f32; 3],
    /// The children that exist, one bit for each octant.
    mask: u32,
    /// The offset of the first link.
    links: u32,
}

impl<'a> Octrees<'a> {
    /// The octrees of an index.
    ///
    /// # Errors
    /// An invalid option, if the index has none.
    fn of(index: &AnyIndex<'a>) -> Result<Self, Failure> {
        let stores_planes = match index.kind().family() {
            "octree" => false,
            "octree-r" => true,
            _ => {
                let (option, allowed) = ("kind", "an octree or an octree-R, to have cells");
                return Err(Failure::Build(BuildError::InvalidOption { option, allowed }));
            }
        };
        Ok(Self { sections: *index.sections(), stores_planes })
    }

    /// The clusters, by number.
    fn clusters(&self) -> impl Iterator<Item = (u32, &'a ClusterNode)> + use<'a> {
        (0..self.sections.cluster_count()).zip(self.sections.nodes())
    }

    /// A node of the cluster tree.
    fn node(&self, id: u32) -> Option<&'a ClusterNode> {
        self.sections.node(NodeId(id))
    }

    /// The octree of a cluster.
    fn octree(&self, cluster: &ClusterNode) -> Octree<'a> {
        Octree { words: self.sections.local_words(cluster), stores_planes: self.stores_planes }
    }
}

impl<'a> Octree<'a> {
    fn word(&self, at: u32) -> u32 {
        self.words.get(at as usize).copied().unwrap_or(0)
    }

    /// The link to the root.
    fn root(&self) -> u32 {
        self.word(0)
    }

    /// The node at a link, whose cell is given.
    fn node(&self, link: u32, cell: &Cell) -> Node<'a> {
        let offset = link & !LEAF;
        let head = self.word(offset);
        if link & LEAF != 0 {
            let first = offset as usize + 1;
            let ids = self.words.get(first..first.saturating_add(head as usize));
            return Node::Leaf(ids.unwrap_or_default());
        }
        let is_divided = |axis: u32| head >> (axis + AXES_SHIFT) & 1 == 1;
        let mut next = offset.wrapping_add(1);
        let mut planes = [f32::NAN; 3];
        for ((axis, plane), (lo, hi)) in
            (0..).zip(&mut planes).zip(cell.lo.into_iter().zip(cell.hi))
        {
            if !is_divided(axis) {
                continue;
            }
            // Halves are added, as the build does it, because the sum of both ends may overflow.
            *plane = lo * 0.5 + hi * 0.5;
            if self.stores_planes {
                *plane = f32::from_bits(self.word(next));
                next = next.wrapping_add(1);
            }
        }
        Node::Inner(Inner { planes, mask: head & 0xff, links: next })
    }

    /// The link to a child.
    fn child(&self, inner: &Inner, octant: u32) -> u32 {
        let before = inner.mask & ((1 << (octant & 7)) - 1);
        self.word(inner.links.wrapping_add(before.count_ones()))
    }
}

impl Cell {
    /// The cell of a cluster's root: its box.
    fn of(cluster: &ClusterNode) -> Self {
        let bounds = cluster.bounds;
        Self { lo: bounds.lo.to_array(), hi: bounds.hi.to_array() }
    }

    /// The cell of a child. Octant bit 0 is set for the upper half in x, bit 1 in y, bit 2 in z.
    fn child(&self, planes: &[f32; 3], octant: u32) -> Self {
        let mut child = *self;
        let sides = child.lo.iter_mut().zip(&mut child.hi);
        for ((axis, (lo, hi)), &plane) in (0..).zip(sides).zip(planes) {
            // An axis without a plane has no upper half.
            let is_upper: bool = octant >> axis & 1 == 1;
            if is_upper {
                *lo = plane;
            } else if !plane.is_nan() {
                *hi = plane;
            }
        }
        child
    }

    fn corners(&self) -> (Vec3, Vec3) {
        (Vec3::from_array(self.lo), Vec3::from_array(self.hi))
    }
}
