//! Build of a hierarchy in pieces, for an index that is larger than the memory.

use super::whole_words;
use crate::cluster::{self, ClusterNode, Clusters};
use crate::error::BuildError;
use crate::input::{Options, Scene};
use crate::memory::{ALIGNMENT, Arena, Words, size_of_slice};
use crate::structure::sections::{HEADER_BYTES, Layout, MESH_BESIDE, encode_header};
use crate::structure::{ClusterBuild, Described, Group, Representation, Structure};

/// Run of the bytes of an index, and where it belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece<'w> {
    /// The offset of the first byte in the index. It is a multiple of 4.
    pub offset: usize,
    /// The bytes.
    pub bytes: &'w [u8],
}

/// Build of a hierarchy in pieces: one local index after the other, each in the same memory. For those whose storage
/// holds the index and whose memory does not: a scene larger than the RAM, firmware that writes flash page by page.
///
/// ```text
/// bytes:  | header | triangles | cluster tree | words of cluster 0 | of cluster 1 | ...
/// order:      4          any          3                 1                 2
/// ```
/// The bytes are those of [`Index::build`](crate::Index::build), where [`Options::work_limit`] is `None`: an automatic
/// grid is planned for the steps that are left, which are others in another order. The caller writes each [`Piece`]
/// where it belongs:
///
/// 1. The triangles, as they lie in memory, from [`triangles_offset`](Self::triangles_offset) on; none if the scene
///    lies [beside](Scene::beside) them. Their bytes are those of a slice of [`Triangle`](crate::Triangle).
/// 2. What [`build_next`](Self::build_next) returns, until it returns `None`.
/// 3. What [`finish`](Self::finish) returns: the cluster tree, and the header last. Bytes that no piece has are zero.
///
/// The clusters are those of [`clusters::find`](crate::clusters::find), whose scratch is the most memory that a build
/// takes. If it does not fit, it may lie in a mapped file.
///
/// Only a hierarchy of local indices can be built in pieces. `wide-bvh`, `compact-bvh` and `lean-bvh` make one tree over
/// all clusters.
///
/// # Examples
/// ```
/// use arboleda::kinds::{Clustered, Octree};
/// use arboleda::{AnyIndex, Block, Options, PiecewiseBuild, Scene, Triangle, Vec3, clusters};
///
/// let near = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
/// let far = Vec3::splat(50.0);
/// let triangles = [near, Triangle::new(far, far + Vec3::X, far + Vec3::Y)];
/// let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
/// let mut scratch = [Block::ZERO; Block::count(clusters::scratch_capacity(2))];
/// let found = clusters::find(&scene, &options, Block::bytes(&mut scratch))?;
///
/// let needed = PiecewiseBuild::memory_bytes::<Clustered<Octree>>(&found, &options);
/// let (mut memory, mut room) = (vec![Block::ZERO; Block::count(needed)], [Block::ZERO; 2]);
/// let memory = Block::bytes(&mut memory);
/// let mut build = PiecewiseBuild::new::<Clustered<Octree>>(&scene, &options, &found, memory)?;
///
/// // The storage: a file, or flash.
/// let mut storage = vec![Block::ZERO; 8];
/// let storage = Block::bytes(&mut storage);
/// let mut write = |offset: usize, bytes: &[u8]| storage[offset..][..bytes.len()].copy_from_slice(bytes);
/// write(build.triangles_offset(), bytemuck::cast_slice(&triangles));
/// while let Some(piece) = build.build_next(Block::bytes(&mut room))? {
///     write(piece.offset, piece.bytes);
/// }
/// for piece in build.finish()? {
///     write(piece.offset, piece.bytes);
/// }
/// assert_eq!(AnyIndex::from_bytes(storage)?.cluster_tree().cluster_count(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PiecewiseBuild<'a, 's> {
    scene: Scene<'a>,
    options: Options,
    clusters: &'s Clusters<'s>,
    build: ClusterBuild,
    /// The format of the index, with the bit of a mesh beside it.
    format: u32,
    layout: Layout,
    header: &'s mut [u8],
    nodes: &'s mut [ClusterNode],
    scratch: &'s mut [u8],
    /// The number of clusters whose words are built.
    built: usize,
    /// The number of words of these.
    word_count: usize,
    /// The steps that they took.
    steps: u64,
}

