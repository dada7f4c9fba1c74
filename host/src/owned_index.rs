//! An index with its arena on the heap, sized by a dry run.

use std::time::Instant;

use arboleda::{
    AnyIndex, Block, BuildError, Executor, IndexKind, Mesh, Options, Scene, Sequential,
};

/// An index of any kind that owns its memory.
pub struct OwnedIndex {
    kind: IndexKind,
    blocks: Vec<Block>,
    bytes: usize,
    build_seconds: f64,
    scratch_bytes: usize,
}

impl OwnedIndex {
    /// Finds out how much memory is needed, allocates that much, and builds, in the caller's thread.
    ///
    /// # Errors
    /// As [`arboleda::Index::build`], without those about space.
    pub fn build(
        kind: IndexKind,
        scene: &Scene<'_>,
        options: &Options,
    ) -> Result<Self, BuildError> {
        Self::build_with(kind, scene, options, &Sequential)
    }

    /// As [`OwnedIndex::build`], with the help of an executor, as [`crate::Threads`]; the same bytes.
    ///
    /// # Errors
    /// As there.
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
        let mut blocks = bytemuck::zeroed_vec(Block::count(bytes));
        let start = Instant::now();
        kind.build_with(scene, options, Block::bytes(&mut blocks), scratch, executor)?;
        let build_seconds = start.elapsed().as_secs_f64();
        Ok(Self { kind, blocks, bytes, build_seconds, scratch_bytes })
    }

    /// The index, read from its bytes as it would be from a file. Cost: linear, for the validation.
    ///
    /// # Panics
    /// Only if it was built beside a mesh: the bytes are those that `build` wrote.
    pub fn index(&self) -> AnyIndex<'_> {
        self.kind.from_bytes(self.as_bytes()).expect("a built index is valid")
    }

    /// As [`OwnedIndex::index`], of one that was built beside a mesh.
    ///
    /// # Panics
    /// If it was built beside another, or has its triangles itself.
    pub fn index_beside<'a>(&'a self, mesh: Mesh<'a>) -> AnyIndex<'a> {
        let index = self.kind.from_bytes_beside(self.as_bytes(), mesh);
        index.expect("a built index is valid beside its mesh")
    }

    /// The bytes of the index.
    pub fn as_bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.blocks)[..self.bytes]
    }

    /// Which kind it is.
    pub fn kind(&self) -> IndexKind {
        self.kind
    }

    /// The length of the index, with all it needs to answer.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// What the build needed beside, for its duration.
    pub fn scratch_bytes(&self) -> usize {
        self.scratch_bytes
    }

    /// How long the build took, without finding out its size.
    pub fn build_seconds(&self) -> f64 {
        self.build_seconds
    }
}

/// Looks an index up by its name on the command line.
pub fn kind_by_name(name: &str) -> Option<IndexKind> {
    IndexKind::ALL.iter().copied().find(|kind| kind.name() == name)
}

/// The names of all indices, the oracle first.
pub fn kind_names() -> impl Iterator<Item = &'static str> {
    IndexKind::ALL.iter().map(|kind| kind.name())
}
