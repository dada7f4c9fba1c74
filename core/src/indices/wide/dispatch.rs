//! Dispatch: the instruction set of a query, chosen once a call. No other module of this family knows which there are.
//!
//! ```text
//! SimdLevel --+-- AVX-512 --+
//!             +-- AVX2 -----+--> the traversal, compiled for these instructions, with the lanes of `simd::avx2`
//!             +-- none --------> the traversal, compiled for what the crate is, with the lanes of `simd::portable`
//! ```
//! A batch of many rays goes to the wavefront instead, with AVX2 or more; see `MANY`.
//!
//! # AVX-512
//! Eight `f32` fill half a register, so AVX-512 gives no new operations here. Its gain: the compiler has 32 registers
//! instead of 16, reads the ray's numbers as memory operands, and merges two logical operations into one instruction.
//!
//! # Measured
//! - Eight boxes take 44 instructions instead of 52.
//! - Eight triangles take 116 instructions instead of 137, without spilling a register.
//! - For a wide BVH on Zen 5 that is 0 to 2% of the time; for a compact or lean one, see `quantised`.
//!
//! # What lost
//! - Both sides of eight boxes in one register of 16: 30 instructions, but more to prepare a ray for; in all, 10 ns a
//!   ray more.
#![allow(unsafe_code)]

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::rows::LEAF_BIT;
use super::traversal;
use super::tree::InLanes;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
use super::wavefront::{self, Room};
use crate::input::SimdLevel;
use crate::query::{BatchQuery, Hit, Query};
use crate::simd::{Fastest, Portable};

/// Traverses a tree for one query.
#[inline]
pub(crate) fn traverse<T: InEvery, Q: Query>(tree: T, level: SimdLevel, query: &mut Q) {
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    if level.has_avx512() {
        // SAFETY: `SimdLevel::detect` alone can make this true, after the processor and the system said that they
        // have AVX-512: F, VL, DQ, BW, AVX2 and FMA.
        return unsafe { x86_64::traverse_avx512(tree, query) };
    } else if level.has_avx2() {
        // SAFETY: `SimdLevel::detect` alone can make this true, after the processor and the system said that they
        // have AVX2.
        return unsafe { x86_64::traverse_avx2(tree, query) };
    }
    let _ = level;
    traversal::traverse::<Portable, T, Q>(tree, query);
}

/// Traverses a tree for each query; see [`Structure::traverse_each`](crate::structure::Structure::traverse_each).
#[inline]
pub(crate) fn traverse_each<T: InEvery, Q: BatchQuery>(
    tree: T,
    level: SimdLevel,
    scratch: &mut [u8],
    count: usize,
    start: impl Fn(usize) -> Option<Q>,
    finish: impl FnMut(usize, Hit),
) {
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    if level.has_avx2()
        && (x86_64::MANY..=wavefront::MOST).contains(&count)
        && tree.root().link & LEAF_BIT == 0
        && let Some(room) = Room::of(scratch)
    {
        return x86_64::traverse_many(tree, level, room, count, start, finish);
    }
    let _ = scratch;
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    if level.has_avx512() {
        // SAFETY: as in `traverse`.
        return unsafe { x86_64::traverse_each_avx512(tree, count, start, finish) };
    } else if level.has_avx2() {
        // SAFETY: as in `traverse`.
        return unsafe { x86_64::traverse_each_avx2(tree, count, start, finish) };
    }
    let _ = level;
    traversal::traverse_each::<Portable, T, Q>(tree, count, start, finish);
}

/// Tree that all lanes of this target can read.
pub(crate) trait InEvery: InLanes<Portable> + InLanes<Fastest> {}
impl<T: InLanes<Portable> + InLanes<Fastest>> InEvery for T {}

