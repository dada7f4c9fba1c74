//! Unpacking in AVX2: the same operations in the same order as in `views`.
//!
//! `unsafe` here is calling functions that are compiled for instructions which the processor may not have; see
//! [`wide`](crate::indices::wide).
#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m128i, __m256, __m256i, _mm_castpd_ps, _mm_or_si128, _mm_set_pd, _mm256_add_ps,
    _mm256_and_si256, _mm256_blendv_epi8, _mm256_blendv_ps, _mm256_castsi256_ps,
    _mm256_cmpgt_epi32, _mm256_cvtepi32_ps, _mm256_cvtepu16_epi32, _mm256_mul_ps,
    _mm256_permutevar8x32_ps, _mm256_set_m128, _mm256_set1_epi32, _mm256_set1_ps,
    _mm256_setzero_ps, _mm256_shuffle_epi8, _mm256_shuffle_ps, _mm256_slli_epi32,
    _mm256_srli_epi32, _mm256_srlv_epi32, _mm256_unpackhi_ps, _mm256_unpacklo_ps, _mm256_xor_si256,
};

use super::views::{FewBoxes, Known, UNUSED, Unpack};
use super::{CHUNK_HEAD, Chunk, QuantisedNode, vertex_count};
use crate::Vec3;
use crate::geometry::Triangle;
use crate::geometry::{Candidates, LaneRay};
use crate::indices::wide::rows::{LANES, LeafRows, Row};
use crate::input::Mesh;
use crate::query::Query;
use crate::simd::avx2::meet_planes;
use crate::simd::{Avx2, Lanes};

impl Unpack for Avx2 {
    #[inline(always)]
    fn meet_node(node: &QuantisedNode, ray: &LaneRay, last: f32) -> __m128i {
        // SAFETY: only traversals compiled for AVX2 use these lanes. The calls below are safe for the same reason.
        unsafe { meet_node(node, ray, last) }
    }

    #[inline(always)]
    fn unpack(chunk: &Chunk) -> LeafRows {
        // SAFETY: see `meet_node`.
        unsafe { unpack(chunk) }
    }

    #[inline(always)]
    fn meet_few(boxes: &FewBoxes<'_>, ray: &LaneRay, last: f32) -> __m128i {
        // SAFETY: see `meet_node`.
        unsafe { meet_few(boxes, ray, last) }
    }

    #[inline(always)]
    fn meet_known<Q: Query>(known: &Known<'_>, ray: &LaneRay, last: f32) -> Candidates {
        // SAFETY: see `meet_node`.
        unsafe { meet_known::<Q>(known, ray, last) }
    }
}

/// Decodes the planes of eight quanta.
#[inline]
#[target_feature(enable = "avx2")]
fn planes(quanta: __m256i, anchor: f32, step: f32) -> __m256 {
    let distance = _mm256_mul_ps(_mm256_cvtepi32_ps(quanta), _mm256_set1_ps(step));
    _mm256_add_ps(distance, _mm256_set1_ps(anchor))
}

#[inline]
#[target_feature(enable = "avx2")]
fn meet_node(node: &QuantisedNode, ray: &LaneRay, last: f32) -> __m128i {
    meet_planes(ray, last, |axis| {
        let (anchor, step) = (node.anchor[axis % 3], node.step[axis % 3]);
        let side = |side: usize| {
            let quanta = bytemuck::must_cast(node.planes[axis % 3][side]);
            planes(_mm256_cvtepu16_epi32(quanta), anchor, step)
        };
        let [near, far] = ray.sides(axis);
        [side(near), side(far)]
    })
}

/// Identity order of the bytes in each half of a vector.
const BYTES: [[u8; 16]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]; 2];

#[inline]
#[target_feature(enable = "avx2")]
fn meet_few(boxes: &FewBoxes<'_>, ray: &LaneRay, last: f32) -> __m128i {
    let keys = meet_planes(ray, last, |axis| {
        let sides: __m256i = bytemuck::must_cast(*boxes.sides[axis % 3]);
        let order = _mm256_set1_epi32(ray.swap[axis].cast_signed());
        let sides = _mm256_shuffle_epi8(sides, _mm256_xor_si256(order, bytemuck::must_cast(BYTES)));
        let near = _mm256_and_si256(sides, _mm256_set1_epi32(0xffff));
        let far = _mm256_srli_epi32::<16>(sides);
        let (anchor, step) = (boxes.anchor[axis % 3], boxes.step[axis % 3]);
        [planes(near, anchor, step), planes(far, anchor, step)]
    });
    _mm_or_si128(keys, bytemuck::must_cast(UNUSED[boxes.last_lane % LANES]))
}

#[inline]
#[target_feature(enable = "avx2")]
fn meet_known<Q: Query>(known: &Known<'_>, ray: &LaneRay, last: f32) -> Candidates {
    let Known { triangles, ids, last_lane } = *known;
    // Unused lanes get the first triangle again.
    let used = _mm256_set1_epi32((last_lane as u32).cast_signed());
    let unused = _mm256_cmpgt_epi32(bytemuck::must_cast([0, 1, 2, 3, 4, 5, 6, 7]), used);
    let first = _mm256_set1_epi32(ids[0].cast_signed());
    let ids: Row =
        bytemuck::must_cast(_mm256_blendv_epi8(bytemuck::must_cast(*ids), first, unused));
    let leaf = match triangles {
        Mesh::Triangles(triangles) => gather_triangles(triangles, &ids).unwrap_or_default(),
        Mesh::Indexed { vertices, corners } => gather_corners(vertices, corners, &ids),
    };
    Avx2::meet_triangles::<Q>(&leaf, ray, Avx2::edges(&leaf), last)
}

