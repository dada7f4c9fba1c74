//! Unpacking in AVX2.
//!
//! The same operations in the same order as `lanes`. As in the wide octree's `avx2`, the only `unsafe` is
//! calling functions compiled for instructions that the processor may not have;
//! [`Vectors`](crate::Vectors) can say that it has them only after asking it.
#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m128i, __m256, __m256i, _mm_or_si128, _mm256_add_ps, _mm256_blendv_ps, _mm256_castsi256_ps,
    _mm256_cvtepi32_ps, _mm256_cvtepu16_epi32, _mm256_mul_ps, _mm256_permutevar8x32_ps,
    _mm256_set1_epi32, _mm256_set1_ps, _mm256_slli_epi32, _mm256_srlv_epi32,
};

use super::lanes::{LANES_FROM, Unpack};
use super::{BLOCK_HEAD, Block, Node, vertex_count};
use crate::indices::wide_octree::avx2::{Avx, meet_planes};
use crate::indices::wide_octree::lanes::LaneRay;
use crate::indices::wide_octree::{LANES, Leaf, Row};

impl<const WITH_512: bool> Unpack for Avx<WITH_512> {
    #[inline(always)]
    fn meet_node(node: &Node, ray: &LaneRay, last: f32) -> __m128i {
        // SAFETY: only functions compiled for AVX2 walk with these lanes; so below.
        unsafe { meet_node(node, ray, last) }
    }

    #[inline(always)]
    fn unpack(block: &Block) -> Leaf {
        // SAFETY: see `meet_node`.
        unsafe { unpack(block) }
    }

    #[inline(always)]
    fn first(keys: __m128i, count: usize) -> __m128i {
        // SAFETY: see `meet_node`.
        unsafe { first(keys, count) }
    }
}

#[inline]
#[target_feature(enable = "avx2")]
fn first(keys: __m128i, count: usize) -> __m128i {
    _mm_or_si128(keys, bytemuck::must_cast(LANES_FROM[count.min(LANES)]))
}

/// Eight numbers of 16 bits as floats.
#[inline]
#[target_feature(enable = "avx2")]
fn floats(numbers: [u32; 4]) -> __m256 {
    _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(bytemuck::must_cast(numbers)))
}

#[inline]
#[target_feature(enable = "avx2")]
fn meet_node(node: &Node, ray: &LaneRay, last: f32) -> __m128i {
    meet_planes(ray, last, |axis, side| {
        let quanta = floats(node.planes[(2 * axis + side) % 6]);
        let step = _mm256_set1_ps(node.step[axis % 3]);
        _mm256_add_ps(_mm256_mul_ps(quanta, step), _mm256_set1_ps(node.anchor[axis % 3]))
    })
}

/// Eight numbers of a block.
#[inline]
#[target_feature(enable = "avx2")]
fn load(block: &Block, from: usize) -> __m256 {
    let row: Option<&Row> = block.get(from..from + LANES).and_then(|row| row.try_into().ok());
    bytemuck::must_cast(*row.unwrap_or(&[0; LANES]))
}

#[inline]
#[target_feature(enable = "avx2")]
fn unpack(block: &Block) -> Leaf {
    let count = vertex_count(block);
    let table = [0, 1, 2].map(|axis| {
        let from = BLOCK_HEAD + axis * count;
        [load(block, from), load(block, from + LANES)]
    });
    let shifts: __m256i = bytemuck::must_cast([0_u32, 4, 8, 12, 16, 20, 24, 28]);
    let mut leaf = Leaf::default();
    for corner in 0..3 {
        let halves = _mm256_set1_epi32(block[1 + corner].cast_signed());
        let places = _mm256_srlv_epi32(halves, shifts);
        // The fourth bit, where it decides: in the place of the sign.
        let upper = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(places));
        for (axis, [low, high]) in table.into_iter().enumerate() {
            let low = _mm256_permutevar8x32_ps(low, places);
            let high = _mm256_permutevar8x32_ps(high, places);
            leaf[3 * corner + axis] = bytemuck::must_cast(_mm256_blendv_ps(low, high, upper));
        }
    }
    leaf
}
