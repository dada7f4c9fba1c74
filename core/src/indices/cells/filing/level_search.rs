//! Search for the level at which a tree of cells stops getting cheaper, level by level.
//!
//! ```text
//! level 0            A                 cost(0) = entering A + tests in A
//!               /    |    \
//! level 1      B     C     D           cost(1) = entering A to D + tests in B, C and D
//!             / \         / \
//! level 2    E   F       G   H         cost(2) = entering A to H + tests in C, E, F, G and H
//! ```
//! No division depends on what is below it. So a tree that ends at a level is the deeper tree without the nodes below
//! that level, and its cost follows from the sums over the nodes of each level. The search divides each node once.
//!
//! The memory of the lists holds the nodes of one depth that are still to be divided, and those of their children that
//! will be:
//!
//! ```text
//! | next level: node node ... ->      | free |      this level: (taken) node node |
//! node: count | lower and upper corner of the cell | references allowed | id id id ...
//! ```
//! The search ends where the [rule](BestLevel) says so, where its budget of steps is used up, or where the nodes of a
//! level do not fit the memory. It then takes the best of the levels that are complete.
//!
//! # What lost
//! - The whole tree anew for each level, from level 0 on: three to five times the steps. Its budget of steps ended too
//!   early in a district, where BSP trees and octrees-R now go deeper.
//! - One dry run of the deepest tree, which adds up the costs of all levels, with a share of the budget for each: as
//!   fast where trees end by themselves. But where triangles lie in one place, it divides levels that do not matter,
//!   and takes up to three times the steps.

use super::cell_lists::{Lists, Parts, gather};
use super::octants::{Division, Planes};
use super::tree_cell::Cell;
use crate::error::BuildError;
use crate::indices::cost::{BestLevel, level_search_steps};
use crate::input::CostModel;
use crate::memory::{Words, put};
use crate::structure::Group;

/// Search for the level of a tree of cells.
pub struct LevelSearch<'s> {
    pub group: &'s Group<'s>,
    pub model: CostModel,
    /// The largest number of triangles in a node that is not divided.
    pub leaf_capacity: u32,
    /// The largest number of references in the tree.
    pub most_references: u64,
    /// The largest depth of a node. A level is some depths: one in a tree of octants, one for each axis in a tree of planes.
    pub most_depth: u32,
    /// The number of depths of a level.
    pub depths_per_level: u32,
    /// The number of looks at each triangle that choosing planes takes.
    pub looks: u64,
}

/// Costs of the nodes of one depth.
#[derive(Default)]
struct DepthCosts {
    /// The cost of entering the nodes.
    nodes: f64,
    /// The cost of the tests, if all nodes are leaves.
    tests: f64,
    /// The cost of the tests in the nodes that are leaves in any case.
    leaf_tests: f64,
}

impl LevelSearch<'_> {
    /// Finds the level. `choose` chooses the planes that divide a cell of some triangles at a depth; all `None` for a
    /// leaf. What the lists hold is overwritten.
    ///
    /// # Errors
    /// [`BuildError::TooMuchWork`] if `words` allow fewer steps than the search takes.
    pub fn run(
        &self,
        lists: &mut Lists<'_>,
        root: &Cell,
        words: &mut Words<'_>,
        choose: impl Fn(&[u32], &Cell, u32) -> Planes,
    ) -> Result<u32, BuildError> {
        let (memory, masks) = lists.memory();
        let mut best = BestLevel::new();
        let mut budget = level_search_steps(self.group.ids.len(), self.looks);
        let mut nodes = Nodes::of_root(memory, self.group.ids, root, self.most_references);
        let mut costs = DepthCosts::default();
        let whole = root.half_area_within(&self.group.bounds);
        let mut is_divided = self.add(&mut costs, whole, root, self.group.ids.len());
        let mut above = 0.0;
        for depth in 0..=self.most_depth {
            // 1. All nodes of the depth are known. If the depth begins a level, so is the level's cost.
            let reached = above + costs.nodes;
            if depth.is_multiple_of(self.depths_per_level) {
                let level = depth.checked_div(self.depths_per_level).unwrap_or(depth);
                // Without nodes to divide, deeper levels are the same tree.
                if !best.add(level, reached + costs.tests) || !is_divided {
                    break;
                }
            }
            if depth == self.most_depth {
                break;
            }
            // 2. Divide the nodes that are not leaves.
            let mut below = DepthCosts::default();
            is_divided = false;
            while let Some(node) = nodes.first() {
                let ids = nodes.ids(node.count);
                let masks = masks.get_mut(..ids.len()).unwrap_or_default();
                let planes = choose(ids, &node.cell, depth);
                let (parts, steps) = if planes == [None; 3] {
                    (None, 0)
                } else {
                    let division = Division::new(&node.cell, &planes);
                    Parts::mark(self.group, ids, masks, node.most_references, &division)
                };
                let steps = steps + self.looks * ids.len() as u64;
                words.spend(steps)?;
                let Some(left) = budget.checked_sub(steps) else { return Ok(best.level()) };
                budget = left;
                let Some(parts) = parts else {
                    let probability = self.probability(whole, &node.cell);
                    costs.leaf_tests += self.model.intersection * probability * ids.len() as f64;
                    nodes.leave(node.count);
                    continue;
                };
                // 3. Add the children, and keep those that are divided in turn.
                for octant in (0..8).filter(|octant| parts.mask >> octant & 1 == 1) {
                    let child = node.cell.child(&planes, octant);
                    let count = masks.iter().filter(|&mask| mask >> octant & 1 == 1).count();
                    if self.add(&mut below, whole, &child, count) {
                        let most_references = parts.share(count);
                        let child = OpenNode { count, cell: child, most_references };
                        if !nodes.push(&child, masks, octant) {
                            return Ok(best.level());
                        }
                        is_divided = true;
                    }
                }
                nodes.leave(node.count);
            }
            nodes.descend();
            above = reached + costs.leaf_tests;
            costs = below;
        }
        Ok(best.level())
    }

    /// Adds a node with `count` triangles to the costs of its depth. Tells whether it is to be divided.
    fn add(&self, costs: &mut DepthCosts, whole: f64, cell: &Cell, count: usize) -> bool {
        let probability = self.probability(whole, cell);
        let tests = self.model.intersection * probability * count as f64;
        let is_divided = count > self.leaf_capacity as usize;
        costs.nodes += self.model.traversal * probability;
        costs.tests += tests;
        costs.leaf_tests += if is_divided { 0.0 } else { tests };
        is_divided
    }

    /// The probability that a ray through the group enters a cell (surface-area heuristic). `whole` is half the root's
    /// surface area within the group's box.
    fn probability(&self, whole: f64, cell: &Cell) -> f64 {
        let part = cell.half_area_within(&self.group.bounds);
        // A group on a line has no surface area; a ray that meets the group meets all of it.
        if whole > 0.0 { part / whole } else { 1.0 }
    }
}

