//! The lanes in AVX2: eight in one register.
//!
//! The same operations in the same order as `lanes`, which the compiler turns into much longer code.
//! The only `unsafe` of this crate is here and in the compact octree's `avx2`: calling functions compiled for
//! instructions that the processor may not have. [`Vectors`](crate::Vectors) can say that it has them only
//! after asking it. Worth about a third of the time of a query.
#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m128i, __m256, __m256i, _CMP_GT_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_cvtsi128_si32,
    _mm_minpos_epu16, _mm_or_si128, _mm_packus_epi32, _mm_prefetch, _mm256_add_ps, _mm256_and_ps,
    _mm256_andnot_ps, _mm256_castps_si256, _mm256_castsi256_si128, _mm256_cmp_ps,
    _mm256_extracti128_si256, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_or_ps, _mm256_set1_ps, _mm256_srli_epi32, _mm256_sub_ps, _mm256_xor_ps,
};

use super::lanes::{DISTANCE, EARLIER, FAR, LATER, LaneRay, Lanes, SUM, UNDERFLOW};
use super::walk::{InLanes, walk_each_in_lanes, walk_in_lanes};
use super::{LANES, Leaf, NODE_ROWS, Node, ROW_MASK, Row};
use crate::query::Query;

pub(in crate::indices) enum Avx2 {}

/// See `walk_in_lanes`.
#[inline]
pub(super) fn walk<T: InLanes<Avx2>, Q: Query>(tree: T, query: &mut Q) {
    // SAFETY: only called where `Vectors::has_avx2` is true, which `Vectors::detect` alone can make so,
    // after the processor and the system said that they have AVX2.
    unsafe { walk_with_avx2(tree, query) }
}

// A function of its own, so that its registers are not shared with those of the caller.
#[inline(never)]
#[target_feature(enable = "avx2")]
fn walk_with_avx2<T: InLanes<Avx2>, Q: Query>(tree: T, query: &mut Q) {
    walk_in_lanes::<Avx2, T, Q>(tree, query);
}

/// See `walk_each_in_lanes`.
#[inline]
pub(super) fn walk_each<T: InLanes<Avx2>, Q: Query>(
    tree: T,
    count: usize,
    start: impl Fn(usize) -> Option<Q>,
    finish: impl FnMut(usize, &Q),
) {
    // SAFETY: see `walk`.
    unsafe { walk_each_with_avx2(tree, count, start, finish) }
}

// A function of its own, so that its registers are not shared with those of the caller.
#[inline(never)]
#[target_feature(enable = "avx2")]
fn walk_each_with_avx2<T: InLanes<Avx2>, Q: Query>(
    tree: T,
    count: usize,
    start: impl Fn(usize) -> Option<Q>,
    finish: impl FnMut(usize, &Q),
) {
    walk_each_in_lanes::<Avx2, T, Q>(tree, count, start, finish);
}

impl Lanes for Avx2 {
    type Keys = __m128i;

    #[inline(always)]
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> __m128i {
        // SAFETY: only functions compiled for AVX2 walk with these lanes, here and in the compact octree; so below.
        unsafe { meet_boxes(node, ray, last) }
    }

    // Without it, a batch over more triangles than the cache holds waits for them.
    #[inline(always)]
    fn prefetch(rows: &[Row], link: u32) {
        let row = (link & ROW_MASK) as usize;
        for line in rows.get(row..row + NODE_ROWS as usize).unwrap_or(&[]).chunks_exact(2) {
            // SAFETY: a prefetch does not access memory, and every processor with AVX2 has it.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
        }
    }

    #[inline(always)]
    fn nearest(keys: __m128i) -> (u16, usize) {
        // SAFETY: see `meet_boxes`.
        let nearest = unsafe { nearest(keys) };
        (nearest as u16, (nearest >> 16 & 7) as usize)
    }

    #[inline(always)]
    fn without(keys: __m128i, lane: usize) -> __m128i {
        // SAFETY: see `meet_boxes`.
        unsafe { without(keys, lane) }
    }

