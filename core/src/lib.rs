//! Exact ray queries on scenes of triangles, in memory that you provide.
//!
//! ```text
//! triangles -> clusters -> one index per cluster -> cluster tree -> hits
//! Scene        clusters    kinds                                    Index
//! ```
//!
//! An index is built inside one byte slice (the arena) with the help of a second (the scratch), both the caller's.
//! Everything in it is linked by `u32`, so the used part of the arena can be written to a file or put in ROM, and
//! queried in place. No allocation, no panic, no recursion without a bound, and the same bits on every target.
//!
//! # Should I use this?
//!
//! **Yes**, if hits have to be exact or the same everywhere (simulation, replay, a server that agrees with its
//! clients), if there is no heap, or if a scene is made of groups far from each other.
//!
//! **No**, if you need a renderer, motion, instances, curves or another primitive than triangles, or an index that is
//! updated as the scene moves. On a large x86-64, Embree answers single rays about as fast, and is not exact.
//!
//! # Contents
//!
//! | to | see |
//! |---|---|
//! | give triangles | [`Triangle`], [`Mesh`], [`Scene`] |
//! | choose a kind of index | [`kinds`] (a table), [`IndexKind`], [`select`] (tries them on the scene) |
//! | build one | [`Index::build`], [`Options`], [`BuildError`]; in parallel, [`Executor`] |
//! | know its size | [`Index::capacity`] (exact), [`IndexKind::scratch_capacity`] (a bound, in constants) |
//! | ask | [`Ray`], [`Index::closest_hit`], [`Index::occluded`], [`Index::all_hits`], [`Hit`] |
//! | ask about many rays | [`Index::closest_hits`], [`Index::occluded_each`] |
//! | save and open | [`Index::as_bytes`], [`Index::from_bytes`], [`include_index!`], [`OpenError`] |
//! | build an index larger than the memory | [`PiecewiseBuild`] |
//! | keep no second copy of a mesh | [`Scene::beside`], [`Index::from_bytes_beside`] |
//! | decide the kind at run time | [`AnyIndex`], [`RayIndex`] for `dyn` |
//! | have an index as a field | [`Stored`]; with a heap, `OwnedIndex` (feature `alloc`) |
//! | see the clusters | [`clusters`] |
//! | write an index of your own | [`custom`] |
//! | test one ray and one triangle | [`intersect`] |
//!
//! # Example
//! ```
//! use arboleda::kinds::{Clustered, Octree};
//! use arboleda::{Block, Index, Options, Ray, Scene, Triangle, Vec3};
//!
//! # fn main() -> Result<(), Box<dyn core::error::Error>> {
//! let near = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
//! let far = Vec3::splat(50.0);
//! let triangles = [near, Triangle::new(far, far + Vec3::X, far + Vec3::Y)];
//! let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
//!
//! let mut scratch = [Block::ZERO; 64]; // 4 KiB
//! let mut arena = [Block::ZERO; 8]; // 512 bytes
//! let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
//! let index = Index::<Clustered<Octree>>::build(&scene, &options, arena, scratch)?;
//!
//! let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z)?;
//! assert_eq!(index.closest_hit(&ray).map(|hit| (hit.triangle.0, hit.t)), Some((0, 1.0)));
//! assert_eq!(index.cluster_count(), 2);
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! - A feature for each family of indices, all of them by default: `octree`, `octree-r`, `uniform-grid`, `kd-tree`,
//!   `bsp-tree`, `bvh`, `wide-bvh`, `compact-bvh`, `lean-bvh`. Each compiles the index over the whole scene and its
//!   hierarchy over clusters. The linear scan is always there.
//! - `alloc`, not by default: `OwnedIndex`, an index that allocates its own arena.
//!
//! With `default-features = false` and one feature, [`AnyIndex`] and [`select::select`] contain the code of that kind
//! and of the linear scan only, and refuse bytes of other kinds by name.
#![no_std]
// Modules that several kinds share have parts that not every kind needs.
#![cfg_attr(not(feature = "all-kinds"), allow(dead_code, unused_imports, unused_macros))]
#![warn(clippy::pedantic)]
#![allow(
    clippy::cast_possible_truncation, // counts are checked against the u32 limit once, in `build`
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,           // float to integer saturates at 0, as wanted
    clippy::doc_markdown,             // names of people in capitals
    clippy::many_single_char_names,   // the names of the papers
    clippy::similar_names,
    clippy::must_use_candidate,
    clippy::module_name_repetitions,
    clippy::float_cmp                 // exactness is the point
)]

