//! Jobs in parts: any range of the photons of `shoot`, `irradiance` and `render`, and the result of them all.

mod merge;
mod team;
mod work;

pub use merge::{Merge, MergeOutputs, print_digest};
pub use team::Team;
#[cfg(feature = "mpi")]
pub use team::{abort, join_ranks};
pub use work::{MergedJob, PartWork, recorded};
