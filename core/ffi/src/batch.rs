//! Queries of many rays.
//!
//! The core asks about rays that are known to be valid, in a form that only it makes. So the caller's rays are
//! converted, some at a time, into the caller's scratch:
//!
//! ```text
//! scratch: | room for CHUNK rays | the core's scratch |      without it: room for FEW rays on the stack
//! ```

use arboleda::{AnyIndex, BATCH_SCRATCH, Ray};

use crate::error::{Failure, arb_error, arb_status, reported};
use crate::index::arb_index;
use crate::memory::{Caller, Input, Output, apart, borrowed, rays_in};
use crate::query::{arb_hit, arb_ray};

/// Rays that are converted at once, in a scratch: beginning and end of the 32 in flight then cost little.
const CHUNK: usize = 1024;
/// Rays that are converted at once, on the stack: 512 bytes.
const FEW: usize = 16;
/// Bytes of room for `count` rays, wherever it begins.
const fn room_for(count: usize) -> usize {
    count * size_of::<Ray>() + align_of::<Ray>()
}

/// Bytes of scratch that arb_closest_each and arb_occluded_each use, whatever the index and the number of rays: about
/// 71 KiB on x86-64; 0 where scratch makes nothing faster.
#[unsafe(no_mangle)]
pub extern "C" fn arb_batch_scratch_bytes() -> usize {
    if BATCH_SCRATCH == 0 { 0 } else { room_for(CHUNK) + BATCH_SCRATCH }
}

/// Finds the closest hit of each ray: the same bits as arb_closest, in less time.
///
/// - `rays`, `hits`: `ray_count` of each, in the same order.
/// - `scratch`: memory of the caller at any alignment, arb_batch_scratch_bytes() or more; its contents do not
///   matter. (Lanes of vectors whose results are not used may read old contents: a memory checker such as valgrind wants
///   it set to zeros once.) With fewer bytes, NULL and 0 for example, the answers are the same and take longer. Each
///   thread needs its own.
///
/// With a scratch, the wide, compact and lean BVH have 32 rays in flight where the processor has AVX2, from 128 rays
/// on: the fastest way.
///
/// Errors: ARB_NULL_POINTER, ARB_MISALIGNED_POINTER, ARB_LENGTH_OVERFLOW, ARB_OVERLAP, ARB_NOT_OPEN, and any of
/// arb_status from 60 to 69, with the ray's number in arb_error.element. All rays are checked first, so `hits` is then
/// unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_closest_each(
    index: *const arb_index,
    rays: *const arb_ray,
    ray_count: usize,
    hits: *mut arb_hit,
    scratch: *mut core::ffi::c_void,
    scratch_bytes: usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let batch = Batch { index, rays, ray_count, scratch, scratch_bytes };
        let borrow = |hits| bytemuck::must_cast_slice_mut(caller.borrow_mut(hits));
        batch.answer(caller, (hits, "hits"), borrow, |index, rays, hits, scratch| {
            index.closest_hits_in(rays, hits, scratch);
        })
    })
}

/// Tells for each ray whether it hits any triangle, as arb_occluded does, in less time. Arguments and errors as of
/// arb_closest_each; `occluded` has room for `ray_count` values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_occluded_each(
    index: *const arb_index,
    rays: *const arb_ray,
    ray_count: usize,
    occluded: *mut bool,
    scratch: *mut core::ffi::c_void,
    scratch_bytes: usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let batch = Batch { index, rays, ray_count, scratch, scratch_bytes };
        let borrow = |occluded| caller.borrow_flags(occluded);
        batch.answer(caller, (occluded, "occluded"), borrow, |index, rays, occluded, scratch| {
            index.occluded_each_in(rays, occluded, scratch);
        })
    })
}

/// Arguments of a query of many rays.
struct Batch {
    index: *const arb_index,
    rays: *const arb_ray,
    ray_count: usize,
    scratch: *mut core::ffi::c_void,
    scratch_bytes: usize,
}

impl Batch {
    /// Checks all arguments, and answers the rays. `borrow` borrows the room for the answers, an array of `T` of this
    /// name.
    fn answer<'a, T, A: 'a>(
        self,
        caller: Caller,
        (answers, name): (*mut T, &'static str),
        borrow: impl FnOnce(Output<T>) -> &'a mut [A],
        mut answer: impl FnMut(&AnyIndex<'_>, &[Ray], &mut [A], &mut [u8]),
    ) -> Result<(), Failure> {
        let index = caller.index(self.index)?;
        let rays = Input::check(self.rays, self.ray_count, "rays")?;
        let answers = Output::check(answers, self.ray_count, name)?;
        let scratch = Output::check(self.scratch.cast::<u8>(), self.scratch_bytes, "scratch")?;
        let outputs = [answers.region(), scratch.region()];
        apart(&outputs, &[rays.region()])?;
        apart(&outputs, &borrowed(index))?;
        let rays = checked(caller, rays)?;
        let answers = borrow(answers);
        in_chunks(rays, answers, caller.borrow_mut(scratch), |rays, answers, scratch| {
            answer(index, rays, answers, scratch);
        });
        Ok(())
    }
}

/// Borrows rays, and checks all of them.
fn checked<'a>(caller: Caller, rays: Input<arb_ray>) -> Result<&'a [arb_ray], Failure> {
    let rays = caller.borrow(rays);
    for (at, ray) in rays.iter().enumerate() {
        ray.converted(at)?;
    }
    Ok(rays)
}

/// Converts rays that were checked, some at a time, and answers them.
fn in_chunks<T>(
    rays: &[arb_ray],
    answers: &mut [T],
    scratch: &mut [u8],
    mut answer: impl FnMut(&[Ray], &mut [T], &mut [u8]),
) {
    let mut few = [0; room_for(FEW)];
    let (room, scratch, count) = match scratch.split_at_mut_checked(room_for(CHUNK)) {
        Some((room, rest)) if BATCH_SCRATCH > 0 && rest.len() >= BATCH_SCRATCH => {
            (room, rest, CHUNK)
        }
        _ => (&mut few[..], Default::default(), FEW),
    };
    for (rays, answers) in rays.chunks(count).zip(answers.chunks_mut(count)) {
        let rays = rays_in(room, rays.iter().filter_map(|ray| ray.ray().ok()));
        answer(rays, answers, scratch);
    }
}
