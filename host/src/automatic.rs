//! The automatic selection, with memory from the heap.

use arboleda::auto::{Selection, USUAL, select};
use arboleda::{Block, BuildError, Options, Scene};

/// An index that needs more bytes a triangle than this is left out: the grids and octrees worth having stay
/// below a quarter of it.
const BYTES_PER_TRIANGLE: usize = 1024;
/// Room for the smallest scenes.
const LEAST_BYTES: usize = 1 << 20;

/// Chooses among the usual indices; see [`arboleda::auto::select`]. Memory that no candidate touches costs nothing: it
/// comes zeroed from the system.
///
/// # Errors
/// As there.
pub fn select_index(scene: &Scene<'_>, options: &Options) -> Result<Selection, BuildError> {
    let count = scene.triangles().len();
    let scratch_bytes = USUAL.iter().map(|kind| kind.scratch_capacity(count, options)).max();
    let mut scratch = bytemuck::zeroed_vec(Block::count(scratch_bytes.unwrap_or(0)));
    let arena_bytes = LEAST_BYTES + count * BYTES_PER_TRIANGLE;
    let mut arena = bytemuck::zeroed_vec(Block::count(arena_bytes));
    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    select(scene, options, USUAL, arena, scratch)
}
