//! The kernel's `f64` filter in AVX2, with the kernel's bounds: for one ray and one triangle, or for four such pairs.
//!
//! It needs half the instructions of the kernel's own. The kernel decides what is left in doubt, so no answer depends
//! on where doubt begins.

use core::arch::x86_64::{
    __m128, __m256d, _CMP_GT_OQ, _mm_add_ps, _mm_cmpeq_ps, _mm_cmpgt_ps, _mm_cmplt_ps,
    _mm_movemask_ps, _mm_or_ps, _mm_set_ps, _mm_set1_ps, _mm_setzero_ps, _mm256_add_pd,
    _mm256_andnot_pd, _mm256_blend_pd, _mm256_cmp_pd, _mm256_cvtpd_ps, _mm256_cvtps_pd,
    _mm256_div_pd, _mm256_hadd_pd, _mm256_max_pd, _mm256_movemask_pd, _mm256_mul_pd,
    _mm256_permute_pd, _mm256_permute2f128_pd, _mm256_permute4x64_pd, _mm256_set_pd,
    _mm256_set1_pd, _mm256_sub_pd,
};

use bytemuck::{Pod, Zeroable};

use crate::Vec3;
use crate::geometry::kernel::{Approximate, Intersection, Verdict, Volumes, clamped};
use crate::geometry::{LaneRay, Triangle};
use crate::query::TriangleId;

/// Four pairs of a ray and a triangle, in lanes.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Quad {
    /// The coordinates of the triangles' corners a, b and c.
    pub corners: [[f32; 4]; 9],
    /// The triangles.
    pub ids: [TriangleId; 4],
    /// The caller's numbers of the rays.
    pub rays: [u32; 4],
    unused: [u32; 4],
}

impl Quad {
    /// Writes a pair to a lane.
    // Forced: the caller copies number by number from where the triangle lies.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn put(&mut self, lane: usize, (id, triangle): (TriangleId, Triangle), ray: u32) {
        let Triangle { a, b, c } = triangle;
        let numbers = [a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z];
        for (row, number) in self.corners.iter_mut().zip(numbers) {
            row[lane % 4] = number;
        }
        self.ids[lane % 4] = id;
        self.rays[lane % 4] = ray;
    }

    /// The triangle in a lane.
    pub fn triangle(&self, lane: usize) -> (TriangleId, Triangle) {
        let [ax, ay, az, bx, by, bz, cx, cy, cz] = self.corners.map(|row| row[lane % 4]);
        let (a, b, c) = (Vec3::new(ax, ay, az), Vec3::new(bx, by, bz), Vec3::new(cx, cy, cz));
        (self.ids[lane % 4], Triangle::new(a, b, c))
    }
}

/// Result of the filter; one bit for each pair.
pub(crate) struct Judged {
    /// The pairs that surely hit within the ray's interval.
    pub hits: u32,
    /// The pairs that the kernel has to decide.
    pub doubtful: u32,
    /// The parameters of the hits.
    pub t: [f32; 4],
    /// The weights of corner b.
    pub u: [f32; 4],
    /// The weights of corner c, before they are clamped.
    pub v: [f32; 4],
}

