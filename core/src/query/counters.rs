//! What answering took, counted or not.

/// What answering took. The same for a given index on every machine.
///
/// Layout: 16 bytes, in the order of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Counters {
    /// Nodes whose box the ray entered, of the cluster tree and of the local indices.
    pub nodes_visited: u64,
    /// Exact tests between the ray and a triangle.
    pub triangle_tests: u64,
}

impl core::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.nodes_visited += other.nodes_visited;
        self.triangle_tests += other.triangle_tests;
    }
}

/// Counts, or does not: `()` compiles to nothing.
pub trait Count {
    /// A node was entered.
    fn node(&mut self);
    /// So many triangles were tested.
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
