//! Build of a wide BVH in slices of time.
//!
//! ```text
//! scratch: | build | scratch of the core |        memory: | index, as far as it is written |
//! ```

use core::ffi::c_void;

#[cfg(feature = "wide-bvh")]
use arboleda::{AnyIndex, BuildError};

use super::{BuildArguments, arb_index, fill};
use crate::error::{arb_error, arb_status, reported};
use crate::memory::{Caller, Keep, Kept, Output, Slot, apart};
use crate::options::arb_options;
use crate::scene::arb_mesh;

/// Build of a wide BVH (ARB_WIDE_BVH) in slices: for a program that must not wait for a whole build, such as a game
/// between two frames, or firmware with a watchdog. The index has the bytes of arb_build, wherever the build pauses.
///
///     size_t bytes = arb_sliced_scratch_bytes(mesh.triangle_count);
///     arb_sliced_build *build;
///     bool is_done = false;
///     arb_sliced_begin(&build, &mesh, NULL, memory, memory_bytes, scratch, bytes, &error);
///     while (arb_sliced_step(build, 1000, &is_done, &error) == ARB_OK && !is_done) {
///         draw_a_frame();
///     }
///     arb_sliced_finish(build, &index, &error);
///
/// The build lies in the first bytes of its scratch. Until it is over, the caller keeps alive, where and as they are: the
/// arrays of the mesh, the memory of the index, and the scratch. Nobody reads or writes the last two meanwhile. The
/// arb_mesh and the arb_options are free after arb_sliced_begin. A copy of the scratch elsewhere is refused as
/// ARB_NOT_BEGUN. One thread at a time calls functions for it. To give a build up, call none any more: it owns nothing.
pub struct arb_sliced_build(());

/// The build as it lies in the scratch.
#[cfg(feature = "wide-bvh")]
type Sliced = arboleda::SlicedBuild<'static, 'static>;

#[cfg(feature = "wide-bvh")]
fn finish(build: &mut Sliced) -> Result<AnyIndex<'static>, BuildError> {
    build.finish_in_place().map(AnyIndex::WideBvh)
}

#[cfg(not(feature = "wide-bvh"))]
use left_out::{Sliced, finish};

/// A library without the wide BVH has no build, and so begins none.
#[cfg(not(feature = "wide-bvh"))]
mod left_out {
    use core::mem::MaybeUninit;

    use arboleda::{AnyIndex, BuildError, Options, Scene};

    use crate::arb_kind::ARB_WIDE_BVH;
    use crate::error::Failure;

    pub enum Sliced {}

    impl Sliced {
        pub fn scratch_capacity(_: usize) -> usize {
            0
        }

        pub fn begin_in<'r>(
            _: &'r mut MaybeUninit<Self>,
            _: &Scene<'static>,
            _: &Options,
            _: &'static mut [u8],
            _: &'static mut [u8],
        ) -> Result<&'r mut Self, Failure> {
            Err(Failure::KindLeftOut { number: ARB_WIDE_BVH as u32 })
        }

        pub fn step(&mut self, _: usize) -> Result<bool, BuildError> {
            match *self {}
        }
    }

    pub fn finish(build: &mut Sliced) -> Result<AnyIndex<'static>, BuildError> {
        match *build {}
    }
}

impl Keep for Sliced {
    const MARK: u64 = 0x4152_4253_6c69_6365;
    const NAME: &'static str = "build";
}

/// Bytes of scratch that a build in slices of `triangle_count` triangles needs, wherever they lie: some 13 KB for the
/// build itself, and 48 bytes a triangle.
#[unsafe(no_mangle)]
pub extern "C" fn arb_sliced_scratch_bytes(triangle_count: usize) -> usize {
    Sliced::scratch_capacity(triangle_count).saturating_add(size_of::<Slot<Kept<Sliced>>>())
}

/// Begins a build of a wide BVH in slices, and does none of its work. See arb_sliced_build for what has to stay alive.
///
/// - `build`: receives the address of the build, which is that of the scratch. After an error it is NULL; after
///   ARB_OVERLAP it is as it was.
/// - `mesh`, `options`: as of arb_build; arb_options.beside is 0.
/// - `memory`: starts at a multiple of ARB_ALIGNMENT bytes, as that of arb_build. How many bytes the index takes is known
///   only once the triangles are sorted: mostly 50 to 60 a triangle. arb_measure says it exactly, and takes nearly as
///   long as a build.
/// - `scratch`: likewise aligned, as many bytes as arb_sliced_scratch_bytes says.
///
/// Errors: any of arb_status from 1 to 29, but those of the triangles and ARB_INDEX_MEMORY_TOO_SMALL, which
/// arb_sliced_step returns. ARB_KIND_LEFT_OUT if the library was built without the wide BVH.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_sliced_begin(
    build: *mut *mut arb_sliced_build,
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
    super::begin(caller, build, error, |to| {
        let rooms = [(memory, memory_bytes), (scratch, scratch_bytes)];
        let given = BuildArguments::check(caller, to, mesh, options, rooms)?;
        let needed = arb_sliced_scratch_bytes(given.scene.triangles().len());
        let (slot, rest) = given.scratch.split_scratch(needed)?;
        let (arena, rest) = (caller.borrow_mut(given.memory), caller.borrow_mut(rest));
        let begun = caller.keep::<Sliced>(slot, given.borrowed, |room| {
            Sliced::begin_in(room, &given.scene, &given.options, arena, rest)?;
            Ok(())
        });
        Ok(begun?.cast())
    })
}

/// Goes on with a build for about `looks` looks at a triangle, at least one.
///
/// - `is_done`: receives true if only arb_sliced_finish is left to do, which is short then.
///
/// Cost: a look takes 4 to 10 ns on a PC. A call takes at most `looks` looks, and what is not divided: mostly 4,000, at
/// most 20,000. A whole build takes about as long as arb_build.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_NOT_BEGUN, ARB_OVERLAP, and those of a build:
/// ARB_INDEX_MEMORY_TOO_SMALL, ARB_NON_FINITE_VERTEX, ARB_CORNER_OUT_OF_RANGE, ARB_OBJECT_OUT_OF_RANGE,
/// ARB_INDEX_TOO_LARGE, ARB_TOO_MUCH_WORK. After one of a build, each later call returns the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_sliced_step(
    build: *mut arb_sliced_build,
    looks: usize,
    is_done: *mut bool,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let to = Output::one(is_done, "is_done")?;
        let kept = caller.kept::<Sliced>(build.cast())?;
        apart(&[to.region()], &kept.borrowed)?;
        caller.write(to, kept.value.step(looks)?);
        Ok(())
    })
}

/// Does what is left of a build, and opens the index: the handle is that of arb_build. The build is over, and its scratch
/// and mesh are free again, also after an error.
///
/// Errors: those of arb_sliced_step. The handle is then not open; after ARB_OVERLAP it is as it was, and the build goes
/// on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_sliced_finish(
    build: *mut arb_sliced_build,
    index: *mut arb_index,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    fill(caller, index, error, |handle| {
        let kept = caller.kept::<Sliced>(build.cast())?;
        apart(&[handle], &kept.borrowed)?;
        kept.end();
        Ok(finish(&mut kept.value)?)
    })
}