/// Filters four pairs. Hits count up to `last`.
#[inline]
#[target_feature(enable = "avx2")]
pub(crate) fn judge_four(quad: &Quad, rays: [&LaneRay; 4], last: [f32; 4]) -> Judged {
    const R: f64 = f64::EPSILON / 2.0;
    type QuadPoints = [__m256d; 3];
    let wide = |four: [f32; 4]| _mm256_cvtps_pd(bytemuck::must_cast(four));
    let all = |x: f64| _mm256_set1_pd(x);
    let plus = |x, y| _mm256_add_pd(x, y);
    let less = |x, y| _mm256_sub_pd(x, y);
    let times = |x, y| _mm256_mul_pd(x, y);
    let larger = |x, y| _mm256_max_pd(x, y);
    let abs = |x| _mm256_andnot_pd(all(-0.0), x);
    let minus =
        |a: QuadPoints, b: QuadPoints| [less(a[0], b[0]), less(a[1], b[1]), less(a[2], b[2])];
    let dot = |a: QuadPoints, b: QuadPoints| {
        plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))
    };
    let minor = |a: QuadPoints, b: QuadPoints, i: usize, j: usize| {
        less(times(a[i], b[j]), times(a[j], b[i]))
    };
    let cross =
        |a: QuadPoints, b: QuadPoints| [minor(a, b, 1, 2), minor(a, b, 2, 0), minor(a, b, 0, 1)];
    let largest = |a: QuadPoints| larger(larger(abs(a[0]), abs(a[1])), abs(a[2]));
    let above = |x, y| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(x, y)) as u32;
    let signs = |x| _mm256_movemask_pd(x) as u32;

    // 1. The volumes.
    let point = |row: usize| [0, 1, 2].map(|axis| wide(quad.corners[row + axis]));
    let (p, b, c) = (point(0), point(3), point(6));
    let of_rays = |axis: usize, of: fn(&LaneRay) -> &[f32; 4]| {
        wide([of(rays[0])[axis], of(rays[1])[axis], of(rays[2])[axis], of(rays[3])[axis]])
    };
    let origin = [
        of_rays(0, |ray| &ray.origin),
        of_rays(1, |ray| &ray.origin),
        of_rays(2, |ray| &ray.origin),
    ];
    let d = [
        of_rays(0, |ray| &ray.direction),
        of_rays(1, |ray| &ray.direction),
        of_rays(2, |ray| &ray.direction),
    ];
    let a = minus(p, origin);
    let (e1, e2) = (minus(b, p), minus(c, p));
    let n = cross(e1, e2);
    let (det, t) = (dot(d, n), dot(a, n));
    let u = dot(e2, cross(a, d));
    let v = dot(e1, cross(d, a));
    let w = less(less(det, u), v);

    // 2. The bounds on their errors.
    let size = largest(a);
    let edge = larger(largest(e1), largest(e2));
    let reach = wide([rays[0].reach, rays[1].reach, rays[2].reach, rays[3].reach]);
    let reach_edge = times(reach, edge);
    let det_error = times(times(reach_edge, edge), all(48.0 * R));
    let t_error = times(times(times(size, edge), edge), all(56.0 * R));
    let error = times(times(reach_edge, size), all(48.0 * R));
    let w_error = times(times(reach_edge, plus(edge, plus(size, size))), all(64.0 * R));

    // 3. The signs of the weights. Opposite: missed.
    let (u_known, v_known, w_known) =
        (above(abs(u), error), above(abs(v), error), above(abs(w), w_error));
    let (u_sign, v_sign, w_sign) = (signs(u), signs(v), signs(w));
    let negative = u_known & u_sign | v_known & v_sign | w_known & w_sign;
    let positive = u_known & !u_sign | v_known & !v_sign | w_known & !w_sign;
    let det_known = above(abs(det), times(det_error, all(1e4)));
    let has_extent = above(edge, all(0.0));
    let mut missed = negative & positive | !has_extent;

    // 4. The quotients, as in the kernel's `Divisor`.
    let inverse = _mm256_div_pd(all(1.0), det);
    let scale = times(abs(inverse), all(1.001));
    let quotient = |volume, error| -> (__m128, __m128) {
        let value = times(volume, inverse);
        let size = abs(value);
        let error = plus(
            times(plus(error, times(size, det_error)), scale),
            times(size, all(4.0 * f64::EPSILON)),
        );
        (_mm256_cvtpd_ps(less(value, error)), _mm256_cvtpd_ps(plus(value, error)))
    };
    let (t_low, t_high) = quotient(t, t_error);
    let (u_low, u_high) = quotient(u, error);
    let (v_low, v_high) = quotient(v, error);
    let bits = |mask: __m128| _mm_movemask_ps(mask) as u32;
    let t_min: __m128 =
        bytemuck::must_cast([rays[0].t_min, rays[1].t_min, rays[2].t_min, rays[3].t_min]);
    let outside =
        _mm_or_ps(_mm_cmplt_ps(t_high, t_min), _mm_cmpgt_ps(t_low, bytemuck::must_cast(last)));
    missed |= bits(outside) & det_known;
    let same = bits(_mm_cmpeq_ps(t_low, t_high))
        & bits(_mm_cmpeq_ps(u_low, u_high))
        & bits(_mm_cmpeq_ps(v_low, v_high))
        & bits(_mm_cmplt_ps(t_low, _mm_set1_ps(f32::INFINITY)));
    let hits = u_known & v_known & w_known & det_known & same & !missed & 0b1111;
    let doubtful = !missed & !hits & 0b1111;
    // Never -0.0.
    let positive = |x: __m128| bytemuck::must_cast(_mm_add_ps(x, _mm_setzero_ps()));
    Judged { hits, doubtful, t: positive(t_low), u: positive(u_low), v: positive(v_low) }
}

