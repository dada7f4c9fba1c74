//! Commands that measure: every index on every scene, the paper's experiments, clusters that move apart.

pub mod compare;
pub mod paper;
pub mod separation;
