//! Builds an index of any kind in memory of exactly the size it asks for.

use arboleda::{
    AnyIndex, Block, BuildError, Executor, IndexKind, Mesh, Options, Scene, Sequential,
};

/// An index that owns its bytes.
pub struct Built {
    kind: IndexKind,
    blocks: Vec<Block>,
    length: usize,
}

impl Built {
    /// Builds in an arena of `capacity` bytes and a scratch of `scratch_capacity` bytes.
    ///
    /// # Errors
    /// As the core's `build`.
    pub fn new(kind: IndexKind, scene: &Scene<'_>, options: &Options) -> Result<Self, BuildError> {
        Self::with(kind, scene, options, &Sequential)
    }

    /// As `new`, with the help of an executor.
    ///
    /// # Errors
    /// As the core's `build`.
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

    /// Copies bytes to where index bytes may start.
    pub fn copied(kind: IndexKind, bytes: &[u8]) -> Self {
        let mut blocks = vec![Block::ZERO; Block::count(bytes.len())];
        Block::bytes(&mut blocks)[..bytes.len()].copy_from_slice(bytes);
        Self { kind, blocks, length: bytes.len() }
    }

    /// The bytes of the index.
    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.blocks)[..self.length]
    }

    /// The bytes of the index, to be damaged.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut Block::bytes(&mut self.blocks)[..self.length]
    }

    /// The kind it was built as.
    pub fn kind(&self) -> IndexKind {
        self.kind
    }

    /// The index, read back from its bytes.
    ///
    /// # Panics
    /// If the bytes are refused.
    pub fn index(&self) -> AnyIndex<'_> {
        match self.kind.from_bytes(self.bytes()) {
            Ok(index) => index,
            Err(error) => panic!("{} is refused: {error}", self.kind.name()),
        }
    }

    /// As `index`, of one built beside a mesh.
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

/// Builds in memory that held other things before, exactly large enough, and one byte too small.
///
/// Checks that the needed sizes are exact and reported, that the bytes are the same whatever the
/// memory held, and that the invariants hold.
///
/// # Errors
/// As the core's `build`.
///
/// # Panics
/// Where one of these promises is broken.
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

    // 1. One byte less of either is refused, and what is asked for is what is needed.
    let given = arena_length - 1;
    let refusal = kind.build(scene, options, &mut arena[..given], scratch).err();
    let expected = BuildError::ArenaFull { needed: arena_length, given };
    assert_eq!(refusal, Some(expected), "{name}");
    if let Some(given) = scratch_length.checked_sub(1) {
        let refusal = kind.build(scene, options, arena, &mut scratch[..given]).err();
        let expected = BuildError::ScratchFull { needed: scratch_length, given };
        assert_eq!(refusal, Some(expected), "{name}");
    }

    // 2. The same bytes, whatever was in the memory before.
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
