//! An index with its arena on the heap, sized by a dry run.

use std::time::Instant;

use arboleda::{AnyIndex, Block, BuildError, IndexKind, Options, Scene};

/// An index of any kind that owns its memory.
pub struct OwnedIndex {
    kind: IndexKind,
    blocks: Vec<Block>,
    bytes: usize,
    build_seconds: f64,
    scratch_bytes: usize,
}

impl OwnedIndex {
    /// Finds out how much memory is needed, allocates that much, and builds.
    ///
    /// # Errors
    /// As [`arboleda::Index::build`], without those about space.
    pub fn build(
        kind: IndexKind,
        scene: &Scene<'_>,
        options: &Options,
    ) -> Result<Self, BuildError> {
        let scratch_bytes = kind.scratch_capacity(scene.triangles().len(), options);
        let mut scratch = vec![Block::ZERO; Block::count(scratch_bytes)];
        let scratch = Block::bytes(&mut scratch);
        let bytes = kind.capacity(scene, options, scratch)?.index;
        let mut blocks = vec![Block::ZERO; Block::count(bytes)];
        let start = Instant::now();
        kind.build(scene, options, Block::bytes(&mut blocks), scratch)?;
        let build_seconds = start.elapsed().as_secs_f64();
        Ok(Self { kind, blocks, bytes, build_seconds, scratch_bytes })
    }

    /// The index, read from its bytes as it would be from a file. Cost: linear, for the validation.
    ///
    /// # Panics
    /// Never: the bytes are those that `build` wrote.
    pub fn index(&self) -> AnyIndex<'_> {
        let bytes = &bytemuck::cast_slice(&self.blocks)[..self.bytes];
        self.kind.from_bytes(bytes).expect("a built index is valid")
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
