//! Public entry point: builds an index, opens one from bytes, answers queries.
//!
//! ```text
//! Scene, Options --build--> Index in an arena --as_bytes--> bytes --from_bytes--> Index --query--> hits
//! ```
//! - [`Index`] is an index whose kind is known at compile time. It is a [`Structure`] over the whole scene, or over its
//!   clusters.
//! - [`AnyIndex`] is an index of any kind, chosen at run time by [`IndexKind`].
//! - [`RayIndex`] has the queries of both, for generic and `dyn` use.
//! - [`LocalIndex`](crate::custom::LocalIndex) is what the author of an index implements, or [`Structure`] for an index
//!   that does not keep clusters apart.

mod capacity;
mod description;
mod kind;
#[cfg(feature = "alloc")]
mod owned;
mod queries;
mod ray_index;
mod registry;
pub mod select;
mod stepwise;
mod stored;

use core::marker::PhantomData;

pub use capacity::Capacity;
pub(crate) use capacity::scratch_with;
#[cfg(feature = "alloc")]
pub use owned::OwnedIndex;
pub use queries::BATCH_SCRATCH;
pub use ray_index::RayIndex;
pub use registry::{AnyIndex, IndexKind};
#[cfg(feature = "wide-bvh")]
pub use stepwise::SlicedBuild;
use stepwise::is_in_pieces;
pub use stepwise::{Piece, PiecewiseBuild};
pub use stored::{Storage, Stored};

use crate::cluster::{self, ClusterNode, ClusterTree};
use crate::error::{BuildError, OpenError};
use crate::input::{Executor, Mesh, Options, Scene, Sequential, SimdLevel};
use crate::memory::{Arena, Words};
use crate::structure::sections::{Layout, MESH_BESIDE, Sections, encode_header};
use crate::structure::{Described, DividedScene, Representation, Statistics, Structure};

/// Index in an arena, of the kind `R`: a marker of [`crate::kinds`].
///
/// A `Copy` view of the bytes in the arena, some 100 bytes on 64 bits. Opened once, an `Index<'static, R>` of bytes in
/// ROM may be kept and shared.
pub struct Index<'a, R> {
    sections: Sections<'a>,
    simd_level: SimdLevel,
    representation: PhantomData<R>,
}

impl<R> Clone for Index<'_, R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R> Copy for Index<'_, R> {}

impl<R: Representation> core::fmt::Debug for Index<'_, R> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct(R::NAME).field("bytes", &self.as_bytes().len()).finish_non_exhaustive()
    }
}

impl<'a, R: Representation> Index<'a, R> {
    /// Bounds the scratch bytes that a build for `triangle_count` triangles needs. The bound is proven. In a constant,
    /// call [`IndexKind::scratch_capacity`](crate::IndexKind::scratch_capacity).
    pub fn scratch_capacity(triangle_count: usize, options: &Options) -> usize {
        scratch_with::<R>(triangle_count, R::Structure::scratch_bytes(triangle_count, options))
    }

    /// Measures the memory and the work of a build, by a dry run in `scratch_capacity` bytes of scratch.
    ///
    /// Cost: that of the build.
    ///
    /// # Errors
    /// The errors of [`Index::build`] but [`BuildError::ArenaFull`].
    pub fn capacity(
        scene: &Scene<'_>,
        options: &Options,
        scratch: &mut [u8],
    ) -> Result<Capacity, BuildError> {
        Self::capacity_with(scene, options, scratch, &Sequential)
    }