impl<'a, 's> PiecewiseBuild<'a, 's> {
    /// The bytes of memory that a build over these clusters needs, beside the clusters and the room for a piece. It is
    /// that of the cluster tree, and of the scratch for the largest cluster.
    pub fn memory_bytes<R: Representation>(clusters: &Clusters<'_>, options: &Options) -> usize {
        let largest = clusters.iter().map(<[u32]>::len).max().unwrap_or(0);
        let (join, build) =
            (cluster::join_bytes(clusters.count()), R::Structure::scratch_bytes(largest, options));
        size_of_slice::<u8>(HEADER_BYTES)
            .saturating_add(size_of_slice::<ClusterNode>(clusters.node_count()))
            .saturating_add(join.max(build))
    }

    /// Begins a build: checks the scene, and joins the clusters into the cluster tree.
    ///
    /// The clusters must be those of this scene: others of as many triangles are not noticed, and make an index that is
    /// right but slow.
    ///
    /// `memory` begins at a multiple of [`ALIGNMENT`](crate::custom::ALIGNMENT) bytes. Cost: linear in the triangles,
    /// near-linear in the clusters.
    ///
    /// # Errors
    /// [`BuildError::NotInPieces`] for a kind that is one index over all triangles, [`BuildError::OtherClusters`] if the
    /// clusters are of another number of triangles, [`BuildError::ScratchFull`] below
    /// [`memory_bytes`](Self::memory_bytes), [`BuildError::Misaligned`], and the errors of the scene and the options.
    pub fn new<R: Representation>(
        scene: &Scene<'a>,
        options: &Options,
        clusters: &'s Clusters<'s>,
        memory: &'s mut [u8],
    ) -> Result<Self, BuildError> {
        let Some(build) = R::Structure::BUILD_CLUSTER.filter(|_| R::CLUSTERED) else {
            return Err(BuildError::NotInPieces { kind: R::NAME });
        };
        scene.check()?;
        options.check()?;
        let (triangles, clustered) = (scene.triangles.len(), clusters.triangle_count());
        if triangles != clustered {
            return Err(BuildError::OtherClusters { triangles, clustered });
        }
        let options = Options { cost: options.cost.or(Some(R::Structure::COST)), ..*options };
        let (needed, given) = (Self::memory_bytes::<R>(clusters, &options), memory.len());
        let full = BuildError::ScratchFull { needed, given };
        if given < needed {
            return Err(full);
        }
        let mut arena = Arena::new(memory).ok_or(BuildError::Misaligned)?;
        let header = arena.take::<u8>(HEADER_BYTES).ok_or(full)?;
        let nodes = arena.take::<ClusterNode>(clusters.node_count()).ok_or(full)?;
        let scratch = arena.into_rest();
        cluster::make_tree(scene.triangles, clusters, nodes, scratch).ok_or(full)?;
        let format = if scene.beside { R::FORMAT | MESH_BESIDE } else { R::FORMAT };
        Ok(Self {
            scene: *scene,
            options,
            clusters,
            build,
            format,
            layout: Layout::new(format, triangles, clusters.count()),
            header,
            nodes,
            scratch,
            built: 0,
            word_count: 0,
            steps: 0,
        })
    }

    /// The offset of the triangles in the index.
    pub fn triangles_offset(&self) -> usize {
        self.layout.triangles
    }

    /// The bytes of the index up to the words that are built: its length once all are.
    pub fn length(&self) -> usize {
        self.layout.total(self.word_count)
    }

