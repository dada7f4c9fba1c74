//! Other people's libraries, each behind [`Contender`](super::contender::Contender).

mod bvh;
mod embree;
mod moller_trumbore;
mod obvhs;
mod parry3d;
mod tinybvh;

use super::Peer;

/// All libraries. Embree comes first as its users have it by default: what builds and growth are compared with.
pub const PEERS: &[Peer] = &[
    embree::MEDIUM,
    embree::HIGH,
    embree::ROBUST,
    embree::COMPACT,
    obvhs::PEER,
    parry3d::PEER,
    bvh::PEER,
    tinybvh::PEER,
];
