//! Other people's ray intersection libraries, each at its best, in one ring with ours.
//!
//! ```text
//! contender <- embree, obvhs, parry3d, bvh, tinybvh, ours
//!     |
//! workload -> tune (best setting of each) -> agreement (answers, leaks) -> ring (timing) -+
//!             \------------------------- comparison (one scene) ------------------------/ |
//! growth (scenes by size) -> comparison      report (tables, CSV), page (peers.md) <-------+
//! ```
//! What is fair and what is not: all on one thread, rays in processor time; the answers are looked at
//! before anything is timed; contenders take turns; every ray is converted from [`arboleda::Ray`] inside
//! the timed loop; build times leave out what an application would have anyway (triangles in the
//! library's form). The libraries' tests round and leak, ours is exact. The crates and ours are compiled
//! with the flags of this build: compare with `RUSTFLAGS="-C target-cpu=native"`. Embree and tinybvh
//! choose their instructions themselves.

pub mod agreement;
pub mod best_setting;
pub(crate) mod contender;
mod error;
pub(crate) mod libraries;
pub(crate) mod ours;
#[cfg(test)]
mod tests;

use arboleda::Triangle;

pub use contender::{Batch, Built, Contender, Peer, Setting};
pub use error::PeerError;
use libraries::{bvh, embree, obvhs, parry3d, tinybvh};

/// Embree as its users have it by default: what builds and growth are compared with.
pub const EMBREE_MEDIUM: Peer = embree::MEDIUM;

/// All libraries.
pub const PEERS: &[Peer] = &[
    EMBREE_MEDIUM,
    embree::HIGH,
    embree::ROBUST,
    embree::COMPACT,
    obvhs::PEER,
    parry3d::PEER,
    bvh::PEER,
    tinybvh::PEER,
];

/// Builds a library's index by the first of its settings.
///
/// # Errors
/// There is no such library, or it cannot be used here.
pub fn build(name: &str, triangles: &[Triangle]) -> Result<Built<'static>, PeerError> {
    let setting =
        PEERS.iter().find(|peer| peer.name == name).and_then(|peer| peer.settings.first());
    setting.ok_or_else(|| PeerError::unknown(name))?.build(triangles)
}
