//! The leaf test for processors with AVX2: up to eight triangles at once, and the survivors in four lanes of `f64`.
//!
//! `unsafe` here is as in [`avx2`](super::avx2).
#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m256, _mm256_permute2f128_ps, _mm256_set_ps, _mm256_shuffle_ps, _mm256_unpackhi_ps,
    _mm256_unpacklo_ps,
};
use core::borrow::Borrow;
use core::ops::ControlFlow;

use super::avx2::{Avx2, longest_edges, meet_corners};
use super::candidates::decide_each;
use super::lanes::LANES;
use super::leaf_test::{four_of, meet_four};
use crate::geometry::{Candidates, LaneRay, Triangle};
use crate::input::{Mesh, SimdLevel};
use crate::query::{Query, TriangleId};

/// Shows a query the triangles of a mesh that `ids` names; `None` if the processor has no AVX2.
#[inline]
pub(super) fn test<Q: Query>(
    level: SimdLevel,
    mesh: Mesh<'_>,
    ids: &[u32],
    ray: &LaneRay,
    query: &mut Q,
) -> Option<ControlFlow<()>> {
    if !level.has_avx2() {
        return None;
    }
    // SAFETY: `SimdLevel::detect` alone can make this true, after the processor and the system said that they have
    // AVX2.
    Some(unsafe {
        match mesh {
            // By reference: copying every triangle would take longer.
            Mesh::Triangles(triangles) => {
                test_with(|id| triangles.get(id as usize), ids, ray, query)
            }
            Mesh::Indexed { .. } => test_with(|id| mesh.get(id), ids, ray, query),
        }
    })
}

/// Tests up to eight triangles at a time.
#[inline(never)]
#[target_feature(enable = "avx2")]
fn test_with<T: Borrow<Triangle>, Q: Query>(
    get: impl Fn(u32) -> Option<T>,
    ids: &[u32],
    ray: &LaneRay,
    query: &mut Q,
) -> ControlFlow<()> {
    for ids in ids.chunks(LANES) {
        let last = query.last_t();
        let met = if ids.len() <= 4 {
            let Some(four) = four_of(&get, ids) else { continue };
            meet_four::<Q>(four.each_ref().map(Borrow::borrow), ray, last)
        } else {
            let upper = ids.get(4..).unwrap_or(&[]);
            let (Some(lower), Some(upper)) = (four_of(&get, ids), four_of(&get, upper)) else {
                continue;
            };
            let [p, q, r, s] = lower.each_ref().map(Borrow::borrow);
            let [t, u, v, w] = upper.each_ref().map(Borrow::borrow);
            meet_eight::<Q>([p, q, r, s, t, u, v, w], ray, last)
        };
        let lanes = met.within((1 << ids.len()) - 1).of(query)?;
        decide_each::<Avx2, Q>(lanes, ray, query, |lane| {
            let id = ids.get(lane).copied().unwrap_or(u32::MAX);
            (TriangleId(id), get(id).map_or(Triangle::default(), |triangle| *triangle.borrow()))
        })?;
    }
    ControlFlow::Continue(())
}

/// Filters eight triangles.
#[inline]
#[target_feature(enable = "avx2")]
fn meet_eight<Q: Query>(eight: [&Triangle; 8], ray: &LaneRay, last: f32) -> Candidates {
    let numbers: [&[f32; 9]; 8] = eight.map(bytemuck::must_cast_ref);
    // 1. Transpose the first eight numbers of each triangle.
    let row = |of: usize| -> __m256 {
        let [a, b, c, d, e, f, g, h, _] = *numbers[of % 8];
        bytemuck::must_cast([a, b, c, d, e, f, g, h])
    };
    let low = |a, b| _mm256_unpacklo_ps(a, b);
    let high = |a, b| _mm256_unpackhi_ps(a, b);
    let (r0, r1, r2, r3) = (row(0), row(1), row(2), row(3));
    let (r4, r5, r6, r7) = (row(4), row(5), row(6), row(7));
    let (t0, t1, t2, t3) = (low(r0, r1), high(r0, r1), low(r2, r3), high(r2, r3));
    let (t4, t5, t6, t7) = (low(r4, r5), high(r4, r5), low(r6, r7), high(r6, r7));
    let even = |a, b| _mm256_shuffle_ps::<0b01_00_01_00>(a, b);
    let odd = |a, b| _mm256_shuffle_ps::<0b11_10_11_10>(a, b);
    let (s0, s1, s2, s3) = (even(t0, t2), odd(t0, t2), even(t1, t3), odd(t1, t3));
    let (s4, s5, s6, s7) = (even(t4, t6), odd(t4, t6), even(t5, t7), odd(t5, t7));
    let lower = |a, b| _mm256_permute2f128_ps::<0x20>(a, b);
    let upper = |a, b| _mm256_permute2f128_ps::<0x31>(a, b);
    // 2. The last number of each.
    let last_number = |of: usize| numbers[of % 8][8];
    let z = _mm256_set_ps(
        last_number(7),
        last_number(6),
        last_number(5),
        last_number(4),
        last_number(3),
        last_number(2),
        last_number(1),
        last_number(0),
    );
    let corners = [
        [lower(s0, s4), lower(s1, s5), lower(s2, s6)],
        [lower(s3, s7), upper(s0, s4), upper(s1, s5)],
        [upper(s2, s6), upper(s3, s7), z],
    ];
    meet_corners::<Q>(corners, ray, longest_edges(corners), last)
}