#[cfg(feature = "alloc")]
extern crate alloc;

mod cluster;
mod error;
mod geometry;
mod index;
mod indices;
mod input;
mod memory;
mod query;
mod simd;
mod structure;

/// Seal of the traits that only types of this crate implement, so that methods can be added to them, and an index can
/// rely on what a query does.
mod sealed {
    pub trait Sealed {}
}

pub use error::{BuildError, MeshError, OpenError};
pub use geometry::kernel::Intersection;
pub use geometry::{Aabb, Ray, RayError, Triangle, intersect};
pub use glam::{self, Vec3};
#[cfg(feature = "alloc")]
pub use index::OwnedIndex;
#[cfg(feature = "wide-bvh")]
pub use index::SlicedBuild;
pub use index::{
    AnyIndex, BATCH_SCRATCH, Capacity, Index, IndexKind, Piece, PiecewiseBuild, RayIndex, Storage,
    Stored, select,
};
pub use input::{
    BvhBuild, CostModel, Executor, Float64, Level, Mesh, Options, Resolution, Scene, Sequential,
    SimdLevel,
};
pub use memory::{Aligned, Block};
pub use query::{AllHits, Counters, Hit, TriangleId};
pub use simd::Work;
pub use structure::Statistics;

/// The indices, as types: what an [`Index`] is made of at compile time. At run time, [`IndexKind`] names them.
///
/// | type | what it is | bytes a triangle | take it |
/// |---|---|---|---|
/// | [`Linear`](kinds::Linear) | every triangle, one after the other | 40 | for some dozen triangles; as an oracle |
/// | [`Octree`](kinds::Octree) | cells halved along all axes | | for the paper's comparisons |
/// | [`OctreeR`](kinds::OctreeR) | octants divided where it costs least | | for comparisons |
/// | [`UniformGrid`](kinds::UniformGrid) | cells of one size | | for triangles of one size, evenly strewn |
/// | [`KdTree`](kinds::KdTree) | cells divided by the cheapest plane | | where nodes have to be cheap |
/// | [`BspTree`](kinds::BspTree) | cells halved, the axes in turn | | for comparisons |
/// | [`Bvh`](kinds::Bvh) | a binary tree of boxes | | where memory and code have to be small |
/// | [`WideBvh`](kinds::WideBvh) | a BVH8 in `f32` | 50 to 55 | for speed |
/// | [`CompactBvh`](kinds::CompactBvh) | a BVH8 in 16 bits | 25 to 30 | for speed in little memory |
/// | [`LeanBvh`](kinds::LeanBvh) | a BVH8 in 16 bits beside a mesh | 7 to 10 | beside a mesh that is kept anyway |
///
/// [`Clustered`](kinds::Clustered) of any of them is a hierarchy: one in each cluster, below the cluster tree. Bytes
/// include what answering needs; those left blank depend on the scene.
pub mod kinds {
    pub use crate::indices::*;
    pub use crate::structure::Representation;
}

/// The clusters of a scene, and the tree that joins them.
pub mod clusters {
    pub use crate::cluster::{
        ClusterTree, Clusters, NodeId, TreeNode, find, find_with, scratch_capacity,
    };
}

/// All that an index of your own needs: the contract, and the tools that keep it exact.
///
/// Implement [`Described`](custom::Described) and [`LocalIndex`](custom::LocalIndex) for a type, and
/// [`Index`]`<YourType>` and `Index<Clustered<YourType>>` are there.
pub mod custom {
    pub use crate::cluster::{ClusterNode, Clusters, NodeId};
    pub use crate::geometry::{AxisCrossing, RaySpan, Span, kernel, may_overlap};
    pub use crate::memory::{ALIGNMENT, Words};
    pub use crate::query::{BatchQuery, Query};
    pub use crate::structure::{
        ClusterBuild, Described, DividedScene, Group, Local, LocalIndex, Sections, Structure,
        Weights,
    };
}

/// Compiles and runs the code of the crate's page.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct CratePage;
