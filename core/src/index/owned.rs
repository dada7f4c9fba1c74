//! Index with its arena on the heap, sized by a dry run.

use alloc::vec::Vec;

use super::{AnyIndex, IndexKind};
use crate::error::{BuildError, OpenError};
use crate::input::{Executor, Mesh, Options, Scene, Sequential};
use crate::memory::Block;

/// Index of any kind that owns its memory on the heap.
///
/// # Examples
/// ```
/// use arboleda::{IndexKind, Options, OwnedIndex, Ray, Scene, Triangle, Vec3};
///
/// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
/// let owned = OwnedIndex::build(IndexKind::Bvh, &Scene::new(&triangles), &Options::DEFAULT)?;
/// let hit = owned.index().closest_hit(&Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z)?);
/// assert_eq!(hit.map(|hit| hit.t), Some(1.0));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct OwnedIndex {
    kind: IndexKind,
    blocks: Vec<Block>,
    bytes: usize,
}

impl OwnedIndex {
    /// Builds an index: measures it by a dry run, allocates that much, and builds in it.
    ///
    /// Cost: twice that of [`Index::build`](crate::Index::build), because the dry run takes as long.
    ///
    /// # Errors
    /// The errors of `Index::build` but [`BuildError::ArenaFull`] and [`BuildError::ScratchFull`].
    pub fn build(
        kind: IndexKind,
        scene: &Scene<'_>,
        options: &Options,
    ) -> Result<Self, BuildError> {
        Self::build_with(kind, scene, options, &Sequential)
    }

    /// Builds an index, as [`OwnedIndex::build`] does and with the same bytes, with the help of an executor.
    ///
    /// # Errors
    /// The errors of [`OwnedIndex::build`].
    pub fn build_with(
        kind: IndexKind,
        scene: &Scene<'_>,
        options: &Options,
        executor: &impl Executor,
    ) -> Result<Self, BuildError> {
        let scratch_bytes = kind.scratch_capacity(scene.triangles().len(), options);
        let mut scratch = bytemuck::zeroed_vec(Block::count(scratch_bytes));
        let scratch = Block::bytes(&mut scratch);
        let bytes = kind.capacity_with(scene, options, scratch, executor)?.index;
        let blocks = bytemuck::zeroed_vec(Block::count(bytes));
        Self::build_in(kind, scene, options, blocks, scratch, executor)
    }

    /// Builds an index in memory that was allocated before: blocks that it will own, and scratch that may serve the
    /// next build. [`IndexKind::capacity`] says how much is needed.
    ///
    /// Cost: that of [`Index::build`](crate::Index::build).
    ///
    /// # Errors
    /// The errors of `Index::build`.
    pub fn build_in(
        kind: IndexKind,
        scene: &Scene<'_>,
        options: &Options,
        mut blocks: Vec<Block>,
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<Self, BuildError> {
        let arena = Block::bytes(&mut blocks);
        let bytes = kind.build_with(scene, options, arena, scratch, executor)?.as_bytes().len();
        Ok(Self { kind, blocks, bytes })
    }

    /// Reads an index of any kind from bytes that lie anywhere, as from a file: copies them, and validates them.
    ///
    /// # Errors
    /// Any of [`OpenError`] but `Misaligned`. [`OpenError::MeshMissing`] if the index was built beside a mesh.
    ///
    /// # Examples
    /// ```
    /// use arboleda::{IndexKind, Options, OwnedIndex, Scene, Triangle, Vec3};
    ///
    /// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
    /// let built = OwnedIndex::build(IndexKind::Bvh, &Scene::new(&triangles), &Options::DEFAULT)?;
    /// let read = OwnedIndex::from_bytes(built.as_bytes())?;
    /// assert_eq!((read.kind(), read.as_bytes()), (IndexKind::Bvh, built.as_bytes()));
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, OpenError> {
        let mut blocks: Vec<Block> = bytemuck::zeroed_vec(Block::count(bytes.len()));
        let copy = Block::bytes(&mut blocks).get_mut(..bytes.len()).unwrap_or_default();
        copy.copy_from_slice(bytes);
        let index = AnyIndex::from_bytes(copy)?;
        let (kind, bytes) = (index.kind(), index.as_bytes().len());
        Ok(Self { kind, blocks, bytes })
    }

    /// Opens the index from its bytes. Cost: linear, for the validation; keep the result for all
    /// queries.
    ///
    /// # Panics
    /// If the index was built [beside](Scene::beside) a mesh.
    pub fn index(&self) -> AnyIndex<'_> {
        self.kind.from_bytes(self.as_bytes()).expect("built without a mesh beside it")
    }

    /// Opens an index that was built beside `mesh`; see [`OwnedIndex::index`].
    ///
    /// # Panics
    /// If the index was built beside another mesh, or holds its triangles.
    pub fn index_beside<'a>(&'a self, mesh: Mesh<'a>) -> AnyIndex<'a> {
        let index = self.kind.from_bytes_beside(self.as_bytes(), mesh);
        index.expect("built beside this mesh")
    }

    /// The bytes of the index: what to write to a file.
    pub fn as_bytes(&self) -> &[u8] {
        bytemuck::must_cast_slice(&self.blocks).get(..self.bytes).unwrap_or_default()
    }

    /// The kind of the index.
    pub fn kind(&self) -> IndexKind {
        self.kind
    }
}
