//! Contenders: the indices of `arboleda`, and other people's libraries, each at its best.
//!
//! ```text
//! contender (answers rays in a mode) <- ours
//!     ^
//!     +-- peer (a library and its settings) <- libraries: embree, obvhs, parry3d, bvh, tinybvh
//!              |
//!         best_setting (the fastest on a scene), agreement (how far the answers are from the exact ones)
//! ```
//! Fair and not fair: all on one thread, rays in processor time; the answers are looked at
//! before anything is timed; contenders take turns; every ray is converted from [`arboleda::Ray`] inside
//! the timed loop; build times leave out what an application would have anyway (triangles in the
//! library's form). The libraries' tests round and leak, ours is exact. The crates and ours are compiled
//! with the flags of this build: compare with `RUSTFLAGS="-C target-cpu=native"`. Embree and tinybvh
//! choose their instructions themselves.

pub mod agreement;
pub mod best_setting;
pub mod contender;
mod error;
#[cfg(feature = "peers")]
mod libraries;
pub mod mesh;
pub mod ours;
pub mod peer;
#[cfg(test)]
mod tests;

pub use error::PeerError;
#[cfg(feature = "peers")]
pub use libraries::PEERS;
pub use peer::{BuiltPeer, Peer, Setting};

/// No library: this program was built without the feature `peers`.
#[cfg(not(feature = "peers"))]
pub const PEERS: &[Peer] = &[];
