//! Lanes in AVX2: eight numbers in one register.
//!
//! - Boxes and eight triangles: the same operations in the same order as in [`Portable`](super::Portable), which the
//!   compiler turns into much longer code. No FMA, so that both give the same bits.
//! - Candidates: the filter of `avx2_judge` in front of the kernel.
//!
//! `unsafe` here is calling functions that are compiled for instructions which the processor may not have; see
//! [`simd`](crate::simd). It is worth about a third of the time of a query.
// Forced, because what a traversal calls must be compiled for the instructions of its lanes, in one function with it.
#![allow(unsafe_code, clippy::inline_always)]

use core::arch::x86_64::{
    __m128i, __m256, _CMP_GT_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_cvtsi128_si32, _mm_minpos_epu16,
    _mm_or_si128, _mm_prefetch, _mm_test_all_ones, _mm256_add_ps, _mm256_and_ps, _mm256_andnot_ps,
    _mm256_castps_si256, _mm256_castsi256_si128, _mm256_cmp_ps, _mm256_max_ps, _mm256_min_ps,
    _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_ps, _mm256_permute4x64_epi64, _mm256_set1_ps,
    _mm256_shuffle_epi8, _mm256_sub_ps, _mm256_xor_ps,
};

use super::avx2_judge::judge;
use super::avx2_ray::prepare;
use super::lanes::{Arithmetic, FAR, LANES, Lanes, LeafRows, Node, Row, sides_of};
use crate::geometry::kernel::Verdict;
use crate::geometry::{
    Candidates, DISTANCE, LaneRay, MOST_COORDINATE, ROUNDED, Ray, SUM, Triangle, UNDERFLOW,
};
use crate::query::Query;

/// Lanes of traversals that are compiled for AVX2, or for more.
pub(crate) enum Avx2 {}

impl Lanes for Avx2 {
    type Keys = __m128i;
    type Numbers = __m256;

    #[inline(always)]
    fn prepare(
        ray: &Ray,
        largest_coordinate: f32,
        may_hit: impl FnOnce() -> bool,
        prepared: &mut LaneRay,
    ) -> Arithmetic {
        // SAFETY: see `meet_boxes`.
        if largest_coordinate <= MOST_COORDINATE && unsafe { prepare(ray, prepared) } {
            return Arithmetic::Lanes;
        }
        prepare_unusual(ray, largest_coordinate, may_hit, prepared)
    }

    #[inline(always)]
    fn all(number: f32) -> __m256 {
        // SAFETY: see `meet_boxes`.
        unsafe { all(number) }
    }

    #[inline(always)]
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> __m128i {
        // SAFETY: only traversals compiled for AVX2, or for AVX-512, which includes it, use these lanes. The calls of
        // all functions below are safe for the same reason.
        unsafe { meet_boxes(node, ray, last) }
    }

    // Without a prefetch, a batch over more triangles than the cache holds waits for them.
    #[inline(always)]
    fn prefetch<T>(items: &[T], first: usize, lines: usize) {
        let start = items.as_ptr().wrapping_add(first).cast::<[u8; 64]>();
        for line in 0..lines {
            // SAFETY: a prefetch does not access memory, wherever it points, and every processor with AVX2
            // has it.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line).cast()) };
        }
    }

    #[inline(always)]
    fn nearest(keys: __m128i) -> (u16, usize) {
        // SAFETY: see `meet_boxes`.
        let nearest = unsafe { nearest(keys) };
        let lane = (nearest >> 16) as usize;
        // SAFETY: above the key, the instruction gives the lane and zeros.
        unsafe { core::hint::assert_unchecked(lane < LANES) };
        (nearest as u16, lane)
    }

    #[inline(always)]
    fn any(keys: __m128i) -> bool {
        // SAFETY: see `meet_boxes`.
        unsafe { any(keys) }
    }

    #[inline(always)]
    fn without(keys: __m128i, lane: usize) -> __m128i {
        // SAFETY: see `meet_boxes`.
        unsafe { without(keys, lane) }
    }

    #[inline(always)]
    fn edges(leaf: &LeafRows) -> __m256 {
        // SAFETY: see `meet_boxes`.
        unsafe { edges(leaf) }
    }

    #[inline(always)]
    fn meet_triangles<Q: Query>(
        leaf: &LeafRows,
        ray: &LaneRay,
        edges: __m256,
        last: f32,
    ) -> Candidates {
        // SAFETY: see `meet_boxes`.
        unsafe { meet_triangles::<Q>(leaf, ray, edges, last) }
    }

