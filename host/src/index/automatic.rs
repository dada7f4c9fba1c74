//! Automatic selection of an index, with memory from the heap.

use arboleda::select::{Selection, USUAL, select};
use arboleda::{Block, BuildError, Options, Scene};

/// Bytes of the arena for each triangle. An index that needs more is left out of the selection: grids and octrees that
/// are worth their memory stay below a quarter of it.
const BYTES_PER_TRIANGLE: usize = 1024;
/// Bytes of the arena beside those for the triangles, because the smallest scenes need more for each triangle.
const LEAST_BYTES: usize = 1 << 20;

/// Chooses among the usual indices, as [`arboleda::select::select`] does.
///
/// # Errors
/// The errors of [`arboleda::select::select`].
pub fn select_index(scene: &Scene<'_>, options: &Options) -> Result<Selection, BuildError> {
    let count = scene.triangles().len();
    let scratch_bytes = USUAL.iter().map(|kind| kind.scratch_capacity(count, options)).max();
    let mut scratch = Untouched::of(scratch_bytes.unwrap_or(0));
    let arena_bytes = LEAST_BYTES + count * BYTES_PER_TRIANGLE;
    let mut arena = Untouched::of(arena_bytes);
    select(scene, options, USUAL, arena.bytes(), scratch.bytes())
}

/// Zeroed memory whose pages become resident only when they are written.
///
/// A vector of `u64` is allocated as zeroed pages. A vector of [`Block`]s, whose alignment is stricter, would be filled
/// by a loop, which makes every page resident.
struct Untouched(Vec<u64>);

impl Untouched {
    fn of(bytes: usize) -> Self {
        Self(vec![0; (Block::count(bytes) + 1) * size_of::<Block>() / size_of::<u64>()])
    }

    fn bytes(&mut self) -> &mut [u8] {
        let (_, blocks, _) = bytemuck::pod_align_to_mut::<u64, Block>(&mut self.0);
        Block::bytes(blocks)
    }
}
