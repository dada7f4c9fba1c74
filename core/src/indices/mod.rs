//! The ways to find the triangles near a ray: one file each.
//!
//! Each kind is a feature of this crate, so that one can be had without the code of the others; the linear scan is
//! always there.
//!
//! To add an index, implement [`LocalIndex`] in a file of its own behind a feature, and add a line for each of its
//! two kinds to `registry.rs` and its family to the tables of `opening.rs` and `auto/weights.rs`, where tests miss it.
//! The command line, the tests, the benches and the fuzz targets then run it, alone and clustered.

#[cfg(feature = "bsp-tree")]
mod bsp_tree;
#[cfg(feature = "bvh")]
mod bvh;
#[cfg(feature = "bvh")]
mod bvh_insertion;
#[cfg(any(feature = "octree", feature = "octree-r", feature = "kd-tree", feature = "bsp-tree"))]
mod cell;
mod clustered;
#[cfg(any(feature = "compact-bvh", feature = "lean-bvh"))]
mod compact_bvh;
#[cfg(any(feature = "octree", feature = "octree-r", feature = "kd-tree", feature = "bsp-tree"))]
mod filing;
#[cfg(feature = "kd-tree")]
mod kd_tree;
mod linear;
mod near_first;
#[cfg(any(feature = "octree", feature = "octree-r"))]
mod octants;
#[cfg(feature = "octree")]
mod octree;
#[cfg(feature = "octree-r")]
mod octree_r;
mod opening;
#[cfg(any(feature = "kd-tree", feature = "bsp-tree"))]
mod plane_tree;
mod registry;
#[cfg(any(feature = "octree-r", feature = "kd-tree"))]
mod split_cost;
#[cfg(feature = "uniform-grid")]
mod uniform_grid;
#[cfg(any(feature = "wide-bvh", feature = "compact-bvh", feature = "lean-bvh"))]
mod wide_bvh;

use core::ops::ControlFlow;

#[cfg(feature = "bsp-tree")]
pub use bsp_tree::BspTree;
#[cfg(feature = "bvh")]
pub use bvh::Bvh;
pub use clustered::Clustered;
#[cfg(feature = "compact-bvh")]
pub use compact_bvh::CompactBvh;
#[cfg(feature = "lean-bvh")]
pub use compact_bvh::LeanBvh;
#[cfg(feature = "kd-tree")]
pub use kd_tree::KdTree;
pub use linear::Linear;
#[cfg(feature = "octree")]
pub use octree::Octree;
#[cfg(feature = "octree-r")]
pub use octree_r::OctreeR;
pub use registry::{AnyIndex, IndexKind};
#[cfg(feature = "uniform-grid")]
pub use uniform_grid::UniformGrid;
#[cfg(feature = "wide-bvh")]
pub use wide_bvh::WideBvh;

use crate::auto::CostModel;
use crate::cluster::Clusters;
use crate::geometry::{Aabb, RaySpan, Span};
use crate::index::Representation;
use crate::memory::{ClusterNode, Image, Words};
use crate::query::{Query, TriangleId};
use crate::{BuildError, Executor, Mesh, Options, Ray, Vectors};

/// A spatial index over one group of triangles, written as a run of `u32` words.
///
/// It need not decide anything exactly: it shows triangles to a [`Query`], which does. It must show
/// every triangle that the ray hits in the span, unless the hit lies beyond [`Query::last`] at the time.
pub trait LocalIndex: 'static {
    /// The name of the simple representation, for command lines and tables.
    const NAME: &'static str;
    /// The name of the clustered representation.
    const HIERARCHY_NAME: &'static str;
    /// The number that tells images apart, below 2^16, never used again for another format.
    const KIND: u32;
    /// What a node costs in triangle tests, for deciding how far to divide, as it was measured;
    /// [`Options::cost`] overrides it.
    const COST: CostModel = CostModel::tests_per_node(1.0);
    /// Whether what is built goes by [`Scene::rays`](crate::Scene::rays). No answer does.
    const GOES_BY_RAYS: bool = false;

    /// A bound on the scratch bytes that a group of `triangle_count` needs.
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize;

    /// Appends the group's index to `words`, with all links relative to its first word. What is
    /// written must depend on the arguments only, and not on words read back. The work must be bounded by a multiple
    /// of `n log n` wherever the triangles lie; [`Words::spend`] counts it.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if links outgrow their field, [`BuildError::TooMuchWork`] from [`Words::spend`].
    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError>;

    /// Shows `query` the triangles near the part `span` of the ray, which lies in the group's box.
    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()>;

    /// Checks everything on which `traverse` relies to end and to stay inside, for any words, and says
    /// what the index consists of. `None` if something is wrong. Cost: linear.
    fn check(local: &Local<'_>) -> Option<Statistics>;
}

