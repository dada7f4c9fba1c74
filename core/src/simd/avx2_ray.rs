//! Preparation of an ordinary ray in AVX2: the operations of [`LaneRay::of`], with a third of its instructions.

use core::arch::x86_64::{
    __m128, _mm_and_ps, _mm_cmpge_ps, _mm_cmpgt_ps, _mm_cmple_ps, _mm_div_ps, _mm_max_ps,
    _mm_movehl_ps, _mm_movemask_ps, _mm_mul_ps, _mm_set1_ps, _mm_setzero_ps, _mm_shuffle_ps,
};

use crate::geometry::{
    EARLIER, LATER, LEAST_DIRECTION, LaneRay, MOST_COORDINATE, MOST_DIRECTION, Ray,
};

/// Prepares a ray for a scene whose coordinates lanes can take. False, and nothing written, for a ray that lanes cannot
/// take, or that runs along an axis or a plane across one.
///
/// It is prepared in place: what a function returns may be copied in wider vectors than it was written in, and the
/// processor waits for that.
#[inline]
#[target_feature(enable = "avx2")]
pub(crate) fn prepare(ray: &Ray, prepared: &mut LaneRay) -> bool {
    const ABS: u32 = !(1 << 31);
    let numbers: &[f32; 8] = bytemuck::must_cast_ref(ray);
    let four = |at: usize| -> __m128 {
        bytemuck::must_cast(numbers[at..].first_chunk::<4>().copied().unwrap_or_default())
    };
    let vector: __m128 = bytemuck::must_cast([!0, !0, !0, 0_u32]);
    let abs = |x| _mm_and_ps(x, bytemuck::must_cast([ABS; 4]));

    // 1. Compare: each component of the direction, and, in the fourth lane, t_min.
    let (origin, direction) = (_mm_and_ps(four(0), vector), _mm_and_ps(four(3), vector));
    let sizes = _mm_and_ps(four(3), bytemuck::must_cast([ABS, ABS, ABS, !0]));
    let [least, most] = [[LEAST_DIRECTION, 0.0], [MOST_DIRECTION, f32::INFINITY]]
        .map(|[d, t]| -> __m128 { bytemuck::must_cast([d, d, d, t]) });
    let tame = _mm_and_ps(_mm_cmpge_ps(sizes, least), _mm_cmple_ps(sizes, most));
    let near = _mm_cmple_ps(abs(origin), _mm_set1_ps(MOST_COORDINATE));
    if _mm_movemask_ps(_mm_and_ps(tame, near)) != 0b1111 {
        return false;
    }

    // 2. Compute what `LaneRay::of` does.
    let inverse = _mm_div_ps(_mm_set1_ps(-1.0), direction);
    let swap = _mm_and_ps(
        _mm_cmpgt_ps(inverse, _mm_setzero_ps()),
        _mm_set1_ps(f32::from_bits(0x0202_0202)),
    );
    let y = _mm_shuffle_ps::<0b01_01_01_01>(sizes, sizes);
    let reach = _mm_max_ps(_mm_max_ps(sizes, y), _mm_movehl_ps(sizes, sizes));
    let [reach, ..]: [f32; 4] = bytemuck::must_cast(reach);
    prepared.origin = bytemuck::must_cast(origin);
    prepared.direction = bytemuck::must_cast(direction);
    prepared.enter = bytemuck::must_cast(_mm_mul_ps(inverse, _mm_set1_ps(EARLIER)));
    prepared.leave = bytemuck::must_cast(_mm_mul_ps(inverse, _mm_set1_ps(LATER)));
    prepared.swap = bytemuck::must_cast(swap);
    prepared.reach = reach;
    prepared.t_min = ray.t_min();
    true
}
