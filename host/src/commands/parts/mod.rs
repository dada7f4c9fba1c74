//! Jobs in parts: any range of the photons of `shoot`, `irradiance` and `render`, and the result of them all.

mod merge;
mod work;

pub use merge::{Merge, MergeOutputs};
pub use work::{Merged, PartWork, recorded};
