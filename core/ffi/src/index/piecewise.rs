//! Build of a hierarchy in pieces of memory.
//!
//! ```text
//! scratch: | build | clusters | scratch of the clusters |      memory: | header, cluster tree, scratch of one cluster |
//! pieces:  triangles, words of each cluster in `room`, then cluster tree and header in `memory`
//! ```
//! The build borrows the clusters, so they lie in a slot of their own, which is never borrowed to be written again.

use core::ffi::c_void;
use core::{mem, ptr};

use arboleda::clusters::{self, Clusters};
use arboleda::{BuildError, IndexKind, Mesh, Options, Piece, PiecewiseBuild, Scene, Triangle};

use crate::error::{Failure, arb_error, arb_status, reported};
use crate::kind;
use crate::memory::{Caller, Keep, Kept, Output, Slot, apart};
use crate::options::{arb_options, chosen};
use crate::scene::{Arrays, arb_mesh};

/// Build of a hierarchy one cluster at a time: for storage that holds the index and memory that does not, such as flash
/// that is written page by page. Each piece is some bytes and where they belong. The index has the bytes of arb_build, if
/// arb_options.work_limit is 0.
///
///     size_t bytes = arb_piecewise_scratch_bytes(mesh.triangle_count), memory_bytes;
///     arb_piecewise_build *build;
///     arb_piece piece;
///     arb_piecewise_begin(&build, ARB_BVH_HIERARCHY, &mesh, NULL, scratch, bytes, &memory_bytes, &error);
///     arb_piecewise_join(build, memory, memory_bytes, &error);
///     while (arb_piecewise_next(build, room, room_bytes, &piece, &error) == ARB_OK && piece.byte_count != 0) {
///         write_at(piece.offset, piece.bytes, piece.byte_count);
///     }
///
/// The storage has piece.index_bytes of the last piece; bytes that no piece has are 0. The header comes last, so what is
/// written before is no index yet.
///
/// The build lies in the first bytes of its scratch. Until it is over, the caller keeps alive, where and as they are: the
/// arrays of the mesh, the scratch, and the memory. Nobody reads or writes the last two meanwhile, but for the pieces that
/// lie there. The arb_mesh and the arb_options are free after arb_piecewise_begin, the room after each piece. A copy of
/// the scratch elsewhere is refused as ARB_NOT_BEGUN. One thread at a time calls functions for it. To give a build up,
/// call none any more: it owns nothing.
pub struct arb_piecewise_build(());

/// Run of the bytes of an index.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct arb_piece {
    /// The bytes: in the room, in the arrays of the mesh, or in the memory of the build; NULL if there are no more.
    pub bytes: *const c_void,
    /// The number of bytes; 0 if there are no more pieces.
    pub byte_count: usize,
    /// The place of the first byte in the index, a multiple of 4.
    pub offset: usize,
    /// The bytes of the index, as far as it is known: its length if there are no more pieces.
    pub index_bytes: usize,
}

/// The build as it lies in the scratch.
struct Pieces {
    kind: IndexKind,
    scene: Scene<'static>,
    options: Options,
    clusters: &'static Clusters<'static>,
    /// The number of triangles in the index, 0 beside a mesh, and of those that were handed out.
    triangle_count: usize,
    next_triangle: usize,
    stage: Stage,
}

