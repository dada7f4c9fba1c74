//! Filing triangles in the cells of a tree, from the root down: shared by octant trees and plane trees.
//!
//! ```text
//! ids    | root's list | a child's list | a grandchild's list | ...     one list for each level on the way down
//! parts  | for each of these triangles, one bit for each part (octant) of its cell that it lies in
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
//! Cost: a level files at most `n * allowance` references, each in at most nine steps and those of choosing planes. So a
//! tree of `d` levels takes at most `d * n * allowance * (9 + looks)` steps.

use super::octants::Division;
use crate::error::BuildError;
use crate::input::{Level, Options};
use crate::memory::{Arena, Words, put, size_of_slice};
use crate::structure::Group;

/// The bit of a link that leads to a leaf.
pub const LEAF: u32 = 1 << 31;
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
pub fn most_references(triangle_count: usize, options: &Options) -> u64 {
    let allowance = match options.level {
        Level::Automatic => ALLOWANCE,
        Level::AtMost(_) => ALLOWANCE_OF_GIVEN_LEVEL,
    };
    allowance.saturating_mul(triangle_count as u64)
}

/// Memory for the lists of the root and of `levels` levels below; no list is longer than the one above.
pub struct Lists<'s> {
    ids: &'s mut [u32],
    parts: &'s mut [u8],
}

impl<'s> Lists<'s> {
    pub const fn scratch_bytes(triangle_count: usize, levels: usize) -> usize {
        let entries = triangle_count.saturating_mul(levels + 1);
        size_of_slice::<u32>(entries).saturating_add(size_of_slice::<u8>(entries))
    }

    /// Takes the memory from the scratch.
    pub fn new(
        triangle_count: usize,
        levels: usize,
        scratch: &'s mut [u8],
    ) -> Result<Self, BuildError> {
        let needed = Self::scratch_bytes(triangle_count, levels);
        let full = BuildError::ScratchFull { needed, given: scratch.len() };
        let entries = triangle_count.saturating_mul(levels + 1);
        let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        let ids = arena.take::<u32>(entries).ok_or(full)?;
        let parts = arena.take::<u8>(entries).ok_or(full)?;
        Ok(Self { ids, parts })
    }

    /// The memory for other uses before the tree is written: for ids, and for a mask of each.
    pub fn memory(&mut self) -> (&mut [u32], &mut [u8]) {
        (self.ids, self.parts)
    }
}

/// Triangles of a cell: a run of the lists.
#[derive(Clone, Copy)]
pub struct List {
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

/// References in the parts of a cell, and how many there may be below them.
#[derive(Clone, Copy)]
pub struct Parts {
    /// The parts in which a triangle is filed, one bit each.
    pub mask: u8,
    /// The number of references in all parts together.
    references: u64,
    /// The largest number of references that all subtrees together may have.
    most_references: u64,
}

impl Parts {
    /// Finds for each triangle of a node the octants it lies in, and the number of steps that takes. `None` if the
    /// parts would have more references than the node may have, so that the node is not to be divided.
    pub fn mark(
        group: &Group<'_>,
        ids: &[u32],
        masks: &mut [u8],
        most_references: u64,
        division: &Division<'_>,
    ) -> (Option<Self>, u64) {
        let mut mask = 0;
        let mut steps = 0;
        // Each triangle lies in at least one part, so there are at least as many references as triangles.
        let mut references = ids.len() as u64;
        for (&id, slot) in ids.iter().zip(masks) {
            if references > most_references {
                break;
            }
            let Some(triangle) = group.triangles.get(id) else { continue };
            let found = division.place(&triangle);
            steps += u64::from(found.steps);
            mask |= found.mask;
            references += u64::from(found.mask.count_ones()).saturating_sub(1);
            *slot = found.mask;
        }
        let parts = Self { mask, references, most_references };
        ((references <= most_references).then_some(parts), steps)
    }

