//! Registry of all indices: an entry for each family. `IndexKind`, `AnyIndex` and their tables follow from it.

use super::description::{Description, FAMILY, are_equal};
use super::{Capacity, Index, PiecewiseBuild, RayIndex, is_in_pieces, scratch_with};
use crate::cluster::{ClusterTree, Clusters};
use crate::error::{BuildError, OpenError};
#[cfg(feature = "bsp-tree")]
use crate::indices::BspTree;
#[cfg(feature = "bvh")]
use crate::indices::Bvh;
#[cfg(feature = "compact-bvh")]
use crate::indices::CompactBvh;
#[cfg(feature = "kd-tree")]
use crate::indices::KdTree;
#[cfg(feature = "lean-bvh")]
use crate::indices::LeanBvh;
#[cfg(feature = "octree")]
use crate::indices::Octree;
#[cfg(feature = "octree-r")]
use crate::indices::OctreeR;
#[cfg(feature = "uniform-grid")]
use crate::indices::UniformGrid;
#[cfg(feature = "wide-bvh")]
use crate::indices::WideBvh;
use crate::indices::{Clustered, Linear};
use crate::input::{Executor, Mesh, Options, Scene};
use crate::structure::{Sections, Statistics};

registry! {
    /// Kind of an index, chosen at run time. A kind that is left out of the build has no variant; the numbers of the
    /// others do not change.
    ///
    /// # Stack
    /// Bounds in bytes on a Cortex-M4 (thumbv7em, `opt-level = 3`), below the stack pointer at the call. `.ci/run
    /// stacks` fails if one is exceeded. With `opt-level = "s"`, queries take up to 12 KB. `core/firmware/README.md`
    /// measures that, also on a Cortex-M0 and an RV32IMAC. Without optimisation, expect twice as much and more.
    ///
    /// - A query has frames of fixed sizes and does not recurse, so its bounds hold for every scene.
    /// - The build of a tree recurses once for each level. Its bounds hold for the 456 triangles of the check. A deeper
    ///   tree takes a frame more a level, for at most 21 levels in octrees, 60 in kd-trees and BSP trees, 89 in wide
    ///   BVHs. The build of a binary BVH by bins does not recurse, so its bound holds for every scene.
    /// - The filters decide an ordinary ray. The column *any ray* also covers rays that hit a corner exactly, lie in a
    ///   plane, begin far away or have a negative `t_min`.
    /// - Opening is [`Index::from_bytes`](crate::Index::from_bytes); its bound holds for every index.
    /// - A batch is [`RayIndex::closest_hits`].
    ///
    /// | kind | ordinary ray | any ray | batch | build | open |
    /// |---|---|---|---|---|---|
    /// | linear | 2496 | 3328 | 3008 | 1088 | 832 |
    /// | octree | 5696 | 6528 | 6208 | 5632 | 1856 |
    /// | octree-hierarchy | 5696 | 6528 | 6208 | 4544 | 1856 |
    /// | octree-r | 5632 | 6464 | 6208 | 4672 | 1856 |
    /// | octree-r-hierarchy | 5632 | 6464 | 6208 | 4544 | 1856 |
    /// | uniform-grid | 2816 | 3648 | 3328 | 3712 | 832 |
    /// | grid-hierarchy | 2816 | 3648 | 3328 | 4544 | 832 |
    /// | kd-tree | 3264 | 4096 | 3776 | 9920 | 1024 |
    /// | kd-tree-hierarchy | 3264 | 4096 | 3776 | 7488 | 1024 |
    /// | bsp-tree | 3264 | 4096 | 3776 | 12800 | 1024 |
    /// | bsp-tree-hierarchy | 3264 | 4096 | 3776 | 4544 | 1024 |
    /// | bvh | 3328 | 4160 | 3840 | 3520 | 960 |
    /// | bvh-hierarchy | 3328 | 4160 | 3840 | 4544 | 960 |
    /// | wide-bvh | 4352 | 6272 | 6016 | 10496 | 6528 |
    /// | wide-bvh-hierarchy | 4352 | 6272 | 6016 | 11392 | 6528 |
    /// | compact-bvh | 4352 | 6336 | 6208 | 9856 | 6272 |
    /// | compact-bvh-hierarchy | 4352 | 6336 | 6208 | 10688 | 6272 |
    /// | lean-bvh | 4416 | 6400 | 6208 | 9856 | 6592 |
    /// | lean-bvh-hierarchy | 4416 | 6400 | 6208 | 10688 | 6592 |

    "linear" = 1, cfg(all()), crate::indices::linear::scratch_bytes {
        /// Linear scan: every triangle is tested.
        Linear = 0: Linear,
    }
    "octree" = 12, cfg(feature = "octree"), crate::indices::cells::octant_tree::scratch_bytes {
        /// Octree over the whole scene.
        Octree = 1: Octree,
        /// Octree for each cluster: the paper's octree hierarchy.
        OctreeHierarchy = 2: Clustered<Octree>,
    }
    "octree-r" = 3, cfg(feature = "octree-r"), crate::indices::cells::octant_tree::scratch_bytes {
        /// Octree-R over the whole scene.
        OctreeR = 3: OctreeR,
        /// Octree-R for each cluster.
        OctreeRHierarchy = 4: Clustered<OctreeR>,
    }
    "uniform-grid" = 13, cfg(feature = "uniform-grid"), crate::indices::grid::scratch_bytes {
        /// Uniform grid over the whole scene.
        UniformGrid = 5: UniformGrid,
        /// Uniform grid for each cluster: the hierarchy of Cazals, Drettakis and Puech.
        GridHierarchy = 6: Clustered<UniformGrid>,
    }
    "kd-tree" = 4, cfg(feature = "kd-tree"), crate::indices::cells::plane_tree::scratch_bytes {
        /// Kd-tree over the whole scene.
        KdTree = 7: KdTree,
        /// Kd-tree for each cluster.
        KdTreeHierarchy = 8: Clustered<KdTree>,
    }
    "bsp-tree" = 5, cfg(feature = "bsp-tree"), crate::indices::cells::plane_tree::scratch_bytes {
        /// BSP tree over the whole scene.
        BspTree = 9: BspTree,
        /// BSP tree for each cluster.
        BspTreeHierarchy = 10: Clustered<BspTree>,
    }
    "bvh" = 7, cfg(feature = "bvh"), crate::indices::bvh::scratch_bytes {
        /// Bounding volume hierarchy (binary BVH) over the whole scene.
        Bvh = 11: Bvh,
        /// Bounding volume hierarchy (binary BVH) for each cluster.
        BvhHierarchy = 12: Clustered<Bvh>,
    }
    "wide-bvh" = 9, cfg(feature = "wide-bvh"), crate::indices::wide::scratch_bytes {
        /// Wide BVH (BVH8 in `f32`) over the whole scene.
        WideBvh = 13: WideBvh,
        /// Wide BVH (BVH8 in `f32`) over the clusters.
        WideBvhHierarchy = 14: Clustered<WideBvh>,
    }
    "compact-bvh" = 10, cfg(feature = "compact-bvh"), crate::indices::wide::scratch_bytes {
        /// Compact BVH (BVH8 in 16 bits) over the whole scene.
        CompactBvh = 15: CompactBvh,
        /// Compact BVH (BVH8 in 16 bits) over the clusters.
        CompactBvhHierarchy = 16: Clustered<CompactBvh>,
    }
    "lean-bvh" = 11, cfg(feature = "lean-bvh"), crate::indices::wide::scratch_bytes {
        /// Lean BVH (BVH8 in 16 bits, beside a mesh) over the whole scene.
        LeanBvh = 17: LeanBvh,
        /// Lean BVH (BVH8 in 16 bits, beside a mesh) over the clusters.
        LeanBvhHierarchy = 18: Clustered<LeanBvh>,
    }
}

