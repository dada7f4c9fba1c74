//! Filing triangles in the cells of a tree, from the root down: shared by octant trees and plane trees.
//!
//! ```text
//! ids    | root's list | a child's list | a grandchild's list | ...     one list for each level on the way down
//! parts  | for each of these triangles, one bit for each part of its cell that it lies in
//! leaf:  count | id id id ...
//! ```
//! - Only the lists on the way down are kept: a child's list is gathered behind its parent's, and the next child's list
//!   overwrites it.
//! - A triangle may be filed in several parts. Each time is a *reference*.
//! - Links count words from the group's first word. The highest bit is set for a leaf.
//!
//! # The bound on references
//! A tree of `n` triangles has at most `n * allowance` references.
//!
//! 1. The root may have `n * allowance` references.
//! 2. A node hands its allowance on to its parts, in proportion to the triangles that are filed in each.
//! 3. A node is divided only if the parts may have the references that are filed in them.
//!
//! No plane divides triangles that lie in one place. There a node becomes a leaf as soon as its share is used up,
//! however deep the tree is elsewhere.
//!
//! Cost: a level files at most `n * allowance` references, each in at most nine steps and those of choosing planes. A
//! tree of `d` levels takes at most `n * allowance * d` times that many.

use super::tree_cell::Cell;
use crate::cost::Estimate;
use crate::error::BuildError;
use crate::geometry::Triangle;
use crate::input::{CostModel, Level, Options};
use crate::memory::{Arena, Words, put, size_of_slice};
use crate::structure::Group;

/// The bit of a link that leads to a leaf.
pub(super) const LEAF: u32 = 1 << 31;
/// Links have 31 bits.
const MOST_WORDS: usize = 1 << 31;

/// Allowance of references a triangle in a tree whose level is found.
///
/// # Measured
/// - The built-in scenes take 1 to 8 references a triangle in an octree, and 1 to 6 in a kd-tree.
/// - Triangles strewn over a cube take 11.
const ALLOWANCE: u64 = 16;
/// Allowance of references a triangle in a tree whose level is given; the level says how large the tree is meant to be.
///
/// # Measured
/// - An octree of level 11 with one triangle a leaf, as in the paper's tables, takes 270 references a triangle on
///   figure 4(b), 720 on figure 3.
const ALLOWANCE_OF_GIVEN_LEVEL: u64 = 4096;

/// The largest number of references that a tree of `triangle_count` triangles may have.
pub(super) fn most_references(triangle_count: usize, options: &Options) -> u64 {
    let allowance = match options.level {
        Level::Automatic => ALLOWANCE,
        Level::AtMost(_) => ALLOWANCE_OF_GIVEN_LEVEL,
    };
    allowance.saturating_mul(triangle_count as u64)
}

/// Memory for the lists of the root and of `levels` levels below; no list is longer than the one above.
pub(super) struct Lists<'s> {
    ids: &'s mut [u32],
    parts: &'s mut [u8],
}

impl<'s> Lists<'s> {
    pub const fn scratch_bytes(triangle_count: usize, levels: usize) -> usize {
        let entries = triangle_count.saturating_mul(levels + 1);
        size_of_slice::<u32>(entries).saturating_add(size_of_slice::<u8>(entries))
    }

    /// Takes the lists from the scratch, and fills the root's with the whole group.
    pub fn new(
        group: &Group<'_>,
        levels: usize,
        scratch: &'s mut [u8],
    ) -> Result<Self, BuildError> {
        let count = group.ids.len();
        let needed = Self::scratch_bytes(count, levels);
        let full = BuildError::ScratchFull { needed, given: scratch.len() };
        let entries = count.saturating_mul(levels + 1);
        let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        let ids = arena.take::<u32>(entries).ok_or(full)?;
        let parts = arena.take::<u8>(entries).ok_or(full)?;
        for (slot, &id) in ids.iter_mut().zip(group.ids) {
            *slot = id;
        }
        Ok(Self { ids, parts })
    }
}

/// Triangles of a cell: a run of the lists.
#[derive(Clone, Copy)]
pub(super) struct List {
    from: usize,
    to: usize,
}

impl List {
    pub fn is_empty(self) -> bool {
        self.from == self.to
    }

    pub fn len(self) -> usize {
        self.to - self.from
    }
}

/// Parts of a cell that a triangle lies in.
#[derive(Clone, Copy)]
pub(super) struct Placement {
    /// One bit for each part.
    pub mask: u8,
    /// Steps that finding the parts took: a look at the triangle, and one for each box it was compared with.
    pub steps: u32,
}

/// References in the parts of a cell, and how many there may be below them.
#[derive(Clone, Copy)]
pub(super) struct Parts {
    /// The parts in which a triangle is filed, one bit each.
    pub mask: u8,
    /// The number of references in all parts together.
    references: u64,
    /// The largest number of references that all subtrees together may have.
    most_references: u64,
}

