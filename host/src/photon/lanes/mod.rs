//! Photons in lanes: the usual case of an emission, of a bounce and of a side, for many photons at once.
//!
//! ```text
//! gather  ->  draw          ->  compute             ->  scatter
//! arrays      philox_lanes      f64, no branch          rays; photons in doubt go through `trace`, one by one
//! ```
//!
//! The problem: a photon needs some 300 dependent operations, a third of them for random numbers, and takes a branch
//! that no processor can predict for each point that it draws. The idea: the same operations on arrays, in loops
//! without a branch, which the compiler turns into vector instructions. The arithmetic is that of `emission`, `offset`,
//! `hemisphere` and `side`, whose functions the loops call, so the bits are the same.
//!
//! The usual case: a light that is a parallelogram, a point away from the triangle's edges, a direction that certainly
//! leaves the triangle, and one of the first two points drawn lies in the disc. All else is done as for one photon.
//!
//! # How a loop becomes vectors
//! - It runs over all lanes of arrays, and all that it calls is inlined, by force.
//! - It has no `map` over arrays and no `?`, and writes a failure as a number: NaN, or a number of attempts.
//! - It gets its arrays by references, so that the compiler knows that they do not overlap.
//!
//! # Measured
//! Instructions a ray of a shot on figure 4(b), without the index: 980 with one photon at a time, 490 with these lanes
//! in AVX2. In SSE2, as a program has them without [`SimdLevel::run`](arboleda::SimdLevel::run), it is 130 more.
//!
//! # What lost
//! - Loops with `map`, or results returned by value: no vectors, and copies: 220 instructions a ray more.
//! - Rounds of the random numbers outside and lanes inside: no vectors in SSE2.
// Several arrays are indexed by the same lane.
#![allow(clippy::needless_range_loop)]

mod bounce;
mod emit;
mod side;

use arboleda::{Ray, RayError, Vec3};

pub(super) use bounce::BounceLanes;
pub(super) use emit::EmissionLanes;
pub(super) use side::SideLanes;

use super::surface::hemisphere::square_of;
use crate::scene::vector::Vector64;

/// Number of photons computed at once. The last group of a wave may have unused lanes.
pub(super) const LANES: usize = 32;

/// Most points that are tried in lanes: the second fails with a probability of (1 - pi/4)^2, or 5%.
const LANE_ATTEMPTS: u64 = 2;

/// Word of each lane: 32 random bits in the low half.
type Words = [u64; LANES];
/// Vector of each lane: x of all lanes, then y, then z.
type Vectors = [[f32; LANES]; 3];

/// Rays that are computed in lanes.
#[derive(Clone)]
struct LaneRays {
    origins: Vectors,
    directions: Vectors,
    /// Points tried for the direction. Above [`LANE_ATTEMPTS`], none of those in lanes lies in the disc.
    attempts: Words,
}

impl LaneRays {
    const ZERO: Self =
        Self { origins: [[0.0; LANES]; 3], directions: [[0.0; LANES]; 3], attempts: [0; LANES] };

    #[inline]
    fn ray(&self, lane: usize) -> Result<Ray, RayError> {
        Ray::new(vector(&self.origins, lane), vector(&self.directions, lane))
    }
}

/// Moves the 24 bits of a uniform draw to the front of a mantissa.
#[inline(always)]
fn mantissa(word: u64) -> u64 {
    (word & 0xffff_ff00) << 20
}

/// Computes the middle of one of 2^24 equal parts of 0 to 1, exactly.
#[inline(always)]
fn part(word: u64) -> f64 {
    /// Bits of 1 + 2^-25.
    const ONE_AND_HALF_STEP: u64 = 0x3ff0_0000_0000_0000 | 1 << 27;
    f64::from_bits(ONE_AND_HALF_STEP | mantissa(word)) - 1.0
}

/// Computes `2 u - 1` for a uniform draw `u`, exactly.
#[inline(always)]
fn coordinate(word: u64) -> f64 {
    /// Bits of 2.0.
    const TWO: u64 = 0x4000_0000_0000_0000;
    f64::from_bits(TWO | mantissa(word)) - 3.0
}

/// Point drawn in the unit disc.
#[derive(Clone, Copy)]
struct DiscPoint {
    x: f64,
    y: f64,
    attempts: u64,
}

impl DiscPoint {
    /// Chooses the first of two points that lies in the disc.
    #[inline(always)]
    fn choose(x1: u64, y1: u64, x2: u64, y2: u64) -> Self {
        let (x1, y1) = (coordinate(x1), coordinate(y1));
        let (x2, y2) = (coordinate(x2), coordinate(y2));
        let is_first = square_of(x1, y1) < 1.0;
        let is_second = square_of(x2, y2) < 1.0;
        let attempts = if is_second { 2 } else { LANE_ATTEMPTS + 1 };
        Self {
            x: if is_first { x1 } else { x2 },
            y: if is_first { y1 } else { y2 },
            attempts: if is_first { 1 } else { attempts },
        }
    }
}

/// Returns the four words of a lane.
#[inline]
fn words_of([w0, w1, w2, w3]: &[Words; 4], lane: usize) -> [u32; 4] {
    [w0[lane] as u32, w1[lane] as u32, w2[lane] as u32, w3[lane] as u32]
}

#[inline(always)]
fn vector([x, y, z]: &Vectors, lane: usize) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

#[inline(always)]
fn wide(vectors: &Vectors, lane: usize) -> Vector64 {
    vector(vectors, lane).into()
}

#[inline(always)]
fn put([x, y, z]: &mut Vectors, lane: usize, vector: Vec3) {
    (x[lane], y[lane], z[lane]) = (vector.x, vector.y, vector.z);
}
