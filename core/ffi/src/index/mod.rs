//! Handles: build, open, describe, close.

mod piecewise;
mod sliced;

use core::ffi::c_void;
use core::ptr::null_mut;

use arboleda::{AnyIndex, Block, Options, Scene};

use crate::error::{Failure, arb_error, arb_status, reported, status_of};
use crate::kind;
use crate::memory::{Caller, Input, Output, Region, apart};
use crate::options::{arb_options, chosen};
use crate::scene::{Arrays, arb_mesh};

pub use piecewise::{
    arb_piece, arb_piecewise_begin, arb_piecewise_build, arb_piecewise_join, arb_piecewise_next,
    arb_piecewise_scratch_bytes,
};
pub use sliced::{
    arb_sliced_begin, arb_sliced_build, arb_sliced_finish, arb_sliced_scratch_bytes,
    arb_sliced_step,
};

/// Alignment in bytes of the memory of an index and of the scratch of a build.
pub const ARB_ALIGNMENT: usize = 64;
/// Words of 64 bits in an arb_index: 256 bytes on every target.
pub const ARB_INDEX_WORDS: usize = 32;

const _: () = assert!(align_of::<Block>() == ARB_ALIGNMENT);

/// Handle of an index that answers queries: 256 bytes, the caller's. arb_build and arb_open fill it; nobody else writes
/// to it. One that is not filled, of zeros for example, is refused by every function.
///
/// It borrows the bytes of the index and, beside a mesh, the mesh's arrays: both must stay where and as they are while
/// the handle is used. It owns nothing, so it needs not be closed. It may be copied, and used by several threads at once.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct arb_index {
    /// Not to be read or written by the caller.
    pub opaque: [u64; ARB_INDEX_WORDS],
}

/// Memory and work of a build.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct arb_capacity {
    /// Bytes of the index, exactly.
    pub index_bytes: usize,
    /// Bytes of scratch that are enough. They are free again after the build.
    pub scratch_bytes: usize,
    /// Steps of the build, in looks at a triangle; see arb_options.work_limit.
    pub steps: u64,
}

/// Description of an open index.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct arb_description {
    /// The bytes of the index, in the memory in which it was built or opened: what to write to a file, or to copy.
    pub bytes: *const c_void,
    /// The number of these bytes.
    pub byte_count: usize,
    /// The kind, a number of arb_kind.
    pub kind: u32,
    /// The number of triangles.
    pub triangle_count: u32,
    /// The number of clusters; 1 for a kind without clusters, 0 without triangles.
    pub cluster_count: u32,
    /// 1 if the index lies beside a mesh, else 0.
    pub beside: u32,
}

/// Bit of the core's kind: the index lies beside a mesh.
const MESH_BESIDE: u32 = 1 << 18;

/// Bounds the scratch of a build: writes to `scratch_bytes` how many bytes are enough for `triangle_count` triangles,
/// wherever they lie. `kind` is a number of arb_kind, `options` may be NULL for the defaults. Cost: constant.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_UNKNOWN_KIND, ARB_KIND_LEFT_OUT, ARB_INVALID_OPTION.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_scratch_bytes(
    kind: u32,
    triangle_count: usize,
    options: *const arb_options,
    scratch_bytes: *mut usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let kind = kind::of_number(kind)?;
        let options = chosen(caller, options)?.options;
        let to = Output::one(scratch_bytes, "scratch_bytes")?;
        caller.write(to, kind.scratch_capacity(triangle_count, &options));
        Ok(())
    })
}

