//! Counters of a query's work.

/// Work of queries: nodes and tests. The same for a given index on every machine and SIMD level.
///
/// Layout: 16 bytes, in the order of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Counters {
    /// Nodes entered, of the cluster tree and of the local indices.
    pub nodes_visited: u64,
    /// Triangles tested.
    pub triangle_tests: u64,
}

impl core::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.nodes_visited += other.nodes_visited;
        self.triangle_tests += other.triangle_tests;
    }
}

/// Counter of nodes and tests. `()` counts nothing, and compiles to nothing.
pub trait Count {
    /// Counts a node that was entered.
    fn node(&mut self);
    /// Counts `count` triangles that were tested.
    fn tests(&mut self, count: u32);
}

impl Count for () {
    #[inline]
    fn node(&mut self) {}
    #[inline]
    fn tests(&mut self, _: u32) {}
}

impl Count for &mut Counters {
    #[inline]
    fn node(&mut self) {
        self.nodes_visited += 1;
    }
    #[inline]
    fn tests(&mut self, count: u32) {
        self.triangle_tests += u64::from(count);
    }
}
