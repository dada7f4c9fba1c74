//! The list of all indices: one line each.

use super::{
    BspTree, Bvh, Clustered, CompactOctree, KdTree, LeanOctree, Linear, Octree, OctreeR, Structure,
    UniformGrid, WideOctree,
};
use crate::auto::CostModel;
use crate::index::{Capacity, Index, RayIndex, Representation};
use crate::memory::Image;
use crate::query::{AllHits, Counters, Hit};
use crate::{
    BuildError, Executor, ImageError, Mesh, Options, Ray, Scene, Sequential, indices::Statistics,
};

registry! {
    /// Every triangle, one after the other: the oracle.
    Linear = Linear,
    /// One octree over everything.
    Octree = Octree,
    /// The paper's octree hierarchy.
    OctreeHierarchy = Clustered<Octree>,
    /// One octree-R over everything.
    OctreeR = OctreeR,
    /// An octree-R for each cluster.
    OctreeRHierarchy = Clustered<OctreeR>,
    /// One uniform grid over everything.
    UniformGrid = UniformGrid,
    /// The hierarchy of uniform grids of Cazals, Drettakis and Puech.
    GridHierarchy = Clustered<UniformGrid>,
    /// One kd-tree over everything.
    KdTree = KdTree,
    /// A kd-tree for each cluster.
    KdTreeHierarchy = Clustered<KdTree>,
    /// One BSP tree over everything.
    BspTree = BspTree,
    /// A BSP tree for each cluster.
    BspTreeHierarchy = Clustered<BspTree>,
    /// One bounding volume hierarchy over everything.
    Bvh = Bvh,
    /// A bounding volume hierarchy for each cluster.
    BvhHierarchy = Clustered<Bvh>,
    /// One wide octree over everything.
    WideOctree = WideOctree,
    /// A wide octree for each cluster.
    WideOctreeHierarchy = Clustered<WideOctree>,
    /// One compact octree over everything.
    CompactOctree = CompactOctree,
    /// A compact octree for each cluster.
    CompactOctreeHierarchy = Clustered<CompactOctree>,
    /// One lean octree over everything.
    LeanOctree = LeanOctree,
    /// A lean octree for each cluster.
    LeanOctreeHierarchy = Clustered<LeanOctree>,
}

macro_rules! registry {
    ($($(#[$doc:meta])* $variant:ident = $representation:ty,)*) => {
        /// A kind of index, chosen at run time.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum IndexKind {
            $($(#[$doc])* $variant,)*
        }

        impl IndexKind {
            /// All of them; the oracle first.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The name on command lines and in tables.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => <$representation as Representation>::NAME,)*
                }
            }

            /// Whether it holds the triangles in a form of its own, and cannot lie [beside](Scene::beside) them.
            pub const fn holds_triangles(self) -> bool {
                match self {
                    $(Self::$variant => {
                        <<$representation as Representation>::Structure as Structure>::HOLDS_TRIANGLES
                    })*
                }
            }

            /// Whether what is built goes by [`Scene::rays`]. No answer does.
            pub const fn goes_by_rays(self) -> bool {
                match self {
                    $(Self::$variant => {
                        <<$representation as Representation>::Structure as Structure>::GOES_BY_RAYS
                    })*
                }
            }

            /// Whether it works on clusters.
            pub const fn is_clustered(self) -> bool {
                match self {
                    $(Self::$variant => <$representation as Representation>::CLUSTERED,)*
                }
            }

            /// What a node costs in triangle tests, for deciding how far to divide; measured by the host's
            /// `compare --calibrate`.
            pub const fn cost_model(self) -> CostModel {
                match self {
                    $(Self::$variant => {
                        <<$representation as Representation>::Structure as Structure>::COST
                    })*
                }
            }

            /// See [`Index::scratch_capacity`].
            pub fn scratch_capacity(self, triangle_count: usize, options: &Options) -> usize {
                match self {
                    $(Self::$variant => {
                        Index::<$representation>::scratch_capacity(triangle_count, options)
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
                    $(Self::$variant => {
                        Index::<$representation>::capacity_with(scene, options, scratch, executor)
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
                    $(Self::$variant => {
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
                    $(Self::$variant => {
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
                    $(Self::$variant => Index::from_bytes(bytes).map(AnyIndex::$variant),)*
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
                    $(Self::$variant => {
                        Index::from_bytes_beside(bytes, mesh).map(AnyIndex::$variant)
                    })*
                }
            }
        }

        /// An index of any kind.
        #[derive(Clone, Copy)]
        pub enum AnyIndex<'a> {
            $($(#[$doc])* $variant(Index<'a, $representation>),)*
        }

        impl<'a> AnyIndex<'a> {
            /// Which kind it is.
            pub const fn kind(&self) -> IndexKind {
                match self {
                    $(Self::$variant(_) => IndexKind::$variant,)*
                }
            }

            /// The parts that the index consists of.
            pub fn image(&self) -> &Image<'a> {
                match self {
                    $(Self::$variant(index) => index.image(),)*
                }
            }

            /// See [`Index::check`].
            ///
            /// # Errors
            /// As there.
            pub fn check(&self) -> Result<Statistics, ImageError> {
                match self {
                    $(Self::$variant(index) => index.check(),)*
                }
            }

            /// The index behind the kind; ask it directly in a hot loop.
            pub fn as_ray_index(&self) -> &(dyn RayIndex + Sync + 'a) {
                match self {
                    $(Self::$variant(index) => index,)*
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
