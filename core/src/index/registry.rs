//! The list of all indices: an entry for each family, from which the kinds and what is known of them follow.

use super::description::{Description, FAMILY, are_equal};
use super::{Capacity, Index, RayIndex, scratch_with};
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
    /// A kind of index, chosen at run time. Kinds that are left out of the build have no variant here; the
    /// numbers of the others stay what they are.
    ///
    /// # Stack
    /// Bounds in bytes on a Cortex-M4 (thumbv7em, optimised), from the caller's frame down; `.ci/run stacks` fails
    /// where one is broken.
    ///
    /// Queries have frames of fixed sizes and do not recurse, so their bounds hold for every scene. Builds of trees
    /// recurse once for each level: their bounds hold for the 456 triangles of the check, and a deeper tree takes
    /// more, a frame a level, for at most 21 levels in octrees, 60 in kd- and BSP trees, 62 in bounding volume
    /// hierarchies, 89 in wide BVHs.
    ///
    /// An ordinary ray is decided by the filters; any ray may also hit a corner exactly, lie in a plane, begin far
    /// away or at a negative `t_min`. A batch is [`RayIndex::closest_hits`].
    ///
    /// | kind | ordinary ray | any ray | batch | build |
    /// |---|---|---|---|---|
    /// | linear | 2240 | 3904 | 3968 | 896 |
    /// | octree | 6464 | 8064 | 8192 | 5888 |
    /// | octree-hierarchy | 6464 | 8064 | 8192 | 2752 |
    /// | octree-r | 6464 | 8128 | 8192 | 4800 |
    /// | octree-r-hierarchy | 6464 | 8128 | 8192 | 3008 |
    /// | uniform-grid | 2880 | 4544 | 4608 | 4032 |
    /// | grid-hierarchy | 2880 | 4544 | 4608 | 4032 |
    /// | kd-tree | 3904 | 5504 | 5504 | 15936 |
    /// | kd-tree-hierarchy | 3904 | 5504 | 5504 | 9344 |
    /// | bsp-tree | 3904 | 5504 | 5504 | 14848 |
    /// | bsp-tree-hierarchy | 3904 | 5504 | 5504 | 4224 |
    /// | bvh | 4032 | 5632 | 5632 | 10368 |
    /// | bvh-hierarchy | 4032 | 5632 | 5632 | 8192 |
    /// | wide-bvh | 3776 | 6528 | 6656 | 14912 |
    /// | wide-bvh-hierarchy | 3776 | 6528 | 6656 | 15808 |
    /// | compact-bvh | 3776 | 5376 | 6912 | 14272 |
    /// | compact-bvh-hierarchy | 3776 | 5376 | 6912 | 15104 |
    /// | lean-bvh | 4032 | 6976 | 7232 | 14272 |
    /// | lean-bvh-hierarchy | 4032 | 6976 | 7232 | 15104 |

    "linear" = 1, cfg(all()), crate::indices::linear::scratch_bytes {
        /// Every triangle, one after the other: the oracle.
        Linear = 0: Linear,
    }
    "octree" = 2, cfg(feature = "octree"), crate::indices::cells::octant_tree::scratch_bytes {
        /// One octree over everything.
        Octree = 1: Octree,
        /// The paper's octree hierarchy.
        OctreeHierarchy = 2: Clustered<Octree>,
    }
    "octree-r" = 3, cfg(feature = "octree-r"), crate::indices::cells::octant_tree::scratch_bytes {
        /// One octree-R over everything.
        OctreeR = 3: OctreeR,
        /// An octree-R for each cluster.
        OctreeRHierarchy = 4: Clustered<OctreeR>,
    }
    "uniform-grid" = 6, cfg(feature = "uniform-grid"), crate::indices::grid::scratch_bytes {
        /// One uniform grid over everything.
        UniformGrid = 5: UniformGrid,
        /// The hierarchy of uniform grids of Cazals, Drettakis and Puech.
        GridHierarchy = 6: Clustered<UniformGrid>,
    }
    "kd-tree" = 4, cfg(feature = "kd-tree"), crate::indices::cells::plane_tree::scratch_bytes {
        /// One kd-tree over everything.
        KdTree = 7: KdTree,
        /// A kd-tree for each cluster.
        KdTreeHierarchy = 8: Clustered<KdTree>,
    }
    "bsp-tree" = 5, cfg(feature = "bsp-tree"), crate::indices::cells::plane_tree::scratch_bytes {
        /// One BSP tree over everything.
        BspTree = 9: BspTree,
        /// A BSP tree for each cluster.
        BspTreeHierarchy = 10: Clustered<BspTree>,
    }
    "bvh" = 7, cfg(feature = "bvh"), crate::indices::bvh::scratch_bytes {
        /// One bounding volume hierarchy over everything.
        Bvh = 11: Bvh,
        /// A bounding volume hierarchy for each cluster.
        BvhHierarchy = 12: Clustered<Bvh>,
    }
    "wide-bvh" = 9, cfg(feature = "wide-bvh"), crate::indices::wide::scratch_bytes {
        /// One wide BVH over everything.
        WideBvh = 13: WideBvh,
        /// A wide BVH for each cluster.
        WideBvhHierarchy = 14: Clustered<WideBvh>,
    }
    "compact-bvh" = 10, cfg(feature = "compact-bvh"), crate::indices::wide::scratch_bytes {
        /// One compact BVH over everything.
        CompactBvh = 15: CompactBvh,
        /// A compact BVH for each cluster.
        CompactBvhHierarchy = 16: Clustered<CompactBvh>,
    }
    "lean-bvh" = 11, cfg(feature = "lean-bvh"), crate::indices::wide::scratch_bytes {
        /// One lean BVH over everything.
        LeanBvh = 17: LeanBvh,
        /// A lean BVH for each cluster.
        LeanBvhHierarchy = 18: Clustered<LeanBvh>,
    }
}