/// Node that is to be divided.
struct OpenNode {
    count: usize,
    cell: Cell,
    /// The largest number of references in its subtree.
    most_references: u64,
}

/// Number of words in front of a node's ids.
const HEAD: usize = 9;

/// Nodes of one depth that are still to be divided, and those of the next.
struct Nodes<'l> {
    memory: &'l mut [u32],
    /// Number of words that the next depth's nodes take, at the front of the memory.
    next: usize,
    /// Offset of this depth's first node that is left. These nodes reach to the end of the memory.
    this: usize,
}

impl<'l> Nodes<'l> {
    /// The root alone; nothing if it does not fit.
    fn of_root(memory: &'l mut [u32], ids: &[u32], cell: &Cell, most_references: u64) -> Self {
        let mut nodes = Self { next: 0, this: memory.len(), memory };
        let root = OpenNode { count: ids.len(), cell: *cell, most_references };
        let at = nodes.this.saturating_sub(HEAD + ids.len());
        if let Some(room) = nodes.memory.get_mut(at..)
            && let Some(room) = room.get_mut(..HEAD + ids.len())
        {
            nodes.this = at;
            root.write_head(room);
            for (slot, &id) in room.iter_mut().skip(HEAD).zip(ids) {
                *slot = id;
            }
        }
        nodes
    }

    /// The first node of this depth that is left.
    fn first(&self) -> Option<OpenNode> {
        let head = self.memory.get(self.this..)?.first_chunk::<HEAD>()?;
        let &[count, x0, y0, z0, x1, y1, z1, low, high] = head;
        let side = |bits: u32| f64::from(f32::from_bits(bits));
        Some(OpenNode {
            count: count as usize,
            cell: Cell { lo: [x0, y0, z0].map(side), hi: [x1, y1, z1].map(side) },
            most_references: u64::from(high) << 32 | u64::from(low),
        })
    }

    /// The ids of the first node of this depth that is left, which has `count` of them.
    fn ids(&self, count: usize) -> &[u32] {
        let from = self.this + HEAD;
        self.memory.get(from..from + count).unwrap_or(&[])
    }

    /// Leaves behind the first node of this depth that is left, with its `count` ids; its memory is free.
    fn leave(&mut self, count: usize) {
        self.this += HEAD + count;
    }

    /// Keeps a child of the first node of this depth that is left, with those of its ids that are in `octant`. `masks`
    /// has one mask for each of them. Tells whether there is room.
    fn push(&mut self, child: &OpenNode, masks: &[u8], octant: u32) -> bool {
        let Some((free, taken)) = self.memory.split_at_mut_checked(self.this) else { return false };
        let ids = taken.get(HEAD..).unwrap_or(&[]);
        let end = self.next + HEAD + child.count;
        let Some(room) = free.get_mut(self.next..end) else { return false };
        self.next = end;
        child.write_head(room);
        gather(ids, masks, octant, room.get_mut(HEAD..).unwrap_or_default());
        true
    }

    /// Goes on to the nodes of the next depth: moves them to the end of the memory.
    fn descend(&mut self) {
        let moved_by = self.memory.len().saturating_sub(self.next);
        for at in (0..self.next).rev() {
            let word = self.memory.get(at).copied().unwrap_or(0);
            put(self.memory, at + moved_by, word);
        }
        (self.this, self.next) = (moved_by, 0);
    }
}

impl OpenNode {
    fn write_head(&self, room: &mut [u32]) {
        let Cell { lo: [x0, y0, z0], hi: [x1, y1, z1] } = self.cell;
        // The sides are numbers that `f32` holds.
        let [x0, y0, z0, x1, y1, z1] = [x0, y0, z0, x1, y1, z1].map(|side| (side as f32).to_bits());
        let (low, high) = (self.most_references as u32, (self.most_references >> 32) as u32);
        let head = [self.count as u32, x0, y0, z0, x1, y1, z1, low, high];
        for (slot, word) in room.iter_mut().zip(head) {
            *slot = word;
        }
    }
}