/// What lies over all clusters and answers queries.
///
/// Every [`LocalIndex`] is one: an index for each cluster, below the cluster tree. An index that mixes
/// both in its own nodes implements this instead.
pub trait Structure: 'static {
    /// The name of the simple representation, for command lines and tables.
    const NAME: &'static str;
    /// The name of the clustered representation.
    const HIERARCHY_NAME: &'static str;
    /// The number that tells images apart, below 2^16, never used again for another format.
    const KIND: u32;
    /// See [`LocalIndex::COST`].
    const COST: CostModel = CostModel::tests_per_node(1.0);
    /// See [`LocalIndex::GOES_BY_RAYS`].
    const GOES_BY_RAYS: bool = false;
    /// Whether the words hold the triangles, so that the image need not.
    const HOLDS_TRIANGLES: bool = false;
    /// True if `build` reads the cluster tree. If false, a dry run makes no tree, and [`Division::nodes`] is empty.
    const READS_TREE: bool = true;

    /// A bound on the scratch bytes that `triangle_count` triangles need, however they are divided.
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize;

    /// Writes the index to `words`, and tells the leaves of the cluster tree which words are theirs. What
    /// is written must depend on the other arguments only, and not on the executor or on words read back.
    ///
    /// # Errors
    /// [`BuildError::TooLarge`] if links outgrow their field.
    fn build(
        division: Division<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<(), BuildError>;

    /// Shows `query` the triangles near its ray, until it knows the answer.
    fn traverse<Q: Query>(image: &Image<'_>, vectors: Vectors, query: &mut Q);

    /// Answers `count` queries, in any order: `start` makes the one of a number, `finish` sees it answered.
    #[inline]
    fn traverse_each<Q: Query>(
        image: &Image<'_>,
        vectors: Vectors,
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        mut finish: impl FnMut(usize, &Q),
    ) {
        for place in 0..count {
            let Some(mut query) = start(place) else { return };
            Self::traverse(image, vectors, &mut query);
            finish(place, &query);
        }
    }

    /// Checks everything on which `traverse` relies to end and to stay inside, for any words, and says
    /// what the index consists of. Cost: linear.
    ///
    /// # Errors
    /// The number of the cluster in which something is wrong.
    fn check(image: &Image<'_>) -> Result<Statistics, u32>;
}

impl<S: Structure> Representation for S {
    type Structure = S;
    const CLUSTERED: bool = false;
    const NAME: &'static str = S::NAME;
}

/// A scene that has been divided into clusters.
pub struct Division<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// Rays such as the index will be asked about, if that is known.
    pub rays: &'a [Ray],
    /// The clusters; one if they are not asked for.
    pub clusters: &'a Clusters<'a>,
    /// The cluster tree, its leaves first; a leaf's links are the structure's affair. Empty in a dry run of a
    /// structure that does not [read](Structure::READS_TREE) it.
    pub nodes: &'a mut [ClusterNode],
}

impl Division<'_> {
    /// Tells the leaves of the cluster tree that all words belong to the first: one index over all clusters.
    pub(crate) fn first_owns(&mut self, word_count: usize) {
        let words = word_count as u32;
        for (at, (leaf, _)) in self.nodes.iter_mut().zip(self.clusters.iter()).enumerate() {
            leaf.links = if at == 0 { [0, words] } else { [words, 0] };
        }
    }
}

/// What a local index is built from.
#[derive(Clone, Copy)]
pub struct Group<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// Rays such as the scene will be asked about, if that is known; they need not come near the group.
    pub rays: &'a [Ray],
    /// Those of the group, ascending; at least one.
    pub ids: &'a [u32],
    /// The smallest box around the group.
    pub bounds: Aabb,
}

/// A local index to be queried.
#[derive(Clone, Copy)]
pub struct Local<'a> {
    /// All triangles of the scene.
    pub triangles: Mesh<'a>,
    /// The smallest box around the group.
    pub bounds: Aabb,
    /// What `build` wrote.
    pub words: &'a [u32],
}

impl<'a> Local<'a> {
    pub(crate) fn of(image: &Image<'a>, leaf: &ClusterNode) -> Self {
        Self { triangles: image.triangles(), bounds: leaf.bounds, words: image.local_words(leaf) }
    }

