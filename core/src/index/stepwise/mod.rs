//! Builds that are not done at once: in slices of time, and in pieces of memory.

mod pieces;
#[cfg(feature = "wide-bvh")]
mod sliced;

pub(super) use pieces::is_in_pieces;
pub use pieces::{Piece, PiecewiseBuild};
#[cfg(feature = "wide-bvh")]
pub use sliced::SlicedBuild;

use super::{Index, whole_words};