/// Filters one pair, its components and its volumes in lanes. Hits count up to `last`.
///
/// ```text
/// lane:  0          1      2      3
///        det * 1    t      u      v       volumes; w = det - u - v
/// ```
/// 1. The volumes, as dot products of `n = e1 x e2` and of `q = a x d`. All components of a cross product are computed
///    at once, in the order z, x, y; its factor in a dot product is brought into the same order meanwhile.
/// 2. The bounds on their errors.
/// 3. The signs of the weights. In doubt: the volumes go to the kernel. Opposite: missed.
/// 4. The quotients `t`, `u`, `v`, each between two `f32`. Outside the interval: missed. Not the same `f32`: in doubt.
///
/// # What lost
/// Each volume as a triple product in a lane of its own, with no sums across lanes: single rays are 0 to 7% slower.
/// Compilers gather the corners from the rows, or write them to the stack and read them as vectors.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn judge(triangle: &Triangle, ray: &LaneRay, last: f32) -> Verdict {
    const R: f64 = f64::EPSILON / 2.0;
    const DET_U_V: i32 = 0b1101;
    let wide = |four: [f32; 4]| _mm256_cvtps_pd(bytemuck::must_cast(four));
    let corner = |corner: Vec3| _mm256_cvtps_pd(_mm_set_ps(0.0, corner.z, corner.y, corner.x));
    let all = |x: f64| _mm256_set1_pd(x);
    let plus = |x, y| _mm256_add_pd(x, y);
    let less = |x, y| _mm256_sub_pd(x, y);
    let times = |x, y| _mm256_mul_pd(x, y);
    let abs = |x| _mm256_andnot_pd(all(-0.0), x);
    let y_z_x = |x| _mm256_permute4x64_pd::<0b11_00_10_01>(x);
    // The cross product, its components in the order z, x, y.
    let cross = |p, q| less(times(p, y_z_x(q)), times(y_z_x(p), q));
    let z_x_y = |x| _mm256_permute4x64_pd::<0b11_01_00_10>(x);

    // 1. The volumes.
    let p = corner(triangle.a);
    let d = wide(ray.direction);
    let a = less(p, wide(ray.origin));
    let e1 = less(corner(triangle.b), p);
    let e2 = less(corner(triangle.c), p);
    let n = cross(e1, e2);
    let q = cross(a, d);
    // Here q is a x d, in `portable` d x a; so u = e2 . q and v = -e1 . q.
    let det_t = _mm256_hadd_pd(times(z_x_y(d), n), times(z_x_y(a), n));
    let u_v = _mm256_hadd_pd(times(z_x_y(e2), q), times(z_x_y(less(all(0.0), e1)), q));
    let values = plus(
        _mm256_permute2f128_pd::<0x20>(det_t, u_v),
        _mm256_permute2f128_pd::<0x31>(det_t, u_v),
    );

    // 2. The bounds: the largest components of a, twice, and of the edges, twice.
    let (size, edge) = (abs(a), _mm256_max_pd(abs(e1), abs(e2)));
    let largest = _mm256_max_pd(
        _mm256_permute2f128_pd::<0x20>(size, edge),
        _mm256_permute2f128_pd::<0x31>(size, edge),
    );
    let largest = _mm256_max_pd(largest, _mm256_permute_pd::<0b0101>(largest));
    let size = _mm256_permute4x64_pd::<0b00_00_00_00>(largest);
    let edge = _mm256_permute4x64_pd::<0b10_10_10_10>(largest);
    let reach = all(f64::from(ray.reach));
    // 48 R D E E, 56 R S E E, 48 R D E S, 48 R D E S
    let errors = times(
        times(_mm256_blend_pd::<0b1110>(edge, size), _mm256_blend_pd::<0b0010>(reach, edge)),
        times(edge, _mm256_set_pd(48.0 * R, 48.0 * R, 56.0 * R, 48.0 * R)),
    );

    // 3. The signs of det, u and v, and that of w.
    let enough = times(errors, _mm256_set_pd(1.0, 1.0, 1.0, 1e4));
    let certain = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(abs(values), enough));
    let signs = _mm256_movemask_pd(values) & DET_U_V;
    let [det, t, u, v]: [f64; 4] = bytemuck::must_cast(values);
    let [edge, _, size, _]: [f64; 4] = bytemuck::must_cast(_mm256_blend_pd::<0b1100>(edge, size));
    let w = det - u - v;
    let w_error = 64.0 * R * f64::from(ray.reach) * edge * (edge + 2.0 * size);
    if certain & DET_U_V != DET_U_V || w.abs() <= w_error {
        if edge == 0.0 {
            return Verdict::Missed;
        }
        let errors: [f64; 4] = bytemuck::must_cast(errors);
        let values: [f64; 4] = bytemuck::must_cast(values);
        let volume = |lane: usize| Approximate { value: values[lane], error: errors[lane] };
        return Verdict::Doubtful(Volumes {
            det: volume(0),
            t: volume(1),
            u: volume(2),
            v: volume(3),
            w: Approximate { value: w, error: w_error },
        });
    }
    if !(signs == 0 && w > 0.0 || signs == DET_U_V && w < 0.0) {
        return Verdict::Missed;
    }

    // 4. The quotients, as in the kernel's `Divisor`.
    let inverse_det = 1.0 / det;
    let inverse = all(inverse_det);
    let quotients = times(values, inverse);
    let sizes = abs(quotients);
    let det_error = _mm256_permute4x64_pd::<0>(errors);
    let error = plus(
        times(plus(errors, times(sizes, det_error)), times(abs(inverse), all(1.001))),
        times(sizes, all(4.0 * f64::EPSILON)),
    );
    let low = _mm256_cvtpd_ps(less(quotients, error));
    let high = _mm256_cvtpd_ps(plus(quotients, error));
    let same = _mm_movemask_ps(_mm_cmpeq_ps(low, high));
    let ([_, low, ..], [_, high, ..]): ([f32; 4], [f32; 4]) =
        (bytemuck::must_cast(low), bytemuck::must_cast(high));
    // Where both bounds are one `f32`, so is what lies between them. Never -0.0.
    let rounded = _mm_add_ps(_mm256_cvtpd_ps(quotients), _mm_set1_ps(0.0));
    let [_, _, u, v]: [f32; 4] = bytemuck::must_cast(rounded);
    // By itself, because the next child waits for it.
    let t = (t * inverse_det) as f32 + 0.0;
    if high < ray.t_min || low > last {
        return Verdict::Missed;
    }
    if same & 0b1110 != 0b1110 || !t.is_finite() {
        return Verdict::InDoubt;
    }
    Verdict::Hit(Intersection { t, u, v: clamped(u, v) })
}