    /// One word; 0 past the end.
    #[inline]
    pub fn word(&self, at: u32) -> u32 {
        self.words.get(at as usize).copied().unwrap_or(0)
    }

    /// Shows `query` the triangles that `count` words from `first` name.
    #[inline]
    pub fn test<Q: Query>(&self, first: u32, count: u32, query: &mut Q) -> ControlFlow<()> {
        let first = first as usize;
        let ids = self.words.get(first..first.saturating_add(count as usize)).unwrap_or(&[]);
        // Where they lie: copies of all would cost a bounding volume hierarchy 12% more instructions.
        let Mesh::Triangles(triangles) = self.triangles else {
            return self.test_gathered(ids, query);
        };
        for &id in ids {
            if let Some(triangle) = triangles.get(id as usize) {
                query.test(TriangleId(id), triangle)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Shows triangles whose corners lie here and there.
    #[inline(never)]
    fn test_gathered<Q: Query>(&self, ids: &[u32], query: &mut Q) -> ControlFlow<()> {
        for &id in ids {
            if let Some(triangle) = self.triangles.get(id) {
                query.test(TriangleId(id), &triangle)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Tells whether `count` words from `first` are all ids of triangles.
    pub fn are_ids(&self, first: u32, count: u32) -> bool {
        let (first, count) = (first as usize, count as usize);
        let ids = self.words.get(first..first.saturating_add(count));
        ids.is_some_and(|ids| ids.iter().all(|&id| (id as usize) < self.triangles.len()))
    }
}

/// What an index consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Nodes that have children.
    pub inner_nodes: u64,
    /// Nodes that hold triangles.
    pub leaves: u64,
    /// Triangles filed, counting one filed in several leaves several times.
    pub references: u64,
    /// The most references in one leaf.
    pub largest_leaf: u32,
    /// The level of the deepest leaf; the root is level 0.
    pub deepest_level: u32,
}

impl Statistics {
    /// Both together.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        Self {
            inner_nodes: self.inner_nodes + other.inner_nodes,
            leaves: self.leaves + other.leaves,
            references: self.references + other.references,
            largest_leaf: self.largest_leaf.max(other.largest_leaf),
            deepest_level: self.deepest_level.max(other.deepest_level),
        }
    }

    /// Counts a leaf.
    pub fn add_leaf(&mut self, references: u32, level: u32) {
        self.leaves += 1;
        self.references += u64::from(references);
        self.largest_leaf = self.largest_leaf.max(references);
        self.deepest_level = self.deepest_level.max(level);
    }
}

/// Implements [`LocalIndex`] by a shared tree, of which the type is the division.
#[cfg(any(feature = "octree", feature = "octree-r", feature = "kd-tree", feature = "bsp-tree"))]
macro_rules! forward_local_index {
    ($index:ty, $tree:ident, $kind:literal, $name:literal, $tests_per_node:literal) => {
        impl $crate::indices::LocalIndex for $index {
            const NAME: &'static str = $name;
            const HIERARCHY_NAME: &'static str = concat!($name, "-hierarchy");
            const KIND: u32 = $kind;
            const COST: $crate::auto::CostModel =
                $crate::auto::CostModel::tests_per_node($tests_per_node);

            fn scratch_bytes(triangle_count: usize, options: &$crate::Options) -> usize {
                $tree::<Self>::scratch_bytes(triangle_count, options)
            }

            fn build(
                group: &Group<'_>,
                options: &$crate::Options,
                words: &mut $crate::memory::Words<'_>,
                scratch: &mut [u8],
            ) -> Result<(), $crate::BuildError> {
                $tree::<Self>::build(group, options, words, scratch)
            }

            #[inline]
            fn traverse<Q: $crate::query::Query>(
                local: &$crate::indices::Local<'_>,
                ray: &$crate::geometry::RaySpan,
                span: $crate::geometry::Span,
                query: &mut Q,
            ) -> core::ops::ControlFlow<()> {
                $tree::<Self>::traverse(local, ray, span, query)
            }

            fn check(local: &$crate::indices::Local<'_>) -> Option<$crate::indices::Statistics> {
                $tree::<Self>::check(local)
            }
        }
    };
}
#[cfg(any(
    feature = "octree",
    feature = "octree-r",
    feature = "kd-tree",
    feature = "bsp-tree"
))]
use forward_local_index;
