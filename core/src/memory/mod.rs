//! Caller-provided memory: carving typed slices out of bytes, and the layout of a finished index.

mod arena;
mod image;
mod sort;
mod words;

pub use arena::{ALIGNMENT, Aligned, Block};
pub(crate) use arena::{Arena, padded, size_of_slice};
pub use image::{ClusterNode, Image, NodeId};
pub(crate) use image::{Layout, MESH_BESIDE, WORDS_HOLD_TRIANGLES, encode_header, image_kind};
pub(crate) use sort::{SortBuffer, sort_by_key, sort_by_upper_half};
pub use words::Words;