/// Expands the entries. An entry has
/// 1. the name of the family: its feature, and [`Described::NAME`](crate::custom::Described::NAME),
/// 2. the number of its format, which is known also if the family is left out of the build,
/// 3. the condition under which the family is compiled,
/// 4. the bound on its scratch,
/// 5. its kinds with their numbers.
macro_rules! registry {
    (
        $(#[doc = $enum_doc:literal])*
        $(
            $family:literal = $format:literal, cfg($included:meta), $scratch_bytes:path {
                $(
                    $(#[doc = $doc:literal])*
                    $variant:ident = $number:literal: $representation:ident $(<$local:ident>)?,
                )*
            }
        )*
    ) => {
        /// Families by the number of their format, compiled in or not.
        pub(super) const FAMILIES: &[(u32, &str)] = &[$(($format, $family)),*];

        $(#[doc = $enum_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum IndexKind {
            $($($(#[doc = $doc])* #[cfg($included)] $variant = $number,)*)*
        }

        impl IndexKind {
            /// All kinds that are compiled in; the linear scan first.
            pub const ALL: &'static [Self] = &[$($(#[cfg($included)] Self::$variant),*),*];

            pub(super) const fn description(self) -> Description {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        Description::of::<$representation$(<$local>)?>()
                    })*)*
                }
            }

            /// Bounds the scratch bytes that a build for `triangle_count` triangles needs, as
            /// [`Index::scratch_capacity`](crate::Index::scratch_capacity) does, and also in a constant. The bound is
            /// proven.
            ///
            /// # Examples
            /// ```
            /// use arboleda::{Block, IndexKind, Options};
            ///
            /// const SCRATCH: usize = IndexKind::Linear.scratch_capacity(200, &Options::DEFAULT);
            /// static mut ROOM: [Block; Block::count(SCRATCH)] = [Block::ZERO; Block::count(SCRATCH)];
            /// ```
            pub const fn scratch_capacity(self, triangle_count: usize, options: &Options) -> usize {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        let structure = $scratch_bytes(triangle_count, options);
                        scratch_with::<$representation$(<$local>)?>(triangle_count, structure)
                    })*)*
                }
            }

            /// Measures the memory and the work of a build, with the help of an executor; see
            /// [`Index::capacity_with`](crate::Index::capacity_with).
            ///
            /// # Errors
            /// The errors of [`Index::capacity`](crate::Index::capacity).
            pub fn capacity_with(
                self,
                scene: &Scene<'_>,
                options: &Options,
                scratch: &mut [u8],
                executor: &impl Executor,
            ) -> Result<Capacity, BuildError> {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        Index::<$representation$(<$local>)?>::capacity_with(scene, options, scratch, executor)
                    })*)*
                }
            }

            /// Tells whether the kind can be built [in pieces](PiecewiseBuild): whether each cluster has an index of its
            /// own.
            pub const fn can_be_built_in_pieces(self) -> bool {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        is_in_pieces::<$representation$(<$local>)?>()
                    })*)*
                }
            }

            /// The bytes of memory of a build in pieces; see [`PiecewiseBuild::memory_bytes`].
            pub fn memory_in_pieces(self, clusters: &Clusters<'_>, options: &Options) -> usize {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        PiecewiseBuild::memory_bytes::<$representation$(<$local>)?>(clusters, options)
                    })*)*
                }
            }

            /// Begins a build in pieces; see [`PiecewiseBuild::new`].
            ///
            /// # Errors
            /// The errors of [`PiecewiseBuild::new`].
            pub fn build_in_pieces<'a, 's>(
                self,
                scene: &Scene<'a>,
                options: &Options,
                clusters: &'s Clusters<'s>,
                memory: &'s mut [u8],
            ) -> Result<PiecewiseBuild<'a, 's>, BuildError> {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        PiecewiseBuild::new::<$representation$(<$local>)?>(scene, options, clusters, memory)
                    })*)*
                }
            }

            pub(crate) fn build_counted<'a>(
                self,
                scene: &Scene<'a>,
                options: &Options,
                arena: &'a mut [u8],
                scratch: &mut [u8],
                executor: &impl Executor,
                steps: &mut u64,
            ) -> Result<AnyIndex<'a>, BuildError> {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        Index::build_counted(scene, options, arena, scratch, executor, steps)
                            .map(AnyIndex::$variant)
                    })*)*
                }
            }

            pub(super) fn read<'a>(
                self,
                bytes: &'a [u8],
                mesh: Option<Mesh<'a>>,
            ) -> Result<(AnyIndex<'a>, Statistics), OpenError> {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        Index::read(bytes, mesh).map(|(index, statistics)| (AnyIndex::$variant(index), statistics))
                    })*)*
                }
            }

            /// Opens the bytes of an index by its header alone.
            pub(super) fn view(self, bytes: &[u8]) -> Result<AnyIndex<'_>, OpenError> {
                let sections = Sections::view(bytes, None)?;
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        Ok(AnyIndex::$variant(Index::of_checked(sections)))
                    })*)*
                }
            }
        }

        /// Index of any kind.
        #[derive(Clone, Copy, Debug)]
        #[non_exhaustive]
        pub enum AnyIndex<'a> {
            $($($(#[doc = $doc])* #[cfg($included)] $variant(Index<'a, $representation$(<$local>)?>),)*)*
        }

        impl<'a> AnyIndex<'a> {
            /// The kind of the index.
            pub const fn kind(&self) -> IndexKind {
                match self {
                    $($(#[cfg($included)] Self::$variant(_) => IndexKind::$variant,)*)*
                }
            }

            /// The sections of the index: triangles, cluster tree and words.
            pub fn sections(&self) -> &Sections<'a> {
                match self {
                    $($(#[cfg($included)] Self::$variant(index) => index.sections(),)*)*
                }
            }

            /// The tree that joins the clusters.
            pub fn cluster_tree(&self) -> ClusterTree<'a> {
                self.sections().cluster_tree()
            }

            /// Checks the invariants of the whole structure; see [`Index::check`].
            ///
            /// # Errors
            /// The errors of [`Index::check`].
            pub fn check(&self) -> Result<Statistics, OpenError> {
                match self {
                    $($(#[cfg($included)] Self::$variant(index) => index.check(),)*)*
                }
            }

            /// The index as a trait object. In a loop over single rays, call its queries instead, to choose the kind
            /// only once.
            pub fn as_ray_index(&self) -> &(dyn RayIndex + Sync + 'a) {
                match self {
                    $($(#[cfg($included)] Self::$variant(index) => index,)*)*
                }
            }
        }

        // Each entry agrees with the description of its indices.
        $($(#[cfg($included)] const _: () = {
            let described = Description::of::<$representation$(<$local>)?>();
            assert!(described.format & FAMILY == $format && are_equal(described.family, $family));
        };)*)*
    };
}
use registry;