    #[inline(always)]
    fn meet_triangles(leaf: &Leaf, ray: &LaneRay, edge: f32, last: f32) -> u32 {
        // SAFETY: see `meet_boxes`.
        unsafe { meet_triangles(leaf, ray, edge, last) }
    }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load(row: &Row) -> __m256 {
    bytemuck::must_cast(*row)
}

#[inline]
#[target_feature(enable = "avx2")]
fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> __m128i {
    meet_planes(ray, last, |axis, side| load(&node[2 * axis + side]))
}

/// As `lanes::meet_planes`.
#[inline]
#[target_feature(enable = "avx2")]
pub(in crate::indices) fn meet_planes(
    ray: &LaneRay,
    last: f32,
    plane: impl Fn(usize, usize) -> __m256,
) -> __m128i {
    let mut entry = _mm256_set1_ps(0.0);
    let mut exit = _mm256_set1_ps(f32::INFINITY);
    for axis in 0..3 {
        let sign = ray.signs[axis] as usize & 1;
        let near = plane(axis, sign);
        let far = plane(axis, 1 - sign);
        let origin = _mm256_set1_ps(ray.origin[axis]);
        let inverse = _mm256_set1_ps(ray.inverse[axis]);
        // Of a NaN and a number, these return the second operand.
        entry = _mm256_max_ps(_mm256_mul_ps(_mm256_sub_ps(near, origin), inverse), entry);
        exit = _mm256_min_ps(_mm256_mul_ps(_mm256_sub_ps(far, origin), inverse), exit);
    }
    let entry = _mm256_mul_ps(entry, _mm256_set1_ps(EARLIER));
    let entry = _mm256_max_ps(entry, _mm256_set1_ps(ray.t_min));
    let exit = _mm256_mul_ps(exit, _mm256_set1_ps(LATER));
    let exit = _mm256_min_ps(exit, _mm256_set1_ps(last));
    let exit = _mm256_add_ps(exit, _mm256_set1_ps(UNDERFLOW));
    // Where a comparison holds it gives ones: the key of a box that is not met is `FAR`.
    let missed = _mm256_cmp_ps::<_CMP_GT_OQ>(entry, exit);
    let keys = _mm256_castps_si256(_mm256_or_ps(entry, missed));
    let keys: __m256i = _mm256_srli_epi32::<16>(keys);
    _mm_packus_epi32(_mm256_castsi256_si128(keys), _mm256_extracti128_si256::<1>(keys))
}

/// The lowest key in the lower half, its lane in the upper.
#[inline]
#[target_feature(enable = "avx2")]
fn nearest(keys: __m128i) -> u32 {
    _mm_cvtsi128_si32(_mm_minpos_epu16(keys)) as u32
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
fn meet_triangles(leaf: &Leaf, ray: &LaneRay, edge: f32, last: f32) -> u32 {
    let all = |x: f32| _mm256_set1_ps(x);
    let sign = all(-0.0);
    let negated = |x| _mm256_xor_ps(sign, x);
    let abs = |x| _mm256_andnot_ps(sign, x);
    let plus = |x, y| _mm256_add_ps(x, y);
    let less = |x, y| _mm256_sub_ps(x, y);
    let times = |x, y| _mm256_mul_ps(x, y);
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
    let corner = |row: usize| [load(&leaf[row]), load(&leaf[row + 1]), load(&leaf[row + 2])];

    let sum = SUM * ray.reach * edge;
    let doubt = DISTANCE * edge * edge;
    let wider = doubt * ray.reach;
    let underflow = 4.0 * ray.underflow;

    let p = corner(0);
    let d = ray.direction.map(all);
    let a = minus(p, ray.origin.map(all));
    let e1 = minus(corner(3), p);
    let e2 = minus(corner(6), p);
    let n = cross(e1, e2);
    let q = cross(d, a);
    let det = dot(d, n);
    let t = dot(a, n);
    let u = negated(dot(e2, q));
    let v = dot(e1, q);
    let w = less(less(det, u), v);

    let a = _mm256_max_ps(abs(a[0]), _mm256_max_ps(abs(a[1]), abs(a[2])));
    let margin = plus(times(all(sum), plus(all(edge), plus(a, a))), all(underflow));
    let lowest = _mm256_min_ps(_mm256_min_ps(u, v), w);
    let highest = _mm256_max_ps(_mm256_max_ps(u, v), w);
    let mixed = _mm256_and_ps(below(lowest, negated(margin)), above(highest, margin));

    let size = abs(det);
    let along = _mm256_xor_ps(t, _mm256_and_ps(det, sign));
    let slack = plus(times(all(doubt), a), all(underflow));
    let late = above(less(along, slack), times(all(last), plus(size, all(wider))));
    let early = below(plus(along, slack), times(all(ray.t_min), less(size, all(wider))));
    let certain = above(size, all(wider + underflow));
    let missed = _mm256_or_ps(mixed, _mm256_and_ps(certain, _mm256_or_ps(late, early)));
    !(_mm256_movemask_ps(missed) as u32) & 0xff
}