/// Stage of a build in pieces. There is one for each build, so that its size does not matter.
#[allow(clippy::large_enum_variant)]
enum Stage {
    /// The cluster tree.
    Join,
    /// The triangles that are left, then the words of the clusters that are left.
    Words(PiecewiseBuild<'static, 'static>),
    /// The pieces that are left, in their order, and the length of the index in bytes.
    Ends([Option<Piece<'static>>; 2], usize),
}

/// Bytes of a triangle in an index.
const TRIANGLE_BYTES: usize = size_of::<Triangle>();

impl Keep for Pieces {
    const MARK: u64 = 0x4152_4250_6965_6365;
    const NAME: &'static str = "build";
}

/// Bytes of scratch that a build in pieces of `triangle_count` triangles needs, wherever they lie: some 80 to 90 a
/// triangle.
#[unsafe(no_mangle)]
pub extern "C" fn arb_piecewise_scratch_bytes(triangle_count: usize) -> usize {
    clusters::scratch_capacity(triangle_count)
        .saturating_add(size_of::<Slot<Clusters<'_>>>())
        .saturating_add(size_of::<Slot<Kept<Pieces>>>())
}

/// Begins a build in pieces, and finds the clusters. See arb_piecewise_build for what has to stay alive.
///
/// - `build`: receives the address of the build, which is that of the scratch. After an error it is NULL; after
///   ARB_OVERLAP it is as it was.
/// - `kind`: a hierarchy of arb_kind, but for those of the wide, the compact and the lean BVH, each of which is one tree.
/// - `mesh`, `options`: as of arb_build.
/// - `scratch`: starts at a multiple of ARB_ALIGNMENT bytes, and has as many bytes as arb_piecewise_scratch_bytes says.
/// - `memory_bytes`: receives the number of bytes that arb_piecewise_join needs.
///
/// Cost: at most a multiple of n log n for n triangles.
///
/// Errors: any of arb_status from 1 to 29.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_piecewise_begin(
    build: *mut *mut arb_piecewise_build,
    kind: u32,
    mesh: *const arb_mesh,
    options: *const arb_options,
    scratch: *mut c_void,
    scratch_bytes: usize,
    memory_bytes: *mut usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    super::begin(caller, build, error, |to| {
        let kind = kind::of_number(kind)?;
        if !kind.can_be_built_in_pieces() {
            return Err(BuildError::NotInPieces { kind: kind.name() }.into());
        }
        let chosen = chosen(caller, options)?;
        let arrays = Arrays::check(caller, mesh)?;
        let scratch = Output::<u8>::check(scratch.cast(), scratch_bytes, "scratch")?;
        let needed = Output::one(memory_bytes, "memory_bytes")?;
        let in_scratch = scratch.region();
        apart(&[to, in_scratch, needed.region()], &arrays.regions())?;
        let (scene, options) = (arrays.scene(caller, chosen.beside), chosen.options);
        let scratch_needed = arb_piecewise_scratch_bytes(scene.triangles().len());
        let (slot, rest) = scratch.split_scratch(scratch_needed)?;
        let full = BuildError::ScratchFull { needed: scratch_needed, given: scratch_bytes };
        let (clusters_slot, rest) = rest.split().ok_or(full)?;
        let found = clusters::find(&scene, &options, caller.borrow_mut(rest))?;
        let clusters: &'static Clusters<'static> = caller.place(clusters_slot, found);
        caller.write(needed, kind.memory_in_pieces(clusters, &options));
        let [a, b, c, d] = arrays.regions();
        // The last is the memory, once there is one.
        let borrowed = [in_scratch, a, b, c, d, in_scratch];
        let triangle_count = if chosen.beside { 0 } else { scene.triangles().len() };
        let (next_triangle, stage) = (0, Stage::Join);
        let pieces =
            Pieces { kind, scene, options, clusters, triangle_count, next_triangle, stage };
        let begun = caller.keep(slot, borrowed, |room| {
            room.write(pieces);
            Ok(())
        });
        Ok(begun?.cast())
    })
}

/// Joins the clusters into the cluster tree, in memory that stays with the build.
///
/// - `memory`: starts at a multiple of ARB_ALIGNMENT bytes, and has as many bytes as arb_piecewise_begin says. It holds the
///   header, the cluster tree and the scratch for the largest cluster. To call this again after an error is allowed.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_LENGTH_OVERFLOW, ARB_OVERLAP, ARB_SCRATCH_TOO_SMALL;
/// ARB_NOT_BEGUN, also if the clusters are joined already.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_piecewise_join(
    build: *mut arb_piecewise_build,
    memory: *mut c_void,
    memory_bytes: usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let Kept { value: pieces, borrowed, .. } = caller.kept::<Pieces>(build.cast())?;
        if !matches!(pieces.stage, Stage::Join) {
            return Err(Failure::OutOfOrder { why: "the clusters are joined already" });
        }
        let memory = Output::<u8>::check(memory.cast(), memory_bytes, "memory")?;
        apart(&[memory.region()], borrowed)?;
        let region = memory.region();
        let Pieces { kind, scene, options, clusters, .. } = *pieces;
        let begun = kind.build_in_pieces(&scene, &options, clusters, caller.borrow_mut(memory))?;
        let [.., last] = borrowed;
        *last = region;
        pieces.stage = Stage::Words(begun);
        Ok(())
    })
}

