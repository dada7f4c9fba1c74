//! The order of boxes along a Morton curve; and a balanced binary tree of boxes in this order, for nearest-neighbour
//! searches.
//!
//! ```text
//!            1               root
//!        2       3
//!      4   5   6   7         groups of up to four boxes, in the order of the Morton curve
//! ```
//! 1. The boxes are sorted along a Morton curve through their centroids.
//! 2. They are grouped by four.
//! 3. A complete binary tree stands on the groups. It is laid out like a heap: node `i` has the children `2 i` and
//!    `2 i + 1`, the root is 1, the groups are the last level. A node without boxes has an empty box.
//!
//! The curve takes the cell of a centroid in a grid. If a cell holds many centroids, it takes the ranks of the
//! centroids on each axis instead. So one box far away, or gaps of very different widths, do not put all other boxes
//! into one cell.
//!
//! # Source
//! Morton order: G. M. Morton 1966; C. Lauterbach et al., *Fast BVH Construction on GPUs*, 2009.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use crate::geometry::{Aabb, Box4};
use crate::memory::{Arena, SortBuffer, put, size_of_slice, sort_by_key, sort_by_upper_half};

/// Number of boxes in a group. Fewer make more nodes, more make more comparisons.
///
/// # Measured
/// - 4 to 8 took the same time.
const LEAF_BOXES: usize = 4;

/// Node over some members.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BoxNode {
    /// The box around the members below that take part: `join` leaves out those that it has joined.
    pub bounds: Aabb,
    /// The lowest member below that takes part; `u32::MAX` if there is none.
    pub lowest: u32,
}

impl BoxNode {
    /// A node below which no member takes part.
    const EMPTY: Self = Self { bounds: Aabb::EMPTY, lowest: u32::MAX };

    fn union(self, other: Self) -> Self {
        let lowest = self.lowest.min(other.lowest);
        Self { bounds: self.bounds.union(other.bounds), lowest }
    }
}

/// Id of a node: its index in the heap.
#[derive(Clone, Copy)]
pub(super) struct NodeRef(u32);

impl NodeRef {
    pub const ROOT: Self = Self(1);

    /// The parent; `None` for the root.
    pub fn parent(self) -> Option<Self> {
        (self.0 > 1).then_some(Self(self.0 / 2))
    }
}

/// Memory of a tree and of its build, divided anew for each phase:
///
/// ```text
/// cells:  keys u64 | buffer u64
/// ranks:  codes u64 | keys u64 | buffer u64
/// curve:  codes u64 | buffer u64 and u32
/// tree:   nodes
/// ```
/// The callers divide it for phases of their own: sorts, which are laid out like `cells`, the table of `corners`, and
/// the tree of `proximity`.
pub(super) struct Scratch<'a> {
    bytes: &'a mut [u8],
}

impl<'a> Scratch<'a> {
    /// Takes some bytes, at least [`Self::bytes`].
    pub fn take(arena: &mut Arena<'a>, bytes: usize) -> Option<Self> {
        Some(Self { bytes: arena.take(bytes)? })
    }

    pub const fn bytes(count: usize) -> usize {
        // The ranks take more than the curve.
        let sorting = size_of_slice::<u64>(count).saturating_mul(3);
        let nodes = size_of_slice::<BoxNode>(BoxTree::node_count(count));
        if sorting > nodes { sorting } else { nodes }
    }

    /// The whole memory, to be divided for a phase.
    pub fn arena(&mut self) -> Option<Arena<'_>> {
        Arena::new(&mut *self.bytes)
    }

    /// Takes keys and a buffer for sorts of keys alone, as long as there is no tree.
    pub fn keys(&mut self, count: usize) -> Option<[&mut [u64]; 2]> {
        let mut arena = self.arena()?;
        Some([arena.take(count)?, arena.take(count)?])
    }

    /// Takes keys and a sort buffer for sorts of values by keys, as long as there is no tree.
    pub fn sorting(&mut self, count: usize) -> Option<(&mut [u64], SortBuffer<'_>)> {
        let mut arena = self.arena()?;
        Some((arena.take(count)?, SortBuffer::take(&mut arena, count)?))
    }
}

