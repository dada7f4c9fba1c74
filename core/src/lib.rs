//! Exact ray queries on scenes made of groups of objects, in memory that you provide.
//!
//! ```text
//! triangles -> clusters -> one local index per cluster -> cluster tree -> queries
//! scene        cluster     indices                        cluster::tree   query, index
//! ```
//!
//! An index is built inside one byte slice (an arena) with the help of a second (the scratch), both
//! yours. Everything in it is linked by `u32` ids, so the used part of the arena can be written to
//! a file or put in ROM, and queried in place. No allocation, no panic, no recursion without a
//! bound, and the same bits on every target.
//!
//! # Features
//! One for each kind of index, all of them by default: `octree`, `octree-r`, `uniform-grid`, `kd-tree`, `bsp-tree`,
//! `bvh`, `wide-bvh`, `compact-bvh`, `lean-bvh`. Each compiles the index over the whole scene and its
//! hierarchy over clusters. The linear scan is always there. With `default-features = false` and one feature,
//! [`AnyIndex`] and [`auto::select`] contain the code of that kind and of the linear scan only, and refuse bytes of
//! others by name.
//!
//! # Examples
//! ```
//! use arboleda::{Block, Clustered, Index, Octree, Options, Ray, RayIndex, Scene, Triangle, Vec3};
//!
//! let corner = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
//! let far_corner = Triangle::new(Vec3::splat(50.0), Vec3::new(51.0, 50.0, 50.0), Vec3::new(50.0, 51.0, 50.0));
//! let triangles = [corner, far_corner];
//! let (scene, options) = (Scene::new(&triangles), Options::default());
//!
//! let mut scratch = [Block::ZERO; 64]; // 4 KiB
//! let mut arena = [Block::ZERO; 8]; // 512 bytes
//! let index = Index::<Clustered<Octree>>::build(
//!     &scene, &options, Block::bytes(&mut arena), Block::bytes(&mut scratch))?;
//! let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z)?;
//! assert_eq!(index.closest_hit(&ray).map(|hit| (hit.triangle.0, hit.t)), Some((0, 1.0)));
//! assert_eq!(index.cluster_count(), 2);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
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

pub mod auto;
mod capacity;
pub mod cluster;
mod error;
mod executor;
pub mod geometry;
mod index;
pub mod indices;
pub mod memory;
mod mesh;
pub mod query;
mod scene;
mod stored;
mod vectors;

pub use capacity::Capacity;
pub use error::{BuildError, ImageError};
pub use executor::{Executor, Sequential};
pub use geometry::{Aabb, Ray, RayError, Triangle, intersect};
pub use glam::{self, Vec3};
pub use index::{Index, RayIndex, Representation};
#[cfg(feature = "bsp-tree")]
pub use indices::BspTree;
#[cfg(feature = "bvh")]
pub use indices::Bvh;
#[cfg(feature = "compact-bvh")]
pub use indices::CompactBvh;
#[cfg(feature = "kd-tree")]
pub use indices::KdTree;
#[cfg(feature = "lean-bvh")]
pub use indices::LeanBvh;
#[cfg(feature = "octree")]
pub use indices::Octree;
#[cfg(feature = "octree-r")]
pub use indices::OctreeR;
#[cfg(feature = "uniform-grid")]
pub use indices::UniformGrid;
#[cfg(feature = "wide-bvh")]
pub use indices::WideBvh;
pub use indices::{AnyIndex, Clustered, IndexKind, Linear};
pub use memory::Block;
pub use mesh::{Mesh, MeshError};
pub use query::{AllHits, Counters, Hit, TriangleId};
pub use scene::{BvhBuild, Float64, Level, Options, Resolution, Scene};
pub use stored::{Storage, Stored};
pub use vectors::Vectors;
