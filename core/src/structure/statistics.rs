//! What an index consists of, in numbers.

/// What an index consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Nodes that have children.
    pub inner_nodes: u64,
    /// Nodes that hold triangles.
    pub leaves: u64,
    /// Triangles filed, counting one filed in several leaves several times.
    pub references: u64,
    /// The most references in one leaf.
    pub largest_leaf: u32,
    /// The level of the deepest leaf; the root is level 0.
    pub deepest_level: u32,
}

impl Statistics {
    /// Both together.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        Self {
            inner_nodes: self.inner_nodes + other.inner_nodes,
            leaves: self.leaves + other.leaves,
            references: self.references + other.references,
            largest_leaf: self.largest_leaf.max(other.largest_leaf),
            deepest_level: self.deepest_level.max(other.deepest_level),
        }
    }

    /// Counts a leaf.
    pub fn add_leaf(&mut self, references: u32, level: u32) {
        self.leaves += 1;
        self.references += u64::from(references);
        self.largest_leaf = self.largest_leaf.max(references);
        self.deepest_level = self.deepest_level.max(level);
    }
}