    #[inline(always)]
    fn judge(triangle: &Triangle, ray: &LaneRay, last: f32) -> Verdict {
        // SAFETY: see `meet_boxes`.
        unsafe { judge(triangle, ray, last) }
    }
}

/// Prepares a ray that [`prepare`] leaves out.
#[cold]
#[inline(never)]
fn prepare_unusual(
    ray: &Ray,
    largest_coordinate: f32,
    may_hit: impl FnOnce() -> bool,
    prepared: &mut LaneRay,
) -> Arithmetic {
    Arithmetic::of(ray, largest_coordinate, may_hit, prepared)
}

#[inline]
#[target_feature(enable = "avx2")]
fn all(number: f32) -> __m256 {
    _mm256_set1_ps(number)
}

#[inline]
#[target_feature(enable = "avx2")]
fn load(row: &Row) -> __m256 {
    bytemuck::must_cast(*row)
}

#[inline]
#[target_feature(enable = "avx2")]
fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> __m128i {
    // Without `map`: its closure is not always inlined where the traversal is compiled for more than AVX2.
    meet_planes(ray, last, |axis| {
        let ([near, far], sides) = (ray.sides(axis), &sides_of(node)[axis]);
        [load(&sides[near]), load(&sides[far])]
    })
}

/// Tests eight boxes, as `portable::meet_planes` does.
#[inline]
#[target_feature(enable = "avx2")]
pub(crate) fn meet_planes(
    ray: &LaneRay,
    last: f32,
    planes: impl Fn(usize) -> [__m256; 2],
) -> __m128i {
    const NONE: u8 = 0x80;
    const UPPER: [[u8; 16]; 2] =
        [[2, 3, 6, 7, 10, 11, 14, 15, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE]; 2];
    let mut entry = _mm256_set1_ps(ray.t_min);
    let mut exit = _mm256_set1_ps(last);
    for axis in 0..3 {
        let origin = _mm256_set1_ps(ray.origin[axis]);
        let (enter, leave) = (_mm256_set1_ps(ray.enter[axis]), _mm256_set1_ps(ray.leave[axis]));
        let [near, far] = planes(axis);
        // Of a NaN and a number, these instructions return the second operand.
        entry = _mm256_max_ps(_mm256_mul_ps(_mm256_sub_ps(origin, near), enter), entry);
        exit = _mm256_min_ps(_mm256_mul_ps(_mm256_sub_ps(origin, far), leave), exit);
    }
    let exit = _mm256_add_ps(exit, _mm256_set1_ps(UNDERFLOW));
    let missed = _mm256_cmp_ps::<_CMP_GT_OQ>(entry, exit);
    // A comparison that holds gives ones, so the key of a box that is not met is `FAR`.
    let keys = _mm256_castps_si256(_mm256_or_ps(entry, missed));
    // The upper halves of the numbers, first within each half of the vector. With AVX-512, compilers make one
    // instruction of both.
    let keys = _mm256_shuffle_epi8(keys, bytemuck::must_cast(UPPER));
    _mm256_castsi256_si128(_mm256_permute4x64_epi64::<0b00_00_10_00>(keys))
}

/// Finds the lowest key (lower half of the result), and its lane (upper half).
#[inline]
#[target_feature(enable = "avx2")]
fn nearest(keys: __m128i) -> u32 {
    _mm_cvtsi128_si32(_mm_minpos_epu16(keys)) as u32
}

#[inline]
#[target_feature(enable = "avx2")]
fn any(keys: __m128i) -> bool {
    const { assert!(FAR == u16::MAX) };
    _mm_test_all_ones(keys) == 0
}

#[inline]
#[target_feature(enable = "avx2")]
fn without(keys: __m128i, lane: usize) -> __m128i {
    const MASKS: [[u16; LANES]; LANES] = {
        let mut masks = [[0; LANES]; LANES];
        let mut lane = 0;
        while lane < LANES {
            masks[lane][lane] = FAR;
            lane += 1;
        }
        masks
    };
    _mm_or_si128(keys, bytemuck::must_cast(MASKS[lane % LANES]))
}

#[inline]
#[target_feature(enable = "avx2")]
fn corners(leaf: &LeafRows) -> [[__m256; 3]; 3] {
    let corner = |row: usize| [load(&leaf[row]), load(&leaf[row + 1]), load(&leaf[row + 2])];
    [corner(0), corner(3), corner(6)]
}

#[inline]
#[target_feature(enable = "avx2")]
fn edges(leaf: &LeafRows) -> __m256 {
    longest_edges(corners(leaf))
}