pub(super) struct BoxTree<'t> {
    boxes: &'t [Aabb],
    nodes: &'t mut [BoxNode],
    members: &'t [u32],
    /// The number of groups, a power of two.
    groups: usize,
}

impl<'t> BoxTree<'t> {
    const fn node_count(count: usize) -> usize {
        2 * count.div_ceil(LEAF_BOXES).next_power_of_two()
    }

    /// Sorts `members` (indices into `boxes`) along the curve. `None` if the scratch is too small.
    pub fn sort(boxes: &[Aabb], members: &mut [u32], scratch: &mut Scratch<'_>) -> Option<()> {
        if Self::sort_by_cells(boxes, members, scratch)? {
            return Some(());
        }
        Self::sort_by_ranks(boxes, members, scratch)
    }

    /// Sorts along the curve through a grid. Tells whether no cell is [`CROWDED`].
    fn sort_by_cells(
        boxes: &[Aabb],
        members: &mut [u32],
        scratch: &mut Scratch<'_>,
    ) -> Option<bool> {
        let count = members.len();
        let [keys, buffer] = scratch.keys(count)?;
        // Half of the centroid, so that no difference of two overflows. How it is rounded does not matter.
        let half_centre_of = |member: u32| {
            let bounds = Box4::of(boxes.get(member as usize).unwrap_or(&Aabb::EMPTY));
            bounds.lo * 0.25 + bounds.hi * 0.25
        };
        // 1. The grid lies over all centroids.
        let all = members
            .iter()
            .fold(Box4::EMPTY, |all, &member| all.union(Box4::at(half_centre_of(member))));
        let longest = (all.hi - all.lo).max_element();
        let scale = if longest > SHORTEST { LAST_CELL / longest } else { 0.0 };
        for (key, &member) in keys.iter_mut().zip(members.iter()) {
            // Floats from 2^23 on have the units in their last bits.
            let cells = ((half_centre_of(member) - all.lo) * scale).min(Vec4::splat(LAST_CELL));
            let bits = (cells + Vec4::splat(UNITS)).to_array().map(f32::to_bits);
            let [x, y, z, _] = bits.map(|bits| spread(u64::from(bits & CELL_BITS)));
            *key = (x | y << 1 | z << 2) << 32 | u64::from(member);
        }
        // 2. Sort, and look for crowds.
        sort_by_upper_half(keys, buffer);
        for (member, &key) in members.iter_mut().zip(keys.iter()) {
            *member = key as u32;
        }
        let cells = || keys.iter().map(|key| key >> 32);
        Some(cells().zip(cells().skip(CROWDED)).all(|(cell, next)| cell != next))
    }

    /// Sorts along the curve through the ranks of the centroids on each axis. `None` if the scratch is too small.
    fn sort_by_ranks(boxes: &[Aabb], members: &mut [u32], scratch: &mut Scratch<'_>) -> Option<()> {
        let count = members.len();
        let mut arena = scratch.arena()?;
        let codes = arena.take::<u64>(count)?;
        let rest = arena.into_rest();
        let mut arena = Arena::new(&mut *rest)?;
        let (keys, buffer) = (arena.take::<u64>(count)?, arena.take::<u64>(count)?);
        // 1. Find the rank of each centroid on each axis; equal coordinates have equal ranks.
        codes.fill(0);
        for axis in 0..3 {
            for ((position, key), &member) in (0_u32..).zip(keys.iter_mut()).zip(members.iter()) {
                let bounds = boxes.get(member as usize).unwrap_or(&Aabb::EMPTY);
                let [x, y, z] = bounds.centre().to_array();
                let coordinate = [x, y, z].get(axis).copied().unwrap_or(0.0);
                *key = u64::from(ascending_bits(coordinate)) << 32 | u64::from(position);
            }
            sort_by_upper_half(keys, buffer);
            let mut run = (0, 0);
            for (sorted, &key) in (0_u64..).zip(keys.iter()) {
                if key >> 32 != run.1 {
                    run = (sorted, key >> 32);
                }
                let cell = (run.0 << CURVE_BITS).checked_div(count as u64).unwrap_or(0);
                *codes.get_mut(key as u32 as usize)? |= spread(cell) << axis;
            }
        }

        // 2. Sort along the curve.
        let mut buffer = SortBuffer::take(&mut Arena::new(rest)?, count)?;
        sort_by_key(codes, members, &mut buffer);
        Some(())
    }

