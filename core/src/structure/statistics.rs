//! Statistics of an index.

/// Statistics of an index: the numbers of its nodes and references.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// The number of nodes that have children.
    pub inner_nodes: u64,
    /// The number of nodes that hold triangles.
    pub leaves: u64,
    /// The number of references to triangles. A triangle that is filed in several leaves has several.
    pub references: u64,
    /// The largest number of references in a leaf.
    pub largest_leaf: u32,
    /// The level of the deepest leaf; the root is level 0.
    pub deepest_level: u32,
}

impl Statistics {
    /// Sums up two statistics; largest leaf and deepest level are the larger ones.
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

    /// Counts a leaf with this number of references on this level.
    pub fn add_leaf(&mut self, references: u32, level: u32) {
        self.leaves += 1;
        self.references += u64::from(references);
        self.largest_leaf = self.largest_leaf.max(references);
        self.deepest_level = self.deepest_level.max(level);
    }
}
