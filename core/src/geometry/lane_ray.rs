//! Ray prepared for conservative tests in lanes of `f32`.
//!
//! Nothing here decides a hit; the margins keep whatever is in doubt.
//!
//! # Which rays
//! `t_min >= 0`, coordinates of the origin and of the scene at most 2^28, and components of the direction 0 or between
//! 2^-64 and 2^40. All other rays are traversed in `f64`. So nothing overflows: a volume is below
//! `6 * 2^29 * 2^29 * 2^40 < 2^101`, a parameter below `2^29 * 2^64 = 2^93`.
//!
//! Components as small as 2^-54 are common: the cosine of a right angle is `6e-17` in `f64`.
//!
//! # Planes
//! Let `u = 2^-24`.
//! 1. `(o - plane) * factor` has four roundings: the difference, the inverse of the direction, its scaling, the
//!    product. So it is off by less than `(1 + u)^4`, and by 2^-149 where it underflows.
//! 2. The factors of entries are scaled by `1 - 2^-21` and those of exits by `1 + 2^-21`. So a positive entry is never
//!    late and a positive exit never early.
//! 3. 2^-120 is added to the exit, for the underflows and for hits that round up to 0.
//! 4. A negative entry counts as `t_min`. A negative exit means that what lies before the plane lies behind the ray.
//! 5. A hit that rounds to `t_min` or to the last `t` lies within half an ulp of it, which the factors cover too.
//! 6. A ray in a plane gives 0 * inf = NaN, which the comparisons ignore: it is on both sides for all `t`. A ray beside
//!    a plane along which it runs gives an infinity: it is on one side for all `t`.
//!
//! # Source
//! T. Ize, *Robust BVH Ray Traversal*, 2013, for the scaled factors.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use super::Ray;

/// Ray prepared for lanes. Vectors have three components and a fourth, which is 0 in the first two vectors, because
/// four are read and written at once.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LaneRay {
    pub origin: [f32; 4],
    pub direction: [f32; 4],
    /// The negated inverse of the direction, a little less: it turns the distance from a plane to the origin into the
    /// parameter at which the ray enters.
    pub enter: [f32; 4],
    /// The negated inverse of the direction, a little more: it turns the distance from a plane to the origin into the
    /// parameter at which the ray leaves.
    pub leave: [f32; 4],
    /// Byte order that swaps the sides of a box where the direction is negative: twos there, else zeros.
    ///
    /// A word of the lean BVH has a box's lower side in its lower half. XORed to the order of the word's bytes, this
    /// brings the side by which the ray enters into the lower half.
    #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
    pub swap: [u32; 4],
    /// The largest absolute value of the direction's components.
    pub reach: f32,
    pub t_min: f32,
}

/// Largest absolute value of a coordinate.
pub(crate) const MOST_COORDINATE: f32 = 268_435_456.0; // 2^28
/// Factor that makes an entry early; see "Planes".
pub(crate) const EARLIER: f32 = 1.0 - 4.768_371_6e-7; // 1 - 2^-21
/// Factor that makes an exit late; see "Planes".
pub(crate) const LATER: f32 = 1.0 + 4.768_371_6e-7; // 1 + 2^-21
/// Least absolute value of a component of the direction that is not 0.
pub(crate) const LEAST_DIRECTION: f32 = 5.421_011e-20; // 2^-64
/// Largest absolute value of a component of the direction.
pub(crate) const MOST_DIRECTION: f32 = 1.099_511_6e12; // 2^40
/// Slack for underflows; see "Planes".
pub(crate) const UNDERFLOW: f32 = 7.523_164e-37; // 2^-120

/// Bits of the axes.
const AXES: u32 = 0b0111;

impl LaneRay {
    /// The ray of a traversal that has none.
    pub const IDLE: Self = {
        let zero = [0.0; 4];
        Self {
            origin: zero,
            direction: zero,
            enter: zero,
            leave: zero,
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            swap: [0; 4],
            reach: 0.0,
            t_min: 0.0,
        }
    };

    /// Prepares a ray for a scene whose largest coordinate is given; also tells whether the ray runs along an axis or
    /// a plane across one. `None` if the bounds of lanes do not hold; see "Which rays".
    // Forced: the traversal of the wide BVH is compiled for the instructions of its lanes, with all that it calls.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn of(ray: &Ray, largest_coordinate: f32) -> Option<(Self, bool)> {
        let (origin, direction) = (ray.origin().extend(0.0), ray.direction().extend(0.0));
        let sizes = direction.abs();
        let large_enough = sizes.cmpge(Vec4::splat(LEAST_DIRECTION)).bitmask();
        let small_enough = sizes.cmple(Vec4::splat(MOST_DIRECTION))
            & origin.abs().cmple(Vec4::splat(MOST_COORDINATE));
        let tame =
            small_enough.all() && largest_coordinate <= MOST_COORDINATE && ray.t_min() >= 0.0;
        if !tame {
            return None;
        }
        let is_along = large_enough != AXES;
        if is_along {
            let zero = sizes.cmpeq(Vec4::ZERO).bitmask();
            if (large_enough | zero) & AXES != AXES {
                return None;
            }
        }
        let inverse = Vec4::NEG_ONE / direction;
        let prepared = Self {
            origin: origin.to_array(),
            direction: direction.to_array(),
            enter: (inverse * EARLIER).to_array(),
            leave: (inverse * LATER).to_array(),
            #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
            swap: bytemuck::must_cast(Vec4::select(
                inverse.cmpgt(Vec4::ZERO),
                Vec4::splat(f32::from_bits(0x0202_0202)),
                Vec4::ZERO,
            )),
            reach: sizes.max_element(),
            t_min: ray.t_min(),
        };
        Some((prepared, is_along))
    }

    /// The side of a box by which the ray enters, 0 for the lower or 1 for the upper, and the side by which it leaves.
    // Forced: see `of`.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn sides(&self, axis: usize) -> [usize; 2] {
        let near = (self.direction[axis % 4].to_bits() >> 31) as usize;
        [near, 1 - near]
    }

    /// Bounds what underflows can cost `det` minus the other volumes.
    // Forced: see `of`.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn underflow(&self) -> f32 {
        4.0 * UNDERFLOW * (self.reach + 1.0)
    }
}