/// The traversal, compiled for instructions that the processor may not have. Each is a function of its own, so that its
/// registers are not shared with those of the caller.
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod x86_64 {
    use crate::indices::wide::traversal;
    use crate::indices::wide::tree::InLanes;
    use crate::indices::wide::wavefront::{self, Room};
    use crate::input::SimdLevel;
    use crate::query::{BatchQuery, Hit, Query};
    use crate::simd::Avx2;

    /// Number of rays from which on a batch goes to the wavefront: with so many it is about as fast as four rays in turn,
    /// with more it is faster. It begins and ends with few rays in flight.
    ///
    /// # Measured
    /// Speed of the wavefront over four rays in turn, Zen 4, by the length of the batch:
    ///
    /// | rays | 32 | 64 | 128 | 256 | 1024 |
    /// |---|---|---|---|---|---|
    /// | figure 4(b) | 0.91 | 0.91 | 0.96 | 1.00 | 1.03 |
    /// | city | 0.99 | 0.99 | 1.05 | 1.11 | 1.13 |
    /// | compact BVH, 4(b) and city | | 0.98, 1.02 | 1.00, 0.97 | | |
    /// | lean BVH, 4(b) and city | | 0.88, 0.89 | 0.90, 1.03 | | |
    ///
    /// Its 39 KiB are the caller's scratch. On the stack they would be as fast, but few fibers have such stacks, and a
    /// query must not overflow them.
    pub const MANY: usize = 128;

    /// Traverses a tree for each query by the wavefront. The level has AVX2.
    #[inline]
    pub fn traverse_many<T: InLanes<Avx2>, Q: BatchQuery>(
        tree: T,
        level: SimdLevel,
        room: &mut Room,
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        finish: impl FnMut(usize, Hit),
    ) {
        if level.has_avx512() {
            // SAFETY: as in `traverse`.
            unsafe { wavefront::avx512::traverse_each(tree, room, count, start, finish) }
        } else {
            // SAFETY: as in `traverse`.
            unsafe { wavefront::avx2::traverse_each(tree, room, count, start, finish) }
        }
    }

    #[inline(never)]
    #[target_feature(enable = "avx2")]
    pub fn traverse_avx2<T: InLanes<Avx2>, Q: Query>(tree: T, query: &mut Q) {
        traversal::traverse::<Avx2, T, Q>(tree, query);
    }

    #[inline(never)]
    #[target_feature(enable = "avx2")]
    pub fn traverse_each_avx2<T: InLanes<Avx2>, Q: BatchQuery>(
        tree: T,
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        finish: impl FnMut(usize, Hit),
    ) {
        traversal::traverse_each::<Avx2, T, Q>(tree, count, start, finish);
    }

    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
    pub fn traverse_avx512<T: InLanes<Avx2>, Q: Query>(tree: T, query: &mut Q) {
        traversal::traverse::<Avx2, T, Q>(tree, query);
    }

    #[inline(never)]
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
    pub fn traverse_each_avx512<T: InLanes<Avx2>, Q: BatchQuery>(
        tree: T,
        count: usize,
        start: impl Fn(usize) -> Option<Q>,
        finish: impl FnMut(usize, Hit),
    ) {
        traversal::traverse_each::<Avx2, T, Q>(tree, count, start, finish);
    }
}

#[cfg(all(test, target_arch = "x86_64", target_feature = "sse2"))]
mod tests {
    use crate::Vec3;
    use crate::geometry::{LaneRay, Ray};
    use crate::input::SimdLevel;
    use crate::simd::prepare;

    #[test]
    fn ordinary_rays_are_prepared_as_by_lane_ray() {
        if !SimdLevel::detect().has_avx2() {
            return;
        }
        let numbers = [1.0, -1.0, 0.0, 0.3, 1e-21, -1e13, 3e8, -7e-19, 2e11];
        let number = |at: usize| numbers[at % numbers.len()];
        for at in 0..9_usize.pow(4) {
            let direction = Vec3::new(number(at), number(at / 9), number(at / 81));
            let origin = Vec3::new(number(at / 729), number(at / 27), -number(at / 3));
            let Ok(ray) = Ray::with_interval(origin, direction, number(at / 5).abs(), 1e30) else {
                continue;
            };
            let mut prepared = LaneRay::IDLE;
            // SAFETY: the processor has AVX2.
            let prepared = unsafe { prepare(&ray, &mut prepared) }.then_some(prepared);
            let expected = LaneRay::of(&ray, 0.0).filter(|(_, is_along)| !is_along);
            let bits = |ray: &LaneRay| bytemuck::bytes_of(ray).to_vec();
            // The fourth numbers of the inverses are not used.
            let used = |mut ray: LaneRay| {
                (ray.enter[3], ray.leave[3], ray.swap[3]) = (0.0, 0.0, 0);
                bits(&ray)
            };
            assert_eq!(prepared.map(used), expected.map(|(ray, _)| used(ray)), "{ray:?}");
        }
        let behind = Ray::with_interval(Vec3::ZERO, Vec3::ONE, -1.0, 1.0).expect("a valid ray");
        let mut prepared = LaneRay::IDLE;
        // SAFETY: the processor has AVX2.
        assert!(!unsafe { prepare(&behind, &mut prepared) });
    }
}