/// Measures what a build takes, by a build that only counts: the exact bytes of the index, and the steps. Cost: that of
/// the build.
///
/// `kind`, `mesh` and `options` are those of arb_build. `scratch` starts at a multiple of ARB_ALIGNMENT bytes, and has as
/// many bytes as arb_scratch_bytes says.
///
/// Errors: those of arb_build but ARB_INDEX_MEMORY_TOO_SMALL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_measure(
    kind: u32,
    mesh: *const arb_mesh,
    options: *const arb_options,
    scratch: *mut c_void,
    scratch_bytes: usize,
    capacity: *mut arb_capacity,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let kind = kind::of_number(kind)?;
        let chosen = chosen(caller, options)?;
        let arrays = Arrays::check(caller, mesh)?;
        let scratch = Output::<u8>::check(scratch.cast(), scratch_bytes, "scratch")?;
        let to = Output::one(capacity, "capacity")?;
        apart(&[scratch.region(), to.region()], &arrays.regions())?;
        let scene = arrays.scene(caller, chosen.beside);
        let measured = kind.capacity(&scene, &chosen.options, caller.borrow_mut(scratch))?;
        let (index_bytes, scratch_bytes) = (measured.index, measured.scratch);
        caller.write(to, arb_capacity { index_bytes, scratch_bytes, steps: measured.steps });
        Ok(())
    })
}

/// Builds an index of a mesh in the first bytes of `memory`, and opens it.
///
/// - `index`: the handle to be filled. After an error it is not open; after ARB_OVERLAP it is as it was.
/// - `kind`: a number of arb_kind.
/// - `mesh`: copied into the index, and free again after the call, unless arb_options.beside is 1.
/// - `options`: NULL for the defaults.
/// - `memory`: starts at a multiple of ARB_ALIGNMENT bytes. arb_measure says how many bytes are needed; so does a call
///   with fewer, NULL and 0 for example, in arb_error.needed_bytes. It belongs to the index while the handle is used.
///   After an error, its contents are undefined.
/// - `scratch`: likewise aligned, as many bytes as arb_scratch_bytes says. Free again after the call.
/// - `error`: receives the reason of a failure; or NULL.
///
/// The bytes that are written depend on mesh, kind and options only. Cost: at most a multiple of n log n for n
/// triangles, in the caller's thread.
///
/// Errors: any of arb_status from 1 to 29.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_build(
    index: *mut arb_index,
    kind: u32,
    mesh: *const arb_mesh,
    options: *const arb_options,
    memory: *mut c_void,
    memory_bytes: usize,
    scratch: *mut c_void,
    scratch_bytes: usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    fill(caller, index, error, |handle| {
        let kind = kind::of_number(kind)?;
        let rooms = [(memory, memory_bytes), (scratch, scratch_bytes)];
        let given = BuildArguments::check(caller, handle, mesh, options, rooms)?;
        let (arena, scratch) = (caller.borrow_mut(given.memory), caller.borrow_mut(given.scratch));
        Ok(kind.build(&given.scene, &given.options, arena, scratch)?)
    })
}

/// Checked arguments of a build in the caller's memory.
struct BuildArguments {
    scene: Scene<'static>,
    options: Options,
    memory: Output<u8>,
    scratch: Output<u8>,
    /// Regions of the memory, the scratch and the arrays of the mesh.
    borrowed: [Region; 6],
}

impl BuildArguments {
    /// Checks the arguments, and that none of them overlaps another or `to`. `rooms` are the memory and the scratch.
    fn check(
        caller: Caller,
        to: Region,
        mesh: *const arb_mesh,
        options: *const arb_options,
        rooms: [(*mut c_void, usize); 2],
    ) -> Result<Self, Failure> {
        let chosen = chosen(caller, options)?;
        let arrays = Arrays::check(caller, mesh)?;
        let [(memory, memory_bytes), (scratch, scratch_bytes)] = rooms;
        let memory = Output::<u8>::check(memory.cast(), memory_bytes, "memory")?;
        let scratch = Output::<u8>::check(scratch.cast(), scratch_bytes, "scratch")?;
        let [in_memory, in_scratch] = [memory.region(), scratch.region()];
        apart(&[to, in_memory, in_scratch], &arrays.regions())?;
        let [a, b, c, d] = arrays.regions();
        let borrowed = [in_memory, in_scratch, a, b, c, d];
        let scene = arrays.scene(caller, chosen.beside);
        Ok(Self { scene, options: chosen.options, memory, scratch, borrowed })
    }
}

