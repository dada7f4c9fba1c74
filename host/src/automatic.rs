//! The automatic selection, with memory from the heap.

use arboleda::select::{Selection, USUAL, select};
use arboleda::{Block, BuildError, Options, Scene};

/// An index that needs more bytes a triangle than this is left out: the grids and octrees worth having stay
/// below a quarter of it.
const BYTES_PER_TRIANGLE: usize = 1024;
/// Room for the smallest scenes.
const LEAST_BYTES: usize = 1 << 20;

/// Chooses among the usual indices; see [`arboleda::select::select`].
///
/// # Errors
/// As there.
pub fn select_index(scene: &Scene<'_>, options: &Options) -> Result<Selection, BuildError> {
    let count = scene.triangles().len();
    let scratch_bytes = USUAL.iter().map(|kind| kind.scratch_capacity(count, options)).max();
    let mut scratch = Untouched::of(scratch_bytes.unwrap_or(0));
    let arena_bytes = LEAST_BYTES + count * BYTES_PER_TRIANGLE;
    let mut arena = Untouched::of(arena_bytes);
    select(scene, options, USUAL, arena.bytes(), scratch.bytes())
}

/// Zeroed memory of which only touched pages become resident.
///
/// A vector of blocks would be filled with zeros in a loop, and so be resident: blocks are aligned more strictly than
/// memory that the allocator hands out as zeros.
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
