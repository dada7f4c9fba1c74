//! The seam between those who ask and those who know.
//!
//! [`RayIndex`] is what callers see, [`LocalIndex`](crate::custom::LocalIndex) what an author of an index writes,
//! and [`Index`] joins the two: one local index over everything, or one for each cluster below a
//! cluster tree, in one arena. An index that does not keep clusters apart writes a [`Structure`].

mod capacity;
mod description;
mod kind;
#[cfg(feature = "alloc")]
mod owned;
mod ray_index;
mod registry;
pub mod select;
mod stored;

use core::marker::PhantomData;

pub use capacity::Capacity;
pub(crate) use capacity::scratch_with;
#[cfg(feature = "alloc")]
pub use owned::OwnedIndex;
pub use ray_index::RayIndex;
pub use registry::{AnyIndex, IndexKind};
pub use stored::{Storage, Stored};

use crate::cluster::{self, ClusterNode, NodeId};
use crate::error::{BuildError, OpenError};
use crate::geometry::Ray;
use crate::input::{Executor, Mesh, Options, Scene, Sequential, SimdLevel};
use crate::memory::{Arena, Words};
use crate::query::{All, AllHits, Closest, Count, Counters, Hit, Occluded, Query};
use crate::structure::sections::{Layout, MESH_BESIDE, Sections, encode_header};
use crate::structure::{Described, DividedScene, Representation, Statistics, Structure};

/// An index in an arena.
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

impl<'a, R: Representation> Index<'a, R> {
    /// Bounds the scratch bytes for `triangle_count` triangles, as proven. In constants, call
    /// [`IndexKind::scratch_capacity`](crate::IndexKind::scratch_capacity).
    pub fn scratch_capacity(triangle_count: usize, options: &Options) -> usize {
        scratch_with::<R>(triangle_count, R::Structure::scratch_bytes(triangle_count, options))
    }

    /// The bytes that [`Index::build`] needs: a dry run, in `scratch_capacity` bytes of scratch.
    ///
    /// Cost: as the build.
    ///
    /// # Errors
    /// As [`Index::build`], but never [`BuildError::ArenaFull`].
    pub fn capacity(
        scene: &Scene<'_>,
        options: &Options,
        scratch: &mut [u8],
    ) -> Result<Capacity, BuildError> {
        Self::capacity_with(scene, options, scratch, &Sequential)
    }

    /// As [`Index::capacity`], with the help of an executor.
    ///
    /// # Errors
    /// As there.
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
    /// Both slices start at a multiple of [`ALIGNMENT`](crate::custom::ALIGNMENT); see [`crate::Block`].
    /// The bytes written depend on the scene and the options only.
    ///
    /// The index has its own copy of the triangles, unless the scene says that it lies
    /// [beside](Scene::beside) them. To let go of triangles that were copied, let go of the index too, and
    /// read its bytes with [`Index::from_bytes`].
    ///
    /// # Errors
    /// Any of [`BuildError`]; [`BuildError::ArenaFull`] says how much would have been enough. The
    /// arena's contents are then undefined.
    pub fn build(
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &mut [u8],
    ) -> Result<Self, BuildError> {
        Self::build_with(scene, options, arena, scratch, &Sequential)
    }

