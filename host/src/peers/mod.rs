//! Other people's ray intersection libraries, each at its best, in one ring with ours.
//!
//! ```text
//! contender <- embree, obvhs, parry3d, bvh, tinybvh, ours
//!     |
//! workload -> tune (best setting of each) -> agreement (answers, leaks) -> ring (timing) -> report
//!             \------------------------- comparison -------------------------------/
//! ```
//! What is fair and what is not: all on one thread; the answers are looked at before anything is timed;
//! contenders take turns; every ray is converted from [`arboleda::Ray`] inside the timed loop; build times
//! leave out what an application would have anyway (triangles in the library's form). The libraries'
//! tests round and leak, ours is exact. The crates and ours are compiled with the flags of this build:
//! compare with `RUSTFLAGS="-C target-cpu=native"`. Embree and tinybvh choose their instructions
//! themselves.

pub mod agreement;
mod bvh_index;
mod comparison;
mod contender;
mod embree;
mod error;
mod moller_trumbore;
mod obvhs_index;
mod ours;
mod parry3d_index;
mod report;
mod ring;
#[cfg(test)]
mod tests;
#[cfg(feature = "tinybvh")]
mod tinybvh_index;
pub mod tune;
mod workload;

use arboleda::Triangle;

pub use comparison::{Comparison, ComparisonOptions, Row, compare};
pub use contender::{Batch, Built, Contender, Peer, PeerHit, Setting};
pub use error::PeerError;
pub use ours::Ours;
pub use report::{table, write_csv};
pub use ring::{Mode, Speed};
pub use workload::{Workload, leak_rays};

/// All libraries.
pub const PEERS: &[Peer] = &[
    embree::MEDIUM,
    embree::HIGH,
    embree::ROBUST,
    obvhs_index::PEER,
    parry3d_index::PEER,
    bvh_index::PEER,
    #[cfg(feature = "tinybvh")]
    tinybvh_index::PEER,
];

/// Builds a library's index by the first of its settings.
///
/// # Errors
/// There is no such library, or it cannot be used here.
pub fn build(name: &str, triangles: &[Triangle]) -> Result<Built<'static>, PeerError> {
    let setting =
        PEERS.iter().find(|peer| peer.name == name).and_then(|peer| peer.settings.first());
    let Some(setting) = setting else {
        let known = PEERS.iter().map(|peer| peer.name).collect::<Vec<_>>().join(", ");
        return Err(PeerError::Unknown { name: name.into(), known });
    };
    setting.build(triangles)
}