    /// The number of clusters, and that of those whose words are built.
    pub fn progress(&self) -> (usize, usize) {
        (self.clusters.count(), self.built)
    }

    /// The number of steps so far; see [`Capacity::steps`](crate::Capacity::steps).
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Builds the words of the next cluster in the first bytes of `room`, and returns them; `None` if all are built.
    /// `room` begins at a multiple of [`ALIGNMENT`](crate::custom::ALIGNMENT) bytes. Each piece follows the one before.
    ///
    /// # Errors
    /// [`BuildError::ArenaFull`], which says how many bytes of room are enough: the next call builds the same cluster.
    /// [`BuildError::TooLarge`] beyond 2^32 words in all, and the errors of the kind.
    pub fn build_next<'w>(&mut self, room: &'w mut [u8]) -> Result<Option<Piece<'w>>, BuildError> {
        if self.built >= self.clusters.count() {
            return Ok(None);
        }
        let Some(leaf) = self.nodes.get_mut(self.built) else { return Ok(None) };
        if Arena::new(&mut *room).is_none() {
            return Err(BuildError::Misaligned);
        }
        // 1. Build as if there were no other cluster: links are relative.
        let limit = self.options.work_limit.unwrap_or(u64::MAX);
        let given = room.len();
        let mut words = Words::limited(whole_words(&mut *room), limit.saturating_sub(self.steps));
        let Scene { triangles, rays, .. } = self.scene;
        let ids = self.clusters.get(self.built);
        let group = Group { triangles, rays, ids, bounds: leaf.bounds };
        (self.build)(&group, &self.options, &mut words, self.scratch).map_err(
            |error| match error {
                BuildError::TooMuchWork { .. } => BuildError::TooMuchWork { limit },
                error => error,
            },
        )?;
        let (count, steps) = (words.len(), words.steps());
        let needed = count.saturating_mul(size_of::<u32>());
        let bytes = room.get(..needed).ok_or(BuildError::ArenaFull { needed, given })?;
        // 2. Put them behind the others.
        let end = self.word_count.saturating_add(count);
        if end > u32::MAX as usize {
            return Err(BuildError::TooLarge);
        }
        leaf.links = [self.word_count as u32, count as u32];
        let offset = self.layout.total(self.word_count);
        self.word_count = end;
        self.steps = self.steps.saturating_add(steps);
        self.built += 1;
        Ok(Some(Piece { offset, bytes }))
    }

    /// Returns the cluster tree and the header, which are written in this order. Beside a mesh, its fingerprint is
    /// computed.
    ///
    /// # Errors
    /// [`BuildError::PiecesLeft`] if the words of some clusters are not built.
    pub fn finish(self) -> Result<[Piece<'s>; 2], BuildError> {
        let left = self.clusters.count().saturating_sub(self.built);
        if left > 0 {
            return Err(BuildError::PiecesLeft { left });
        }
        let fingerprint = self.scene.kept().map_or(0, |mesh| mesh.fingerprint());
        encode_header(
            self.header,
            self.format,
            self.scene.triangles.len() as u32,
            self.clusters.count() as u32,
            self.word_count as u32,
            fingerprint,
        );
        Ok([
            Piece { offset: self.layout.nodes, bytes: bytemuck::cast_slice(self.nodes) },
            Piece { offset: 0, bytes: self.header },
        ])
    }
}

impl core::fmt::Debug for PiecewiseBuild<'_, '_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("PiecewiseBuild")
            .field("clusters", &self.clusters.count())
            .field("built", &self.built)
            .finish_non_exhaustive()
    }
}

/// Tells whether an index can be built in pieces.
pub(in crate::index) const fn is_in_pieces<R: Representation>() -> bool {
    R::CLUSTERED && R::Structure::BUILD_CLUSTER.is_some()
}

// The header fills its section.
const _: () = assert!(HEADER_BYTES == ALIGNMENT);