impl Parts {
    /// The number of references that the subtree of a part may have: in proportion to the triangles filed in the part,
    /// and at least as many.
    pub fn share(&self, part: List) -> u64 {
        let product = u128::from(self.most_references) * part.len() as u128;
        product.checked_div(u128::from(self.references)).unwrap_or(0) as u64
    }
}

/// Node that is about to be written.
#[derive(Clone, Copy)]
pub(super) struct OpenNode {
    pub list: List,
    /// The offset of the node from the group's first word.
    pub offset: u32,
    /// The probability that a ray through the group enters the node (surface-area heuristic).
    probability: f64,
}

/// State of a build, or of a dry run.
pub(super) struct Filing<'b, 'g, 's, 'w> {
    pub group: &'b Group<'g>,
    pub words: &'b mut Words<'w>,
    lists: &'b mut Lists<'s>,
    root_half_area: f64,
    estimate: Estimate,
    /// The offset of the group's first word, from which links count.
    start: usize,
}

impl<'b, 'g, 's, 'w> Filing<'b, 'g, 's, 'w> {
    /// Writes a tree, and returns its estimated cost. `root` appends the root's node, with the list of the whole group,
    /// and returns the link to it.
    pub fn write(
        group: &'b Group<'g>,
        model: &CostModel,
        lists: &'b mut Lists<'s>,
        words: &'b mut Words<'w>,
        root_cell: &Cell,
        root: impl FnOnce(&mut Self, List) -> Result<u32, BuildError>,
    ) -> Result<f64, BuildError> {
        let start = words.len();
        let link_offset = words.push(0);
        let root_half_area = root_cell.half_area_within(&group.bounds);
        let estimate = Estimate::new(model);
        let mut filing = Self { group, words, lists, root_half_area, estimate, start };
        let link = root(&mut filing, List { from: 0, to: group.ids.len() })?;
        filing.words.set(link_offset, link);
        Ok(filing.estimate.total())
    }

    /// The ids of a list's triangles.
    pub fn ids(&self, list: List) -> &[u32] {
        self.lists.ids.get(list.from..list.to).unwrap_or(&[])
    }

    /// Begins the node of a cell, and adds it to the estimated cost.
    pub fn begin(&mut self, list: List, cell: &Cell) -> Result<OpenNode, BuildError> {
        let offset = self.words.len() - self.start;
        if offset.saturating_add(list.to - list.from) >= MOST_WORDS {
            return Err(BuildError::TooLarge);
        }
        let half_area = cell.half_area_within(&self.group.bounds);
        // A group on a line has no surface area; a ray that meets the group meets all of it.
        let probability =
            if self.root_half_area > 0.0 { half_area / self.root_half_area } else { 1.0 };
        self.estimate.add_node(probability);
        Ok(OpenNode { list, offset: offset as u32, probability })
    }

    /// Makes the node a leaf, and returns the link to it.
    pub fn leaf(&mut self, node: OpenNode) -> u32 {
        let ids = self.lists.ids.get(node.list.from..node.list.to).unwrap_or(&[]);
        self.estimate.add_tests(node.probability, ids.len());
        self.words.push(ids.len() as u32);
        self.words.extend(ids);
        node.offset | LEAF
    }

    /// Marks for each triangle of a list which parts of the cell it lies in. `None` if the parts would have more
    /// references than the node may have, so that the node is not to be divided.
    ///
    /// # Errors
    /// [`BuildError::TooMuchWork`].
    pub fn mark(
        &mut self,
        list: List,
        most_references: u64,
        mut parts_of: impl FnMut(&Triangle) -> Placement,
    ) -> Result<Option<Parts>, BuildError> {
        let mut mask = 0;
        // Each triangle lies in at least one part, so there are at least as many references as triangles.
        let mut references = list.len() as u64;
        for at in list.from..list.to {
            if references > most_references {
                return Ok(None);
            }
            let id = self.lists.ids.get(at).copied().unwrap_or(0);
            let Some(triangle) = self.group.triangles.get(id) else { continue };
            let found = parts_of(&triangle);
            self.words.spend(u64::from(found.steps))?;
            mask |= found.mask;
            references += u64::from(found.mask.count_ones()).saturating_sub(1);
            put(self.lists.parts, at, found.mask);
        }
        let parts = Parts { mask, references, most_references };
        Ok((references <= most_references).then_some(parts))
    }

    /// Gathers the triangles of one part into a list behind `list`.
    pub fn gather(&mut self, list: List, part: u32) -> List {
        let mut end = list.to;
        for at in list.from..list.to {
            let inside = self.lists.parts.get(at).is_some_and(|parts| parts >> part & 1 == 1);
            if inside && let Some(&id) = self.lists.ids.get(at) {
                put(self.lists.ids, end, id);
                end += 1;
            }
        }
        List { from: list.to, to: end }
    }
}