/// The largest component of each triangle's edges at corner a.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn longest_edges([a, b, c]: [[__m256; 3]; 3]) -> __m256 {
    let length = |p, q| _mm256_andnot_ps(all(-0.0), _mm256_sub_ps(p, q));
    let larger = |p, q| _mm256_max_ps(p, q);
    let largest = |p: [__m256; 3]| {
        let [x, y, z] = [length(p[0], a[0]), length(p[1], a[1]), length(p[2], a[2])];
        larger(larger(x, y), z)
    };
    larger(largest(b), largest(c))
}

/// Filters eight triangles, in the phases of `portable`.
#[inline]
#[target_feature(enable = "avx2")]
fn meet_triangles<Q: Query>(
    leaf: &LeafRows,
    ray: &LaneRay,
    edges: __m256,
    last: f32,
) -> Candidates {
    meet_corners::<Q>(corners(leaf), ray, edges, last)
}

/// Filters eight triangles, given by their corners.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn meet_corners<Q: Query>(
    [p, b, c]: [[__m256; 3]; 3],
    ray: &LaneRay,
    edges: __m256,
    last: f32,
) -> Candidates {
    let sign = all(-0.0);
    let negated = |x| _mm256_xor_ps(sign, x);
    let abs = |x| _mm256_andnot_ps(sign, x);
    let plus = |x, y| _mm256_add_ps(x, y);
    let less = |x, y| _mm256_sub_ps(x, y);
    let times = |x, y| _mm256_mul_ps(x, y);
    let and = |x, y| _mm256_and_ps(x, y);
    let bits = |mask| _mm256_movemask_ps(mask) as u32;
    let dot = |a: [__m256; 3], b: [__m256; 3]| {
        plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))
    };
    let cross = |a: [__m256; 3], b: [__m256; 3]| {
        let minor = |i: usize, j: usize| less(times(a[i], b[j]), times(a[j], b[i]));
        [minor(1, 2), minor(2, 0), minor(0, 1)]
    };
    let minus =
        |a: [__m256; 3], b: [__m256; 3]| [less(a[0], b[0]), less(a[1], b[1]), less(a[2], b[2])];
    let below = |x, y| _mm256_cmp_ps::<_CMP_LT_OQ>(x, y);
    let above = |x, y| _mm256_cmp_ps::<_CMP_GT_OQ>(x, y);

    let d = [0, 1, 2].map(|axis| all(ray.direction[axis]));
    let a = minus(p, [0, 1, 2].map(|axis| all(ray.origin[axis])));
    let e1 = minus(b, p);
    let e2 = minus(c, p);
    let n = cross(e1, e2);
    let q = cross(d, a);
    let det = dot(d, n);
    let t = dot(a, n);
    let u = negated(dot(e2, q));
    let v = dot(e1, q);
    let w = less(less(det, u), v);

    let a = _mm256_max_ps(abs(a[0]), _mm256_max_ps(abs(a[1]), abs(a[2])));
    let underflow = all(ray.underflow());
    let sum = times(all(SUM * ray.reach), edges);
    let margin = plus(times(sum, plus(edges, plus(a, a))), underflow);
    let lowest = _mm256_min_ps(_mm256_min_ps(u, v), w);
    let highest = _mm256_max_ps(_mm256_max_ps(u, v), w);
    let mixed = and(below(lowest, negated(margin)), above(highest, margin));

    let size = abs(det);
    let along = _mm256_xor_ps(t, and(det, sign));
    let doubt = times(times(all(DISTANCE), edges), edges);
    let wider = times(doubt, all(ray.reach));
    let slack = plus(times(doubt, a), underflow);
    let (most, least) = (plus(along, slack), less(along, slack));
    let (largest, smallest) = (plus(size, wider), less(size, wider));
    let late = above(least, times(all(last + ROUNDED), largest));
    let early = below(most, times(all(ray.t_min - ROUNDED), smallest));
    let certain = above(size, plus(wider, underflow));
    let missed = _mm256_or_ps(mixed, and(certain, _mm256_or_ps(late, early)));
    let mut sure = 0;
    if Q::ANY {
        let alike = _mm256_or_ps(above(lowest, margin), below(highest, negated(margin)));
        let before_last = below(most, times(all(last), smallest));
        let behind_first = above(least, times(all(ray.t_min), largest));
        sure = bits(and(and(alike, certain), and(before_last, behind_first)));
    }
    Candidates { any: !bits(missed), sure }
}
