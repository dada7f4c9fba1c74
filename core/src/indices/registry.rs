//! The list of all indices: one line for each kind, with its number and the module whose `scratch_bytes` it uses.

#[cfg(feature = "bsp-tree")]
use super::BspTree;
#[cfg(feature = "bvh")]
use super::Bvh;
#[cfg(feature = "compact-bvh")]
use super::CompactBvh;
#[cfg(feature = "kd-tree")]
use super::KdTree;
#[cfg(feature = "lean-bvh")]
use super::LeanBvh;
#[cfg(feature = "octree")]
use super::Octree;
#[cfg(feature = "octree-r")]
use super::OctreeR;
#[cfg(feature = "uniform-grid")]
use super::UniformGrid;
#[cfg(feature = "wide-bvh")]
use super::WideBvh;
use super::{Clustered, Linear, Structure};
use crate::auto::CostModel;
use crate::capacity::{Capacity, scratch_with};
use crate::index::{Index, RayIndex, Representation};
use crate::memory::Image;
use crate::query::{AllHits, Counters, Hit};
use crate::{
    BuildError, Executor, ImageError, Mesh, Options, Ray, Scene, Sequential, indices::Statistics,
};

registry! {
    /// Every triangle, one after the other: the oracle.
    #[cfg(all())] // Always: the macro wants a condition in every line.
    Linear = 0: Linear in linear,
    /// One octree over everything.
    #[cfg(feature = "octree")]
    Octree = 1: Octree in octants,
    /// The paper's octree hierarchy.
    #[cfg(feature = "octree")]
    OctreeHierarchy = 2: Clustered<Octree> in octants,
    /// One octree-R over everything.
    #[cfg(feature = "octree-r")]
    OctreeR = 3: OctreeR in octants,
    /// An octree-R for each cluster.
    #[cfg(feature = "octree-r")]
    OctreeRHierarchy = 4: Clustered<OctreeR> in octants,
    /// One uniform grid over everything.
    #[cfg(feature = "uniform-grid")]
    UniformGrid = 5: UniformGrid in uniform_grid,
    /// The hierarchy of uniform grids of Cazals, Drettakis and Puech.
    #[cfg(feature = "uniform-grid")]
    GridHierarchy = 6: Clustered<UniformGrid> in uniform_grid,
    /// One kd-tree over everything.
    #[cfg(feature = "kd-tree")]
    KdTree = 7: KdTree in plane_tree,
    /// A kd-tree for each cluster.
    #[cfg(feature = "kd-tree")]
    KdTreeHierarchy = 8: Clustered<KdTree> in plane_tree,
    /// One BSP tree over everything.
    #[cfg(feature = "bsp-tree")]
    BspTree = 9: BspTree in plane_tree,
    /// A BSP tree for each cluster.
    #[cfg(feature = "bsp-tree")]
    BspTreeHierarchy = 10: Clustered<BspTree> in plane_tree,
    /// One bounding volume hierarchy over everything.
    #[cfg(feature = "bvh")]
    Bvh = 11: Bvh in bvh,
    /// A bounding volume hierarchy for each cluster.
    #[cfg(feature = "bvh")]
    BvhHierarchy = 12: Clustered<Bvh> in bvh,
    /// One wide BVH over everything.
    #[cfg(feature = "wide-bvh")]
    WideBvh = 13: WideBvh in wide_bvh,
    /// A wide BVH for each cluster.
    #[cfg(feature = "wide-bvh")]
    WideBvhHierarchy = 14: Clustered<WideBvh> in wide_bvh,
    /// One compact BVH over everything.
    #[cfg(feature = "compact-bvh")]
    CompactBvh = 15: CompactBvh in wide_bvh,
    /// A compact BVH for each cluster.
    #[cfg(feature = "compact-bvh")]
    CompactBvhHierarchy = 16: Clustered<CompactBvh> in wide_bvh,
    /// One lean BVH over everything.
    #[cfg(feature = "lean-bvh")]
    LeanBvh = 17: LeanBvh in wide_bvh,
    /// A lean BVH for each cluster.
    #[cfg(feature = "lean-bvh")]
    LeanBvhHierarchy = 18: Clustered<LeanBvh> in wide_bvh,
}

