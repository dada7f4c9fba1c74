//! Memory and work of a build: upper bounds, and what a dry run counts.

use crate::cluster;
use crate::cluster::ClusterNode;
use crate::memory::{padded, size_of_slice};
use crate::structure::{Representation, Structure};

/// Memory and work that a build takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacity {
    /// Bytes of the index, exactly.
    pub index: usize,
    /// Bytes of scratch: an upper bound. They are free again after the build.
    pub scratch: usize,
    /// Steps of the build, in looks at a triangle. At most a multiple of `n log n`, wherever the `n` triangles lie.
    pub steps: u64,
}

/// Bounds the scratch bytes of a build whose structure needs `structure` of them.
pub(crate) const fn scratch_with<R: Representation>(
    triangle_count: usize,
    structure: usize,
) -> usize {
    let build = padded(structure);
    let nodes = match (R::Structure::READS_TREE, R::CLUSTERED) {
        (false, _) => 0,
        (true, true) => triangle_count.saturating_mul(2).saturating_sub(1),
        (true, false) => 1,
    };
    let nodes = size_of_slice::<ClusterNode>(nodes);
    if !R::CLUSTERED {
        return cluster::whole_bytes(triangle_count).saturating_add(nodes.saturating_add(build));
    }
    // The memory of finding clusters is used again for joining them, and then for the build.
    let (detect, join) =
        (cluster::detect_bytes(triangle_count), cluster::join_bytes(triangle_count));
    let later = nodes.saturating_add(if join > build { join } else { build });
    let steps = if detect > later { detect } else { later };
    cluster::division_bytes(triangle_count).saturating_add(steps)
}