    /// The number of references that the subtree of a part with `count` triangles may have: in proportion to them. It
    /// is at least `count`, because the whole has no more references than it may.
    pub fn share(&self, count: usize) -> u64 {
        let product = u128::from(self.most_references) * count as u128;
        product.checked_div(u128::from(self.references)).unwrap_or(0) as u64
    }
}

/// Copies the ids of the triangles that lie in a part to the front of `to`, and returns their number.
pub fn gather(ids: &[u32], masks: &[u8], part: u32, to: &mut [u32]) -> usize {
    let mut count = 0;
    for (&id, &mask) in ids.iter().zip(masks) {
        // The next id overwrites one that is not in the part.
        put(to, count, id);
        count += usize::from(mask >> part & 1);
    }
    count
}

/// State of a build.
pub struct Filing<'b, 'g, 's, 'w> {
    pub group: &'b Group<'g>,
    pub words: &'b mut Words<'w>,
    lists: &'b mut Lists<'s>,
    /// The offset of the group's first word, from which links count.
    start: usize,
}

impl<'b, 'g, 's, 'w> Filing<'b, 'g, 's, 'w> {
    /// Writes a tree. `root` appends the root's node, with the list of the whole group, and returns the link to it.
    pub fn write(
        group: &'b Group<'g>,
        lists: &'b mut Lists<'s>,
        words: &'b mut Words<'w>,
        root: impl FnOnce(&mut Self, List) -> Result<u32, BuildError>,
    ) -> Result<(), BuildError> {
        for (slot, &id) in lists.ids.iter_mut().zip(group.ids) {
            *slot = id;
        }
        let start = words.len();
        let link_offset = words.push(0);
        let mut filing = Self { group, words, lists, start };
        let link = root(&mut filing, List { from: 0, to: group.ids.len() })?;
        filing.words.set(link_offset, link);
        Ok(())
    }

    /// The ids of a list's triangles.
    pub fn ids(&self, list: List) -> &[u32] {
        self.lists.ids.get(list.from..list.to).unwrap_or(&[])
    }

    /// Begins the node of a list, and returns its offset from the group's first word.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`].
    pub fn begin(&self, list: List) -> Result<u32, BuildError> {
        let offset = self.words.len() - self.start;
        if offset.saturating_add(list.len()) >= MOST_WORDS {
            return Err(BuildError::TooLarge);
        }
        Ok(offset as u32)
    }

    /// Makes the node of a list, which begins at `offset`, a leaf, and returns the link to it.
    pub fn leaf(&mut self, list: List, offset: u32) -> u32 {
        let ids = self.lists.ids.get(list.from..list.to).unwrap_or(&[]);
        self.words.push(ids.len() as u32);
        self.words.extend(ids);
        offset | LEAF
    }

    /// Marks for each triangle of a list which octants it lies in; see [`Parts::mark`].
    ///
    /// # Errors
    /// [`BuildError::TooMuchWork`].
    pub fn mark(
        &mut self,
        list: List,
        most_references: u64,
        division: &Division<'_>,
    ) -> Result<Option<Parts>, BuildError> {
        let Lists { ids, parts } = &mut *self.lists;
        let ids = ids.get(list.from..list.to).unwrap_or(&[]);
        let masks = parts.get_mut(list.from..list.to).unwrap_or_default();
        let (parts, steps) = Parts::mark(self.group, ids, masks, most_references, division);
        self.words.spend(steps)?;
        Ok(parts)
    }

    /// Gathers the triangles of one octant into a list behind `list`.
    pub fn gather(&mut self, list: List, octant: u32) -> List {
        let (above, below) = self.lists.ids.split_at_mut_checked(list.to).unwrap_or_default();
        let ids = above.get(list.from..).unwrap_or(&[]);
        let masks = self.lists.parts.get(list.from..list.to).unwrap_or(&[]);
        List { from: list.to, to: list.to + gather(ids, masks, octant, below) }
    }
}
