//! Index as `arboleda::OwnedIndex`, with the time and the scratch of its build, for comparisons.

use std::ops::Deref;
use std::time::Instant;

use arboleda::{Block, BuildError, Executor, IndexKind, Options, OwnedIndex, Scene, Sequential};

/// Index of any kind that owns its memory, and the time and scratch of its build.
pub struct TimedIndex {
    index: OwnedIndex,
    build_seconds: f64,
    scratch_bytes: usize,
}

impl Deref for TimedIndex {
    type Target = OwnedIndex;

    fn deref(&self) -> &OwnedIndex {
        &self.index
    }
}

impl TimedIndex {
    /// Computes the capacity, allocates exactly that much, and builds, in the caller's thread.
    ///
    /// # Errors
    /// The errors of [`arboleda::Index::build`] except the ones about space.
    pub fn build(
        kind: IndexKind,
        scene: &Scene<'_>,
        options: &Options,
    ) -> Result<Self, BuildError> {
        Self::build_with(kind, scene, options, &Sequential)
    }

    /// Builds as [`TimedIndex::build`] does, with an executor such as [`crate::Threads`]. The bytes are the same.
    ///
    /// # Errors
    /// The errors of [`TimedIndex::build`].
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
        let start = Instant::now();
        let index = OwnedIndex::build_in(kind, scene, options, blocks, scratch, executor)?;
        let build_seconds = start.elapsed().as_secs_f64();
        Ok(Self { index, build_seconds, scratch_bytes })
    }

    /// Returns the index without its measurements.
    pub fn into_index(self) -> OwnedIndex {
        self.index
    }

    /// Returns the number of index bytes, triangles included if the index holds them.
    pub fn bytes(&self) -> usize {
        self.index.as_bytes().len()
    }

    /// Returns the bytes of scratch memory that the build used.
    pub fn scratch_bytes(&self) -> usize {
        self.scratch_bytes
    }

    /// Returns the seconds of the build, without the dry run that computes the capacity.
    pub fn build_seconds(&self) -> f64 {
        self.build_seconds
    }
}

/// Looks an index up by its name on the command line.
pub fn kind_by_name(name: &str) -> Option<IndexKind> {
    IndexKind::ALL.iter().copied().find(|kind| kind.name() == name)
}

/// Lists the names of all indices, the linear scan first.
pub fn kind_names() -> impl Iterator<Item = &'static str> {
    IndexKind::ALL.iter().map(|kind| kind.name())
}
