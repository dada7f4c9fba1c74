//! The lanes in AVX2: eight in one register.
//!
//! The same operations in the same order as `lanes`, which the compiler turns into much longer code.
//! The only `unsafe` of this crate is here: calling functions compiled for instructions that the
//! processor may not have. [`Vectors`](crate::Vectors) can say that it has them only after asking it.
//! Worth about a third of the time of a query.
#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m256, _CMP_GT_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_and_ps, _mm256_andnot_ps,
    _mm256_blendv_ps, _mm256_cmp_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps,
    _mm256_mul_ps, _mm256_or_ps, _mm256_set1_ps, _mm256_sub_ps, _mm256_xor_ps,
};
use core::ops::ControlFlow;

use super::lanes::{LaneRay, UNDERFLOW};
use super::walk::{Lanes, walk_in_lanes};
use super::{LANES, Row};
use crate::query::Query;

enum Avx2 {}

/// See `walk_in_lanes`.
#[inline]
pub(super) fn walk<Q: Query>(
    rows: &[Row],
    root: u32,
    ray: &LaneRay,
    query: &mut Q,
) -> ControlFlow<()> {
    // SAFETY: only called where `Vectors::has_avx2` is true, which `Vectors::detect` alone can make so,
    // after the processor and the system said that they have AVX2.
    unsafe { walk_with_avx2(rows, root, ray, query) }
}

#[target_feature(enable = "avx2")]
fn walk_with_avx2<Q: Query>(
    rows: &[Row],
    root: u32,
    ray: &LaneRay,
    query: &mut Q,
) -> ControlFlow<()> {
    walk_in_lanes::<Avx2, Q>(rows, root, ray, query)
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn meet_boxes(node: &[Row; 7], ray: &LaneRay, last: f32) -> (u32, [f32; LANES]) {
        // SAFETY: only `walk_with_avx2` walks with these lanes.
        unsafe { meet_boxes(node, ray, last) }
    }

    #[inline(always)]
    fn meet_triangles(leaf: &[Row; 10], ray: &LaneRay, last: f32) -> u32 {
        // SAFETY: only `walk_with_avx2` walks with these lanes.
        unsafe { meet_triangles(leaf, ray, last) }
    }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load(row: &Row) -> __m256 {
    bytemuck::must_cast(*row)
}

#[inline]
#[target_feature(enable = "avx2")]
fn meet_boxes(node: &[Row; 7], ray: &LaneRay, last: f32) -> (u32, [f32; LANES]) {
    let mut entry = _mm256_set1_ps(ray.t_min);
    let mut exit = _mm256_set1_ps(last);
    for axis in 0..3 {
        let near = load(&node[ray.entry_row[axis] % 6]);
        let far = load(&node[ray.exit_row[axis] % 6]);
        let origin = _mm256_set1_ps(ray.origin[axis]);
        let t = _mm256_mul_ps(_mm256_sub_ps(near, origin), _mm256_set1_ps(ray.entry_inverse[axis]));
        // Of a NaN and a number, these return the second operand.
        entry = _mm256_max_ps(t, entry);
        let t = _mm256_mul_ps(_mm256_sub_ps(far, origin), _mm256_set1_ps(ray.exit_inverse[axis]));
        exit = _mm256_min_ps(t, exit);
    }
    let exit = _mm256_add_ps(exit, _mm256_set1_ps(UNDERFLOW));
    let met = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entry, exit));
    (met as u32, bytemuck::must_cast(entry))
}

#[inline]
#[target_feature(enable = "avx2")]
fn meet_triangles(leaf: &[Row; 10], ray: &LaneRay, last: f32) -> u32 {
    const R: f32 = f32::EPSILON / 2.0;
    let all = |x: f32| _mm256_set1_ps(x);
    let sign = all(-0.0);
    let abs = |x| _mm256_andnot_ps(sign, x);
    let negated = |x| _mm256_xor_ps(sign, x);
    let dot = |a: [__m256; 3], b: [__m256; 3]| {
        let xy = _mm256_add_ps(_mm256_mul_ps(a[0], b[0]), _mm256_mul_ps(a[1], b[1]));
        _mm256_add_ps(xy, _mm256_mul_ps(a[2], b[2]))
    };
    let cross = |a: [__m256; 3], b: [__m256; 3]| {
        let minor = |i: usize, j: usize| {
            _mm256_sub_ps(_mm256_mul_ps(a[i], b[j]), _mm256_mul_ps(a[j], b[i]))
        };
        [minor(1, 2), minor(2, 0), minor(0, 1)]
    };
    let minus = |a: [__m256; 3], b: [__m256; 3]| {
        [_mm256_sub_ps(a[0], b[0]), _mm256_sub_ps(a[1], b[1]), _mm256_sub_ps(a[2], b[2])]
    };
    let largest = |a: [__m256; 3]| _mm256_max_ps(abs(a[0]), _mm256_max_ps(abs(a[1]), abs(a[2])));

    let corner = |row: usize| [load(&leaf[row]), load(&leaf[row + 1]), load(&leaf[row + 2])];
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
    let w = _mm256_sub_ps(_mm256_sub_ps(det, u), v);

    let times = |x, y| _mm256_mul_ps(x, y);
    let plus = |x, y| _mm256_add_ps(x, y);
    let less = |x, y| _mm256_cmp_ps::<_CMP_LT_OQ>(x, y);
    let more = |x, y| _mm256_cmp_ps::<_CMP_GT_OQ>(x, y);
    let any = |x, y, z| _mm256_or_ps(_mm256_or_ps(x, y), z);
    let a_max = largest(a);
    let e_max = _mm256_max_ps(largest(e1), largest(e2));
    let de = times(all(ray.reach), e_max);
    let underflow = UNDERFLOW * if ray.reach > 1.0 { ray.reach } else { 1.0 };
    let margin = plus(times(times(all(48.0 * R), de), a_max), all(underflow));
    let w_margin = plus(
        times(times(all(64.0 * R), de), plus(e_max, times(all(2.0), a_max))),
        all(4.0 * underflow),
    );
    let negative =
        any(less(u, negated(margin)), less(v, negated(margin)), less(w, negated(w_margin)));
    let positive = any(more(u, margin), more(v, margin), more(w, w_margin));

    let along = _mm256_blendv_ps(t, negated(t), less(det, all(0.0)));
    let size = abs(det);
    let doubt = times(times(all(80.0 * R), e_max), e_max);
    let late = more(
        along,
        plus(
            plus(
                times(all(last), size),
                times(doubt, plus(a_max, times(all(ray.reach), all(last)))),
            ),
            all(4.0 * underflow),
        ),
    );
    let early = less(
        along,
        _mm256_sub_ps(
            _mm256_sub_ps(
                times(all(ray.t_min), size),
                times(doubt, plus(a_max, times(all(ray.reach), all(ray.t_min)))),
            ),
            all(4.0 * underflow),
        ),
    );
    let certain = more(size, plus(times(times(all(48.0 * R), de), e_max), all(underflow)));
    let missed = _mm256_or_ps(
        _mm256_and_ps(negative, positive),
        _mm256_and_ps(certain, _mm256_or_ps(late, early)),
    );
    !(_mm256_movemask_ps(missed) as u32) & 0xff
}
