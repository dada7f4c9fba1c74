//! Other people's libraries, each behind [`Contender`](super::Contender), with what several of them need.

pub mod bvh;
pub mod embree;
pub mod mesh;
mod moller_trumbore;
pub mod obvhs;
pub mod parry3d;
#[cfg_attr(not(feature = "tinybvh"), path = "tinybvh_absent.rs")]
pub mod tinybvh;