    /// Measures the memory and the work of a build, as [`Index::capacity`] does, with the help of an executor.
    ///
    /// # Errors
    /// The errors of [`Index::capacity`].
    pub fn capacity_with(
        scene: &Scene<'_>,
        options: &Options,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<Capacity, BuildError> {
        let mut steps = 0;
        let built =
            Index::<R>::build_counted(scene, options, &mut [], scratch, executor, &mut steps);
        let index = match built {
            Err(BuildError::ArenaFull { needed, .. }) => needed,
            Err(error) => return Err(error),
            // Never: no index fits into no bytes, since each has a header.
            Ok(index) => index.as_bytes().len(),
        };
        let scratch = Self::scratch_capacity(scene.triangles.len(), options);
        Ok(Capacity { index, scratch, steps })
    }

    /// Builds an index of `scene` in the first bytes of `arena`.
    ///
    /// Both slices start at a multiple of [`ALIGNMENT`](crate::custom::ALIGNMENT) bytes; see [`crate::Block`]. The
    /// bytes written depend on the scene and the options only. Cost: at most a multiple of `n log n` for `n` triangles.
    ///
    /// The index has its own copy of the triangles, unless the scene says that it lies [beside](Scene::beside) them. It
    /// nevertheless borrows `scene`. To drop the triangles, drop the index and reopen the arena with
    /// [`Index::from_bytes`].
    ///
    /// # Errors
    /// Any of [`BuildError`]. [`BuildError::ArenaFull`] says how many bytes are enough. After an error, the contents of
    /// the arena are undefined.
    pub fn build(
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &mut [u8],
    ) -> Result<Self, BuildError> {
        Self::build_with(scene, options, arena, scratch, &Sequential)
    }

    /// Builds an index, as [`Index::build`] does and with the same bytes, with the help of an executor.
    ///
    /// The wide, compact and lean BVH partition their triangles in branches that may run in parallel, and so does the
    /// search for clusters with their boxes. All other indices are built sequentially.
    ///
    /// # Errors
    /// The errors of [`Index::build`].
    pub fn build_with(
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<Self, BuildError> {
        Self::build_counted(scene, options, arena, scratch, executor, &mut 0)
    }

    /// Builds an index as [`Index::build_with`] does, and writes the number of steps to `steps`, also if the
    /// structure's build fails.
    pub(crate) fn build_counted(
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &mut [u8],
        executor: &impl Executor,
        steps: &mut u64,
    ) -> Result<Self, BuildError> {
        if scene.beside && R::Structure::HOLDS_TRIANGLES {
            return Err(BuildError::HoldsTriangles { kind: R::NAME });
        }
        scene.check()?;
        options.check()?;
        let options = &Options { cost: options.cost.or(Some(R::Structure::COST)), ..*options };
        let triangles = scene.triangles;
        let scratch_needed = Self::scratch_capacity(triangles.len(), options);
        let scratch_full = BuildError::ScratchFull { needed: scratch_needed, given: scratch.len() };
        if scratch.len() < scratch_needed {
            return Err(scratch_full);
        }
        if Arena::new(arena).is_none() {
            return Err(BuildError::Misaligned);
        }
        let scratch = Arena::new(scratch).ok_or(BuildError::Misaligned)?;

        // 1. Partition the triangles into clusters.
        let (clusters, scratch) = if R::CLUSTERED {
            cluster::detect(scene, options, &mut [], scratch, executor).ok_or(scratch_full)?
        } else {
            cluster::whole(scene, scratch).ok_or(scratch_full)?
        };

        // 2. Lay out the sections whose lengths are known. In an arena that is too small for them, only count.
        let given = arena.len();
        let kind = if scene.beside { R::FORMAT | MESH_BESIDE } else { R::FORMAT };
        let layout = Layout::new(kind, triangles.len(), clusters.count());
        let (fixed, word_bytes) = match arena.split_at_mut_checked(layout.words) {
            Some((fixed, rest)) => (Some(fixed), rest),
            None => (None, Default::default()),
        };
        let fixed = fixed.map(|bytes| layout.split(bytes));
        let (header, own_triangles, own_nodes) = fixed.unwrap_or_default();

        // 3. Join the clusters into the cluster tree, in its section of the arena. If the build only counts, a
        // structure that reads the tree gets one in the scratch, and any other structure gets none.
        let mut scratch = Arena::new(scratch).ok_or(scratch_full)?;
        let nodes = if own_nodes.is_empty() && R::Structure::READS_TREE {
            scratch.take::<ClusterNode>(clusters.node_count()).ok_or(scratch_full)?
        } else {
            own_nodes
        };
        let scratch = scratch.into_rest();
        if !nodes.is_empty() {
            cluster::make_tree(triangles, &clusters, nodes, scratch).ok_or(scratch_full)?;
        }

        // 4. Build the structure.
        let slots = whole_words(word_bytes);
        let mut words = Words::limited(slots, options.work_limit.unwrap_or(u64::MAX));
        let division = DividedScene { triangles, rays: scene.rays, clusters: &clusters, nodes };
        let built = R::Structure::build(division, options, &mut words, scratch, executor);
        *steps = words.steps();
        built?;
        if words.len() > u32::MAX as usize {
            return Err(BuildError::TooLarge);
        }
        let needed = layout.total(words.len());
        if given < needed {
            return Err(BuildError::ArenaFull { needed, given });
        }

        // 5. Copy the triangles, and write the header last.
        for (to, from) in own_triangles.iter_mut().zip(triangles.iter()) {
            *to = from;
        }
        let (triangle_count, word_count) = (triangles.len() as u32, words.len() as u32);
        let fingerprint = scene.kept().map_or(0, |mesh| mesh.fingerprint());
        let cluster_count = clusters.count() as u32;
        encode_header(header, kind, triangle_count, cluster_count, word_count, fingerprint);
        let sections = Sections::view(arena, scene.kept())
            .map_err(|_| BuildError::ArenaFull { needed, given })?;
        Ok(Self::of_checked(sections))
    }

    /// Opens the bytes of an index in place; they come from [`Index::as_bytes`].
    ///
    /// Everything on which traversals rely is checked. So for any bytes, this function and all queries end without a
    /// panic. Forged but well-formed bytes can give wrong answers. Cost: linear in the length.
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, OpenError> {
        Self::read(bytes, None).map(|(index, _)| index)
    }

    /// Opens the bytes of an index that was built [beside](Scene::beside) a mesh; see [`Index::from_bytes`]. Takes the
    /// same triangles, as a list or as an indexed mesh.
    ///
    /// Cost: linear in the lengths of both. Nine 64-bit multiplications a triangle compute the fingerprint that tells
    /// meshes apart.
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn from_bytes_beside(bytes: &'a [u8], mesh: Mesh<'a>) -> Result<Self, OpenError> {
        Self::read(bytes, Some(mesh)).map(|(index, _)| index)
    }

    /// Opens the bytes of an index, and returns what the validation counted.
    pub(super) fn read(
        bytes: &'a [u8],
        mesh: Option<Mesh<'a>>,
    ) -> Result<(Self, Statistics), OpenError> {
        let sections = Sections::parse(bytes, mesh)?;
        let found = sections.kind() & !MESH_BESIDE;
        if found != R::FORMAT {
            return Err(OpenError::OtherKind { expected: R::FORMAT, found });
        }
        let index = Self::of_checked(sections);
        let statistics = index.check()?;
        Ok((index, statistics))
    }

    /// Wraps sections whose words are known to hold such an index, or are about to be checked.
    pub(crate) fn of_checked(sections: Sections<'a>) -> Self {
        Self { sections, simd_level: SimdLevel::detect(), representation: PhantomData }
    }

    /// Checks the invariants of the whole structure, and returns what it consists of. Cost: linear.
    ///
    /// # Errors
    /// [`OpenError::Malformed`]; never for an index that [`Index::build`] or [`Index::from_bytes`] returned.
    pub fn check(&self) -> Result<Statistics, OpenError> {
        R::Structure::check(&self.sections)
            .map_err(|cluster| OpenError::Malformed { part: R::NAME, at: cluster })
    }

    /// Restricts the index to these vector instructions. As built or opened, it uses the best that the processor has.
    /// The answers are the same.
    #[must_use]
    pub fn with_simd_level(self, simd_level: SimdLevel) -> Self {
        Self { simd_level, ..self }
    }

    /// The sections of the index: triangles, cluster tree and words.
    pub fn sections(&self) -> &Sections<'a> {
        &self.sections
    }

    /// The tree that joins the clusters.
    pub fn cluster_tree(&self) -> ClusterTree<'a> {
        self.sections.cluster_tree()
    }

    /// The number of clusters; 1 for a representation without clusters, 0 for an empty scene.
    pub fn cluster_count(&self) -> u32 {
        self.sections.cluster_count()
    }
}

/// The whole words that lie in bytes.
fn whole_words(bytes: &mut [u8]) -> &mut [u32] {
    let length = bytes.len() / size_of::<u32>() * size_of::<u32>();
    let bytes = bytes.get_mut(..length).unwrap_or_default();
    bytemuck::try_cast_slice_mut(bytes).unwrap_or_default()
}