    /// As [`Index::build`], with the help of an executor; the same bytes.
    ///
    /// The wide BVH divides its triangles in branches that may run at once; clusters, and the other
    /// indices, are built one after the other.
    ///
    /// # Errors
    /// As there.
    pub fn build_with(
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<Self, BuildError> {
        Self::build_counted(scene, options, arena, scratch, executor, &mut 0)
    }

    /// Builds as [`Index::build_with`] does, and writes to `steps` the steps taken, also where the structure's build
    /// fails.
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

        // 1. Divide the triangles into clusters.
        let (clusters, scratch) = if R::CLUSTERED {
            cluster::detect(scene, options, &mut [], scratch).ok_or(scratch_full)?
        } else {
            cluster::whole(scene, scratch).ok_or(scratch_full)?
        };

        // 2. Lay out what is known already. In an arena too small for it, only count.
        let given = arena.len();
        let kind = if scene.beside { R::FORMAT | MESH_BESIDE } else { R::FORMAT };
        let layout = Layout::new(kind, triangles.len(), clusters.count());
        let (fixed, word_bytes) = match arena.split_at_mut_checked(layout.words) {
            Some((fixed, rest)) => (Some(fixed), rest),
            None => (None, Default::default()),
        };
        let fixed = fixed.map(|bytes| layout.split(bytes));
        let (header, own_triangles, own_nodes) = fixed.unwrap_or_default();

        // 3. Join the clusters into the cluster tree, in its place in the arena. If only counting, a structure that
        // reads the tree gets one in the scratch, and others get none.
        let node_count = (2 * clusters.count()).saturating_sub(1);
        let mut scratch = Arena::new(scratch).ok_or(scratch_full)?;
        let nodes = if own_nodes.is_empty() && R::Structure::READS_TREE {
            scratch.take::<ClusterNode>(node_count).ok_or(scratch_full)?
        } else {
            own_nodes
        };
        let scratch = scratch.into_rest();
        if !nodes.is_empty() {
            for (leaf, ids) in nodes.iter_mut().zip(clusters.iter()) {
                let bounds = cluster::bounds_of(triangles, ids);
                *leaf = ClusterNode { bounds, links: [0; 2], parent: NodeId::NONE };
            }
            cluster::join(nodes, clusters.count(), scratch).ok_or(scratch_full)?;
        }

        // 4. The structure over them.
        let whole_words = word_bytes.len() / size_of::<u32>() * size_of::<u32>();
        let word_bytes = word_bytes.get_mut(..whole_words).unwrap_or_default();
        let slots = bytemuck::try_cast_slice_mut(word_bytes).unwrap_or_default();
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

        // 5. The triangles, and the header last.
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

    /// Takes over bytes that [`RayIndex::as_bytes`] gave, in place.
    ///
    /// Checks everything on which the walks rely, so it never panics and a query never runs for
    /// ever, for any input. Bytes made up by someone can still give wrong answers.
    /// Cost: linear in the length.
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, OpenError> {
        Self::read(bytes, None)
    }

    /// As [`Index::from_bytes`], for an index that was built [beside](Scene::beside) a mesh: takes the same
    /// triangles, however they are kept now.
    ///
    /// Cost: linear in the lengths of both; nine multiplications of 64 bits a triangle are for telling meshes
    /// apart.
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn from_bytes_beside(bytes: &'a [u8], mesh: Mesh<'a>) -> Result<Self, OpenError> {
        Self::read(bytes, Some(mesh))
    }

    pub(super) fn read(bytes: &'a [u8], mesh: Option<Mesh<'a>>) -> Result<Self, OpenError> {
        let sections = Sections::parse(bytes, mesh)?;
        let found = sections.kind() & !MESH_BESIDE;
        if found != R::FORMAT {
            return Err(OpenError::OtherKind { expected: R::FORMAT, found });
        }
        let index = Self::of_checked(sections);
        index.check()?;
        Ok(index)
    }

    /// Wraps an image whose words are known to hold such an index, or are about to be checked.
    pub(crate) fn of_checked(sections: Sections<'a>) -> Self {
        Self { sections, simd_level: SimdLevel::detect(), representation: PhantomData }
    }

    /// Walks the whole structure, checks its invariants, and says what it consists of.
    ///
    /// # Errors
    /// [`OpenError::Malformed`]; never for an index that `build` returned.
    pub fn check(&self) -> Result<Statistics, OpenError> {
        R::Structure::check(&self.sections)
            .map_err(|cluster| OpenError::Malformed { part: R::NAME, at: cluster })
    }

    /// The same index, restricted to these vector instructions; as built or read, it uses the best that
    /// the processor has. The answers are the same.
    #[must_use]
    pub fn with_simd_level(self, simd_level: SimdLevel) -> Self {
        Self { simd_level, ..self }
    }

    /// The parts that the index consists of.
    pub fn sections(&self) -> &Sections<'a> {
        &self.sections
    }

    /// How many clusters there are; 1 for a simple representation, 0 for an empty scene.
    pub fn cluster_count(&self) -> u32 {
        self.sections.cluster_count()
    }

    fn run<Q: Query>(&self, query: &mut Q) {
        R::Structure::traverse(&self.sections, self.simd_level, query);
    }

    fn closest<C: Count>(&self, ray: &Ray, count: C) -> Option<Hit> {
        let mut query = Closest::new(ray, count);
        self.run(&mut query);
        query.finish()
    }

    fn any<C: Count>(&self, ray: &Ray, count: C) -> bool {
        let mut query = Occluded::new(ray, count);
        self.run(&mut query);
        query.found
    }
}

/// Queries.
impl<'a, R: Representation> Index<'a, R> {
    /// The index itself: what to write to a file and read back with [`Index::from_bytes`].
    pub fn as_bytes(&self) -> &'a [u8] {
        self.sections.bytes()
    }

    /// The closest hit; of several at the same `t`, the one with the lowest id.
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.closest(ray, ())
    }

    /// Whether anything is hit between `t_min` and `t_max`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.any(ray, ())
    }

    /// The closest hit of each ray, or [`Hit::NONE`]: the same bits as one by one, and the faster way to ask
    /// about many. Rays and hits beyond the shorter of both slices are left alone. Where there are
    /// vector registers, the wide, compact and lean BVHs walk four rays in turn, whose state takes some 13 KiB of
    /// the stack; elsewhere see [`IndexKind`](crate::IndexKind#stack).
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        let start = |index: usize| rays.get(index).map(|ray| Closest::new(ray, ()));
        let count = rays.len().min(hits.len());
        R::Structure::traverse_each(
            &self.sections,
            self.simd_level,
            count,
            start,
            |index, query| {
                if let Some(hit) = hits.get_mut(index) {
                    *hit = query.finish().unwrap_or(Hit::NONE);
                }
            },
        );
    }

    /// As [`Index::occluded`], for each ray; see [`Index::closest_hits`].
    pub fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        let start = |index: usize| rays.get(index).map(|ray| Occluded::new(ray, ()));
        let count = rays.len().min(occluded.len());
        R::Structure::traverse_each(
            &self.sections,
            self.simd_level,
            count,
            start,
            |index, query| {
                if let Some(occluded) = occluded.get_mut(index) {
                    *occluded = query.found;
                }
            },
        );
    }

    /// Every hit by `(t, id)`, as far as `buffer` holds them: if they are more, the closest.
    pub fn all_hits<'h>(&self, ray: &Ray, buffer: &'h mut [Hit]) -> AllHits<'h> {
        let mut query = All::new(ray, buffer, ());
        self.run(&mut query);
        query.finish()
    }

    /// As [`Index::closest_hit`], and adds to the counters.
    pub fn closest_hit_counted(&self, ray: &Ray, counters: &mut Counters) -> Option<Hit> {
        self.closest(ray, counters)
    }

    /// As [`Index::occluded`], and adds to the counters.
    pub fn occluded_counted(&self, ray: &Ray, counters: &mut Counters) -> bool {
        self.any(ray, counters)
    }
}