macro_rules! registry {
    (
        $(
            $(#[doc = $doc:literal])*
            #[cfg($($included:tt)*)]
            $variant:ident = $number:literal: $representation:ident $(<$local:ident>)? in $room:ident,
        )*
    ) => {
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
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum IndexKind {
            $($(#[doc = $doc])* #[cfg($($included)*)] $variant = $number,)*
        }

        impl IndexKind {
            /// All that are compiled in; the oracle first.
            pub const ALL: &'static [Self] = &[$(#[cfg($($included)*)] Self::$variant),*];

            /// The name on command lines and in tables.
            pub const fn name(self) -> &'static str {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => <$representation$(<$local>)? as Representation>::NAME,)*
                }
            }

            /// The name of the simple index, which is the feature that compiles the kind in.
            pub const fn family(self) -> &'static str {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        <<$representation$(<$local>)? as Representation>::Structure as Structure>::NAME
                    })*
                }
            }

            /// The number of its images; see [`Representation::KIND`].
            pub const fn image_kind(self) -> u32 {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        <$representation$(<$local>)? as Representation>::KIND
                    })*
                }
            }

            /// Whether it holds the triangles in a form of its own, and cannot lie [beside](Scene::beside) them.
            pub const fn holds_triangles(self) -> bool {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        <<$representation$(<$local>)? as Representation>::Structure as Structure>::HOLDS_TRIANGLES
                    })*
                }
            }

            /// Whether what is built goes by [`Scene::rays`]. No answer does.
            pub const fn goes_by_rays(self) -> bool {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        <<$representation$(<$local>)? as Representation>::Structure as Structure>::GOES_BY_RAYS
                    })*
                }
            }

            /// Whether it works on clusters.
            pub const fn is_clustered(self) -> bool {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => <$representation$(<$local>)? as Representation>::CLUSTERED,)*
                }
            }

            /// What a node costs in triangle tests, for deciding how far to divide; measured by the host's
            /// `compare --calibrate`.
            pub const fn cost_model(self) -> CostModel {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        <<$representation$(<$local>)? as Representation>::Structure as Structure>::COST
                    })*
                }
            }

            /// The scratch bytes that are enough for `triangle_count` triangles: a proven bound, as
            /// [`Index::scratch_capacity`], and a constant where it has to be one.
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
                    $(#[cfg($($included)*)] Self::$variant => {
                        let structure = super::$room::scratch_bytes(triangle_count, options);
                        scratch_with::<$representation$(<$local>)?>(triangle_count, structure)
                    })*
                }
            }

            /// See [`Index::capacity`].
            ///
            /// # Errors
            /// As there.
            pub fn capacity(
                self,
                scene: &Scene<'_>,
                options: &Options,
                scratch: &mut [u8],
            ) -> Result<Capacity, BuildError> {
                self.capacity_with(scene, options, scratch, &Sequential)
            }

            /// See [`Index::capacity_with`].
            ///
            /// # Errors
            /// As there.
            pub fn capacity_with(
                self,
                scene: &Scene<'_>,
                options: &Options,
                scratch: &mut [u8],
                executor: &impl Executor,
            ) -> Result<Capacity, BuildError> {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        Index::<$representation$(<$local>)?>::capacity_with(scene, options, scratch, executor)
                    })*
                }
            }

            /// See [`Index::build`].
            ///
            /// # Errors
            /// As there.
            pub fn build<'a>(
                self,
                scene: &Scene<'a>,
                options: &Options,
                arena: &'a mut [u8],
                scratch: &mut [u8],
            ) -> Result<AnyIndex<'a>, BuildError> {
                self.build_with(scene, options, arena, scratch, &Sequential)
            }

            /// See [`Index::build_with`].
            ///
            /// # Errors
            /// As there.
            pub fn build_with<'a>(
                self,
                scene: &Scene<'a>,
                options: &Options,
                arena: &'a mut [u8],
                scratch: &mut [u8],
                executor: &impl Executor,
            ) -> Result<AnyIndex<'a>, BuildError> {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        Index::build_with(scene, options, arena, scratch, executor)
                            .map(AnyIndex::$variant)
                    })*
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
                    $(#[cfg($($included)*)] Self::$variant => {
                        Index::build_counted(scene, options, arena, scratch, executor, steps)
                            .map(AnyIndex::$variant)
                    })*
                }
            }

            /// See [`Index::from_bytes`].
            ///
            /// # Errors
            /// As there.
            pub fn from_bytes(self, bytes: &[u8]) -> Result<AnyIndex<'_>, ImageError> {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => Index::from_bytes(bytes).map(AnyIndex::$variant),)*
                }
            }

            /// See [`Index::from_bytes_beside`].
            ///
            /// # Errors
            /// As there.
            pub fn from_bytes_beside<'a>(
                self,
                bytes: &'a [u8],
                mesh: Mesh<'a>,
            ) -> Result<AnyIndex<'a>, ImageError> {
                match self {
                    $(#[cfg($($included)*)] Self::$variant => {
                        Index::from_bytes_beside(bytes, mesh).map(AnyIndex::$variant)
                    })*
                }
            }
        }

        /// An index of any kind.
        #[derive(Clone, Copy)]
        pub enum AnyIndex<'a> {
            $($(#[doc = $doc])* #[cfg($($included)*)] $variant(Index<'a, $representation$(<$local>)?>),)*
        }

        impl<'a> AnyIndex<'a> {
            /// Which kind it is.
            pub const fn kind(&self) -> IndexKind {
                match self {
                    $(#[cfg($($included)*)] Self::$variant(_) => IndexKind::$variant,)*
                }
            }

            /// The parts that the index consists of.
            pub fn image(&self) -> &Image<'a> {
                match self {
                    $(#[cfg($($included)*)] Self::$variant(index) => index.image(),)*
                }
            }

            /// See [`Index::check`].
            ///
            /// # Errors
            /// As there.
            pub fn check(&self) -> Result<Statistics, ImageError> {
                match self {
                    $(#[cfg($($included)*)] Self::$variant(index) => index.check(),)*
                }
            }

            /// The index behind the kind; ask it directly in a hot loop.
            pub fn as_ray_index(&self) -> &(dyn RayIndex + Sync + 'a) {
                match self {
                    $(#[cfg($($included)*)] Self::$variant(index) => index,)*
                }
            }
        }
    };
}
use registry;

impl RayIndex for AnyIndex<'_> {
    fn as_bytes(&self) -> &[u8] {
        self.image().bytes()
    }

    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.as_ray_index().closest_hit(ray)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.as_ray_index().occluded(ray)
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.as_ray_index().closest_hits(rays, hits);
    }

    fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.as_ray_index().occluded_each(rays, occluded);
    }

    fn all_hits<'h>(&self, ray: &Ray, buffer: &'h mut [Hit]) -> AllHits<'h> {
        self.as_ray_index().all_hits(ray, buffer)
    }

    fn closest_hit_counted(&self, ray: &Ray, counters: &mut Counters) -> Option<Hit> {
        self.as_ray_index().closest_hit_counted(ray, counters)
    }

    fn occluded_counted(&self, ray: &Ray, counters: &mut Counters) -> bool {
        self.as_ray_index().occluded_counted(ray, counters)
    }
}