/// Opens an index from its bytes, in place: bytes of a file, or in ROM.
///
/// - `index`: the handle to be filled. After an error it is not open; after ARB_OVERLAP it is as it was.
/// - `bytes`: start at a multiple of ARB_ALIGNMENT bytes; what comes after the index is ignored.
/// - `mesh`: NULL; or, for an index that was built beside a mesh, one with the same triangles in either form.
///
/// Everything on which queries rely is checked, so bytes from anywhere do no harm. Forged bytes can give wrong answers.
/// Any kind of index is opened. Bytes of any machine of the same byte order are. Cost: linear in `byte_count` and in the
/// mesh.
///
/// Errors: any of arb_status from 1 to 19 and from 40 to 59; ARB_NON_FINITE_VERTEX and ARB_CORNER_OUT_OF_RANGE of a mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_open(
    index: *mut arb_index,
    bytes: *const c_void,
    byte_count: usize,
    mesh: *const arb_mesh,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    fill(caller, index, error, |handle| {
        let bytes = Input::<u8>::check(bytes.cast(), byte_count, "bytes")?;
        apart(&[handle], &[bytes.region()])?;
        if mesh.is_null() {
            return Ok(AnyIndex::from_bytes(caller.borrow(bytes))?);
        }
        let arrays = Arrays::check(caller, mesh)?;
        apart(&[handle], &arrays.regions())?;
        Ok(AnyIndex::from_bytes_beside(caller.borrow(bytes), arrays.mesh(caller))?)
    })
}

/// Describes an open index: its bytes, its kind, and what it consists of.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_NOT_OPEN.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_describe(
    index: *const arb_index,
    description: *mut arb_description,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        let index = caller.index(index)?;
        let to = Output::one(description, "description")?;
        let (sections, bytes) = (index.sections(), index.as_bytes());
        let described = arb_description {
            bytes: bytes.as_ptr().cast(),
            byte_count: bytes.len(),
            kind: index.kind() as u32,
            triangle_count: sections.triangle_count(),
            cluster_count: sections.cluster_count(),
            beside: u32::from(sections.kind() & MESH_BESIDE != 0),
        };
        caller.write(to, described);
        Ok(())
    })
}

/// Closes a handle: any later use of it is an error. Not necessary, since a handle owns nothing; good before the memory
/// of the index is freed. Closing one that is not open does nothing.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_close(index: *mut arb_index) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    status_of(|| {
        let handle = Output::one(index, "index")?;
        caller.write(handle, CLOSED);
        Ok(())
    })
}

const CLOSED: arb_index = arb_index { opaque: [0; ARB_INDEX_WORDS] };

/// Fills a handle with the index that `open` returns, or closes it.
fn fill(
    caller: Caller,
    index: *mut arb_index,
    error: *mut arb_error,
    open: impl FnOnce(Region) -> Result<AnyIndex<'static>, Failure>,
) -> arb_status {
    answer(caller, index, "index", CLOSED, error, open, Caller::write_index)
}

/// Begins a build that takes several calls, and writes its address, or null.
fn begin<T>(
    caller: Caller,
    build: *mut *mut T,
    error: *mut arb_error,
    begin: impl FnOnce(Region) -> Result<*mut T, Failure>,
) -> arb_status {
    answer(caller, build, "build", null_mut(), error, begin, Caller::write)
}

/// Writes what `make` returns to an output, or `none` if it fails.
fn answer<T, V>(
    caller: Caller,
    to: *mut T,
    name: &'static str,
    none: T,
    error: *mut arb_error,
    make: impl FnOnce(Region) -> Result<V, Failure>,
    write: impl FnOnce(Caller, Output<T>, V),
) -> arb_status {
    reported(caller, error, || {
        let to = Output::one(to, name)?;
        match make(to.region()) {
            Ok(made) => write(caller, to, made),
            // What the output overlaps is an input.
            Err(failure @ Failure::Overlap { .. }) => return Err(failure),
            Err(failure) => {
                caller.write(to, none);
                return Err(failure);
            }
        }
        Ok(())
    })
}
