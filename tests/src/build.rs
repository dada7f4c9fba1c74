//! Builds of indices of any kind, in memory of exactly the size that they require.

use arboleda::{
    AnyIndex, Block, BuildError, Executor, IndexKind, Mesh, Options, Scene, Sequential,
};

/// Index that owns its bytes.
pub struct Built {
    kind: IndexKind,
    blocks: Vec<Block>,
    length: usize,
}

impl Built {
    /// Builds in an arena of `capacity` bytes and a scratch of `scratch_capacity` bytes.
    ///
    /// # Errors
    /// The errors of the core's `build`.
    pub fn new(kind: IndexKind, scene: &Scene<'_>, options: &Options) -> Result<Self, BuildError> {
        Self::with(kind, scene, options, &Sequential)
    }

    /// Builds as [`Built::new`] does, with an executor.
    ///
    /// # Errors
    /// The errors of the core's `build`.
    pub fn with(
        kind: IndexKind,
        scene: &Scene<'_>,
        options: &Options,
        executor: &impl Executor,
    ) -> Result<Self, BuildError> {
        let scratch_length = kind.scratch_capacity(scene.triangles().len(), options);
        let mut scratch = vec![Block::ZERO; Block::count(scratch_length)];
        let scratch = &mut Block::bytes(&mut scratch)[..scratch_length];
        let length = kind.capacity_with(scene, options, scratch, executor)?.index;
        let mut blocks = vec![Block::ZERO; Block::count(length)];
        let arena = &mut Block::bytes(&mut blocks)[..length];
        kind.build_with(scene, options, arena, scratch, executor)?;
        Ok(Self { kind, blocks, length })
    }

    /// Copies bytes to memory of an index's alignment.
    pub fn copied(kind: IndexKind, bytes: &[u8]) -> Self {
        let mut blocks = vec![Block::ZERO; Block::count(bytes.len())];
        Block::bytes(&mut blocks)[..bytes.len()].copy_from_slice(bytes);
        Self { kind, blocks, length: bytes.len() }
    }

    /// Returns the index bytes.
    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.blocks)[..self.length]
    }

    /// Returns the index bytes for damaging them.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut Block::bytes(&mut self.blocks)[..self.length]
    }

    /// Returns the kind of the index.
    pub fn kind(&self) -> IndexKind {
        self.kind
    }

    /// Opens the index from its bytes.
    ///
    /// # Panics
    /// If the bytes are refused.
    pub fn index(&self) -> AnyIndex<'_> {
        match self.kind.from_bytes(self.bytes()) {
            Ok(index) => index,
            Err(error) => panic!("{} is refused: {error}", self.kind.name()),
        }
    }

    /// Opens the index from its bytes, beside a mesh.
    ///
    /// # Panics
    /// If the bytes are refused.
    pub fn index_beside<'a>(&'a self, mesh: Mesh<'a>) -> AnyIndex<'a> {
        match self.kind.from_bytes_beside(self.bytes(), mesh) {
            Ok(index) => index,
            Err(error) => panic!("{} is refused: {error}", self.kind.name()),
        }
    }
}

/// Builds in memory of exactly the required size, which held other values before, and in one byte less.
///
/// Checks three promises: the required sizes are exact and reported; the bytes do not depend on the memory's contents;
/// the index's invariants hold.
///
/// # Errors
/// The errors of the core's `build`.
///
/// # Panics
/// If a promise is broken.
pub fn build_exactly(
    kind: IndexKind,
    scene: &Scene<'_>,
    options: &Options,
) -> Result<Built, BuildError> {
    let name = kind.name();
    let built = Built::new(kind, scene, options)?;
    let arena_length = built.length;
    let scratch_length = kind.scratch_capacity(scene.triangles().len(), options);
    let mut arena = vec![Block::ZERO; Block::count(arena_length)];
    let mut scratch = vec![Block::ZERO; Block::count(scratch_length)];
    let arena = &mut Block::bytes(&mut arena)[..arena_length];
    let scratch = &mut Block::bytes(&mut scratch)[..scratch_length];

    // 1. One byte less of arena or scratch is refused, and the error names the required size.
    let given = arena_length - 1;
    let refusal = kind.build(scene, options, &mut arena[..given], scratch).err();
    let expected = BuildError::ArenaFull { needed: arena_length, given };
    assert_eq!(refusal, Some(expected), "{name}");
    if let Some(given) = scratch_length.checked_sub(1) {
        let refusal = kind.build(scene, options, arena, &mut scratch[..given]).err();
        let expected = BuildError::ScratchFull { needed: scratch_length, given };
        assert_eq!(refusal, Some(expected), "{name}");
    }

    // 2. The bytes do not depend on the memory's contents before the build.
    for rubbish in [0xa5, 0xff] {
        arena.fill(rubbish);
        scratch.fill(rubbish);
        let index = kind.build(scene, options, arena, scratch)?;
        let bytes = arboleda::RayIndex::as_bytes(&index);
        assert_eq!(bytes.len(), arena_length, "{name} does not use what it asks for");
        assert!(
            bytes == built.bytes(),
            "{name} copies what was in memory, filled with {rubbish:#x}"
        );
        if let Err(error) = index.check() {
            panic!("{name} breaks its own invariants: {error}");
        }
    }
    Ok(built)
}