/// Makes the next piece of the index.
///
/// - `room`: NULL if `room_bytes` is 0, or starts at a multiple of ARB_ALIGNMENT bytes. Most pieces are made there: the
///   words of a cluster, or as many triangles as fit, 36 bytes each. What lay there before is lost.
/// - `piece`: receives the bytes, and where they belong. They are valid until the next call. If there are no more, its
///   byte_count is 0, and the build is over.
///
/// Pieces come in the order in which they lie in the index, but for the cluster tree and the header, which come last.
///
/// Errors: ARB_INDEX_MEMORY_TOO_SMALL, if the room is too small for the next piece: arb_error.needed_bytes are enough for
/// it, and the next call makes the same piece. ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_LENGTH_OVERFLOW, ARB_OVERLAP;
/// ARB_NOT_BEGUN, also before arb_piecewise_join; ARB_INDEX_TOO_LARGE, ARB_TOO_MUCH_WORK. `piece` is then unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_piecewise_next(
    build: *mut arb_piecewise_build,
    room: *mut c_void,
    room_bytes: usize,
    piece: *mut arb_piece,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let kept = caller.kept::<Pieces>(build.cast())?;
        let room = Output::<u8>::check(room.cast(), room_bytes, "room")?;
        let to = Output::one(piece, "piece")?;
        room.check_alignment()?;
        apart(&[to.region(), room.region()], &kept.borrowed)?;
        let (next, index_bytes) = kept.value.next(caller.borrow_mut(room))?;
        let (bytes, byte_count, offset) = next.map_or((ptr::null(), 0, 0), |next| {
            (next.bytes.as_ptr(), next.bytes.len(), next.offset)
        });
        caller.write(to, arb_piece { bytes: bytes.cast(), byte_count, offset, index_bytes });
        if next.is_none() {
            kept.end();
        }
        Ok(())
    })
}

impl Pieces {
    /// The next piece, and the bytes of the index as far as they are known.
    fn next<'w>(&mut self, room: &'w mut [u8]) -> Result<(Option<Piece<'w>>, usize), Failure> {
        // 1. The triangles, unless the index lies beside them: a list as it is, others copied into the room.
        if let Stage::Words(build) = &self.stage
            && self.next_triangle < self.triangle_count
        {
            let (offset, length) = (build.triangles_offset(), build.length());
            if let Mesh::Triangles(list) = self.scene.triangles() {
                self.next_triangle = self.triangle_count;
                return Ok((
                    Some(Piece { offset, bytes: bytemuck::must_cast_slice(list) }),
                    length,
                ));
            }
            let offset = offset.saturating_add(self.next_triangle.saturating_mul(TRIANGLE_BYTES));
            let bytes = self.copy_triangles(room)?;
            return Ok((Some(Piece { offset, bytes }), length));
        }
        // 2. The words of the next cluster; none has no words.
        if let Stage::Words(build) = &mut self.stage {
            while let Some(Piece { offset, bytes }) = build.build_next(room)? {
                let count = bytes.len();
                if count > 0 {
                    let bytes = room.get(..count).unwrap_or_default();
                    return Ok((Some(Piece { offset, bytes }), build.length()));
                }
            }
        }
        // 3. The cluster tree, and then the header.
        if matches!(self.stage, Stage::Words(_))
            && let Stage::Words(build) = mem::replace(&mut self.stage, Stage::Join)
        {
            let length = build.length();
            self.stage = Stage::Ends(build.finish()?.map(Some), length);
        }
        match &mut self.stage {
            Stage::Ends(pieces, length) => {
                let next = pieces
                    .iter_mut()
                    .find_map(|piece| piece.take_if(|piece| !piece.bytes.is_empty()));
                Ok((next, *length))
            }
            _ => Err(Failure::OutOfOrder { why: "arb_piecewise_join has to be called first" }),
        }
    }

    /// Copies as many of the triangles that are left as fit.
    fn copy_triangles<'w>(&mut self, room: &'w mut [u8]) -> Result<&'w [u8], Failure> {
        let given = room.len();
        let triangles = self.scene.triangles();
        let mut end = 0;
        for slot in room.chunks_exact_mut(TRIANGLE_BYTES) {
            if self.next_triangle >= self.triangle_count {
                break;
            }
            let triangle = triangles.get(self.next_triangle as u32).unwrap_or_default();
            for (to, from) in slot.iter_mut().zip(bytemuck::bytes_of(&triangle)) {
                *to = *from;
            }
            self.next_triangle += 1;
            end += TRIANGLE_BYTES;
        }
        if end == 0 {
            return Err(BuildError::ArenaFull { needed: TRIANGLE_BYTES, given }.into());
        }
        Ok(room.get(..end).unwrap_or_default())
    }
}