/// An entry: the feature, which is the name of the simple index, and the number of its format, also where it is left out
/// of the build; when it is compiled; the bound on its scratch; and its kinds with their numbers.
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
        /// The families by the number of their format, whether they are compiled in or not.
        pub(super) const FAMILIES: &[(u32, &str)] = &[$(($format, $family)),*];

        $(#[doc = $enum_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum IndexKind {
            $($($(#[doc = $doc])* #[cfg($included)] $variant = $number,)*)*
        }

        impl IndexKind {
            /// All that are compiled in; the oracle first.
            pub const ALL: &'static [Self] = &[$($(#[cfg($included)] Self::$variant),*),*];

            pub(super) const fn description(self) -> Description {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        Description::of::<$representation$(<$local>)?>()
                    })*)*
                }
            }

            pub(super) const fn scratch_bytes(self, triangle_count: usize, options: &Options) -> usize {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        let structure = $scratch_bytes(triangle_count, options);
                        scratch_with::<$representation$(<$local>)?>(triangle_count, structure)
                    })*)*
                }
            }

            pub(super) fn measure(
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
            ) -> Result<AnyIndex<'a>, OpenError> {
                match self {
                    $($(#[cfg($included)] Self::$variant => {
                        Index::read(bytes, mesh).map(AnyIndex::$variant)
                    })*)*
                }
            }
        }

        /// An index of any kind.
        #[derive(Clone, Copy)]
        #[non_exhaustive]
        pub enum AnyIndex<'a> {
            $($($(#[doc = $doc])* #[cfg($included)] $variant(Index<'a, $representation$(<$local>)?>),)*)*
        }

        impl<'a> AnyIndex<'a> {
            /// Which kind it is.
            pub const fn kind(&self) -> IndexKind {
                match self {
                    $($(#[cfg($included)] Self::$variant(_) => IndexKind::$variant,)*)*
                }
            }

            /// The sections of its bytes.
            pub fn sections(&self) -> &Sections<'a> {
                match self {
                    $($(#[cfg($included)] Self::$variant(index) => index.sections(),)*)*
                }
            }

            /// See [`Index::check`].
            ///
            /// # Errors
            /// As there.
            pub fn check(&self) -> Result<Statistics, OpenError> {
                match self {
                    $($(#[cfg($included)] Self::$variant(index) => index.check(),)*)*
                }
            }

            /// The index behind the kind; ask it directly in a hot loop.
            pub fn as_ray_index(&self) -> &(dyn RayIndex + Sync + 'a) {
                match self {
                    $($(#[cfg($included)] Self::$variant(index) => index,)*)*
                }
            }
        }

        // An entry says what the index says of itself.
        $($(#[cfg($included)] const _: () = {
            let described = Description::of::<$representation$(<$local>)?>();
            assert!(described.format & FAMILY == $format && are_equal(described.family, $family));
        };)*)*
    };
}
use registry;