    /// Builds a tree over `members` (indices into `boxes`) in their order, that of [`BoxTree::sort`]. All take part. `None`
    /// if the scratch is too small.
    pub fn build(
        boxes: &'t [Aabb],
        members: &'t [u32],
        scratch: &'t mut Scratch<'_>,
    ) -> Option<Self> {
        let count = members.len();
        let nodes = scratch.arena()?.take::<BoxNode>(Self::node_count(count))?;
        let groups = nodes.len() / 2;
        let mut tree = Self { boxes, nodes, members, groups };
        for at in (1..2 * groups as u32).rev() {
            tree.refresh(NodeRef(at), |_| true);
        }
        Some(tree)
    }

    /// Recomputes one node from its children, or, for a group, from those members for which `takes_part` is true.
    fn refresh(&mut self, node: NodeRef, takes_part: impl Fn(u32) -> bool) {
        let all = if let Some((left, right)) = self.children(node) {
            let below = |child| self.node(child).copied().unwrap_or(BoxNode::EMPTY);
            below(left).union(below(right))
        } else {
            let members = self.group(node).iter().copied().filter(|&member| takes_part(member));
            let nodes = members.map(|lowest| BoxNode { bounds: *self.box_of(lowest), lowest });
            nodes.fold(BoxNode::EMPTY, BoxNode::union)
        };
        put(self.nodes, node.0 as usize, all);
    }

    /// Recomputes the nodes from the group of the member at `position` on the curve up to the root. Only members for
    /// which `takes_part` is true do.
    pub fn refresh_above(&mut self, position: usize, takes_part: impl Fn(u32) -> bool) {
        let mut next = Some(NodeRef((self.groups + position / LEAF_BOXES) as u32));
        while let Some(node) = next {
            self.refresh(node, &takes_part);
            next = node.parent();
        }
    }

    pub fn node(&self, node: NodeRef) -> Option<&BoxNode> {
        self.nodes.get(node.0 as usize)
    }

    /// The two children; `None` for a group.
    pub fn children(&self, node: NodeRef) -> Option<(NodeRef, NodeRef)> {
        let inner = (node.0 as usize) < self.groups;
        inner.then_some((NodeRef(2 * node.0), NodeRef(2 * node.0 + 1)))
    }

    /// The members of a group.
    pub fn group(&self, node: NodeRef) -> &[u32] {
        let start = (node.0 as usize).saturating_sub(self.groups) * LEAF_BOXES;
        let end = (start + LEAF_BOXES).min(self.members.len());
        self.members.get(start..end).unwrap_or(&[])
    }

    /// All members, in the order of the curve.
    pub fn members(&self) -> &[u32] {
        self.members
    }

    /// The box of a member.
    pub fn box_of(&self, member: u32) -> &'t Aabb {
        self.boxes.get(member as usize).unwrap_or(&Aabb::EMPTY)
    }
}

/// The number of the last cell of the grid along each axis. It has ten bits, so a key has four digits of eight.
///
/// # Measured
/// - Sixteen bits took two more passes of the sort, and made no fewer pairs of near nodes.
const LAST_CELL: f32 = 1023.0;
/// The bits of a cell's number.
const CELL_BITS: u32 = 0x3ff;
/// Floats from here on are integers: those that differ by one differ by one in their bits.
const UNITS: f32 = 8_388_608.0;
/// Shorter extents are not divided, so that the number of cells a unit is finite.
const SHORTEST: f32 = 1e-30;

/// Most centroids in a cell of the grid. If there are more, the curve takes ranks: in a cell they are in no order, so
/// comparing them with each other takes as many steps for each.
///
/// # Measured
/// - Ranks take three more sorts: in a district of 65,000 triangles, a quarter of the instructions of finding clusters.
/// - Cells that are as flat as the scene made twice as many pairs of near nodes in a city.
const CROWDED: usize = 64;

/// Bits of a rank on the Morton curve, for each axis.
const CURVE_BITS: u32 = 21;

/// Maps a number to bits that sort like the number.
fn ascending_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// Spreads the lowest 21 bits, with two zeros between neighbours.
fn spread(x: u64) -> u64 {
    let x = x & 0x1f_ffff;
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