/// Transposes two 4 x 4 matrices: lanes 0 to 3 of the four vectors are one, lanes 4 to 7 the other.
#[inline]
#[target_feature(enable = "avx2")]
fn transposed([a, b, c, d]: [__m256; 4]) -> [Row; 4] {
    let pairs = |x, y| (_mm256_unpacklo_ps(x, y), _mm256_unpackhi_ps(x, y));
    let ((ab_01, ab_23), (cd_01, cd_23)) = (pairs(a, b), pairs(c, d));
    [
        _mm256_shuffle_ps::<0b01_00_01_00>(ab_01, cd_01),
        _mm256_shuffle_ps::<0b11_10_11_10>(ab_01, cd_01),
        _mm256_shuffle_ps::<0b01_00_01_00>(ab_23, cd_23),
        _mm256_shuffle_ps::<0b11_10_11_10>(ab_23, cd_23),
    ]
    .map(bytemuck::must_cast)
}

#[inline]
#[target_feature(enable = "avx2")]
fn gather_triangles(triangles: &[Triangle], ids: &Row) -> Option<LeafRows> {
    let mut halves = [[_mm256_setzero_ps(); 4]; 2];
    let mut last = [0.0; LANES];
    for lane in 0..4 {
        let at = |lane: usize| -> Option<&[f32; 9]> {
            triangles.get(ids[lane] as usize).map(bytemuck::must_cast_ref)
        };
        let (&[x0, x1, x2, x3, x4, x5, x6, x7, x8], &[y0, y1, y2, y3, y4, y5, y6, y7, y8]) =
            (at(lane)?, at(lane + 4)?);
        let both = |x: [f32; 4], y: [f32; 4]| {
            _mm256_set_m128(bytemuck::must_cast(y), bytemuck::must_cast(x))
        };
        halves[0][lane] = both([x0, x1, x2, x3], [y0, y1, y2, y3]);
        halves[1][lane] = both([x4, x5, x6, x7], [y4, y5, y6, y7]);
        last[lane] = x8;
        last[lane + 4] = y8;
    }
    let ([ax, ay, az, bx], [by, bz, cx, cy]) = (transposed(halves[0]), transposed(halves[1]));
    Some([ax, ay, az, bx, by, bz, cx, cy, bytemuck::must_cast(last), Row::default()])
}

#[inline]
#[target_feature(enable = "avx2")]
fn gather_corners(vertices: &[Vec3], corners: &[[u32; 3]], ids: &Row) -> LeafRows {
    // A vertex that does not exist is replaced, not refused: with a branch for it, the compiler takes all branches
    // before any reads, and keeps the indices of all corners in memory until then. That is a tenth of the instructions
    // of a leaf.
    //
    // A vertex is read as x, y, y, z: two reads, neither of which goes beyond the last vertex.
    let vertex = |index: u32| {
        let vertex = vertices.get(index as usize).unwrap_or(&Vec3::ZERO);
        let numbers: &[f32; 3] = bytemuck::must_cast_ref(vertex);
        let two = |two: Option<&[f32; 2]>| -> f64 {
            bytemuck::must_cast(two.copied().unwrap_or_default())
        };
        _mm_castpd_ps(_mm_set_pd(two(numbers.last_chunk()), two(numbers.first_chunk())))
    };
    let corners_of = |id: u32| corners.get(id as usize).unwrap_or(&[0; 3]);
    let mut numbers = [[_mm256_setzero_ps(); 4]; 3];
    let (low, high) = ids.split_at(LANES / 2);
    for (lane, (&low, &high)) in low.iter().zip(high).enumerate() {
        let (x, y) = (corners_of(low), corners_of(high));
        for corner in 0..3 {
            numbers[corner][lane] = _mm256_set_m128(vertex(y[corner]), vertex(x[corner]));
        }
    }
    let [[ax, ay, _, az], [bx, by, _, bz], [cx, cy, _, cz]] = numbers.map(|four| transposed(four));
    [ax, ay, az, bx, by, bz, cx, cy, cz, Row::default()]
}

/// Loads eight numbers of a chunk.
#[inline]
#[target_feature(enable = "avx2")]
fn load(chunk: &Chunk, from: usize) -> __m256 {
    let row: Option<&Row> = chunk.get(from..from + LANES).and_then(|row| row.try_into().ok());
    bytemuck::must_cast(*row.unwrap_or(&[0; LANES]))
}

#[inline]
#[target_feature(enable = "avx2")]
fn unpack(chunk: &Chunk) -> LeafRows {
    let count = vertex_count(chunk);
    let table = [0, 1, 2].map(|axis| {
        let from = CHUNK_HEAD + axis * count;
        [load(chunk, from), load(chunk, from + LANES)]
    });
    let shifts: __m256i = bytemuck::must_cast([0_u32, 4, 8, 12, 16, 20, 24, 28]);
    let mut leaf = LeafRows::default();
    for corner in 0..3 {
        let halves = _mm256_set1_epi32(chunk[1 + corner].cast_signed());
        let vertex_numbers = _mm256_srlv_epi32(halves, shifts);
        // Bit 3 of the number chooses the half of the table: it is shifted to the sign, by which the blend decides.
        let upper = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(vertex_numbers));
        for (axis, [low, high]) in table.into_iter().enumerate() {
            let low = _mm256_permutevar8x32_ps(low, vertex_numbers);
            let high = _mm256_permutevar8x32_ps(high, vertex_numbers);
            leaf[3 * corner + axis] = bytemuck::must_cast(_mm256_blendv_ps(low, high, upper));
        }
    }
    leaf
}
