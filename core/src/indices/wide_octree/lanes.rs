//! Eight boxes, or eight triangles, against one ray, in `f32`.
//!
//! Plain loops over arrays of eight for every target; `avx2` has the same operations in the same order.
//! Nothing here decides a hit; margins keep whatever is in doubt.
//!
//! # Which rays
//! `t_min >= 0`, coordinates of the origin and of the scene at most 2^28, and components of the direction
//! 0 or between 2^-40 and 2^40; others take the `f64` way. So nothing overflows: a volume is below
//! `6 * 2^29 * 2^29 * 2^40 < 2^101`.
//!
//! # Boxes
//! With `u = 2^-24`: `(plane - o) * inverse` has three roundings, counting that of the inverse, and scaling
//! adds a fourth, so it is off by less than `(1 + u)^4`, and by 2^-149 where it underflows. The latest
//! entry is scaled by `1 - 2^-21` and the earliest exit by `1 + 2^-21`, so a positive entry is never late
//! and a positive exit never early; 2^-120 is added to the exit for the underflows and for hits that round
//! up to 0. A negative entry counts as `t_min`, a negative exit means that the box lies behind. A hit that
//! rounds to `t_min` or to the last `t` lies within half an ulp of it, which the factors cover too. A ray
//! in a plane gives 0 * inf = NaN, which the comparisons ignore.
//!
//! # Triangles
//! The `f32` filter of `geometry::kernel`, with the same bounds; and, where `t` times `det` is surely
//! beyond the last `t` times `det`, or surely before `t_min`, that too. The error of `det * t` is at
//! most `56 u S E^2`; that of `last * det` is `48 u last D E^2`, and as `det` is at most `6 D E^2`, `6 u
//! last D E^2` for each of: the product, the sum with the margin, the rounding of the reported `t`. 80
//! covers either.

use glam::Vec3A;

use super::{LANES, Leaf, Node};
use crate::geometry::Ray;

/// A ray prepared for lanes.
#[derive(Clone, Copy, Default)]
pub(in crate::indices) struct LaneRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub inverse: [f32; 3],
    /// 1 where the direction is negative: the ray enters a box where it ends.
    pub signs: [u32; 3],
    /// The largest component of the direction.
    pub reach: f32,
    /// The most that underflows can cost a volume.
    pub underflow: f32,
    pub t_min: f32,
}

const MOST_COORDINATE: f32 = 268_435_456.0; // 2^28
/// How much later or earlier than computed a plane may be crossed, relatively.
pub(in crate::indices) const EARLIER: f32 = 1.0 - 4.768_371_6e-7; // 1 - 2^-21
pub(in crate::indices) const LATER: f32 = 1.0 + 4.768_371_6e-7; // 1 + 2^-21
const LEAST_DIRECTION: f32 = 9.094_947e-13; // 2^-40
const MOST_DIRECTION: f32 = 1.099_511_6e12; // 2^40
pub(in crate::indices) const UNDERFLOW: f32 = 7.523_164e-37; // 2^-120

/// Half an ulp of 1.
const R: f32 = f32::EPSILON / 2.0;
pub(in crate::indices) const SUM: f32 = 64.0 * R;
pub(in crate::indices) const DISTANCE: f32 = 80.0 * R;

/// Of a NaN and a number, the second.
#[inline(always)]
pub(in crate::indices) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(in crate::indices) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn largest([x, y, z]: [f32; 3]) -> f32 {
    larger(x.abs(), larger(y.abs(), z.abs()))
}

impl LaneRay {
    /// `None` for a ray that has to take the `f64` way, in a scene whose largest coordinate is given.
    #[inline(always)]
    pub fn new(ray: &Ray, largest_coordinate: f32) -> Option<Self> {
        let (origin, direction) = (Vec3A::from(ray.origin()), Vec3A::from(ray.direction()));
        let sizes = direction.abs();
        let reach = sizes.max_element();
        let tame_direction = sizes.cmpge(Vec3A::splat(LEAST_DIRECTION)) | sizes.cmpeq(Vec3A::ZERO);
        let tame = tame_direction.all()
            && reach <= MOST_DIRECTION
            && origin.abs().max_element() <= MOST_COORDINATE
            && largest_coordinate <= MOST_COORDINATE
            && ray.t_min() >= 0.0;
        if !tame {
            return None;
        }
        let inverse = Vec3A::ONE / direction;
        let negative = direction.cmplt(Vec3A::ZERO).bitmask();
        Some(Self {
            origin: origin.to_array(),
            direction: direction.to_array(),
            inverse: inverse.to_array(),
            signs: [negative & 1, negative >> 1 & 1, negative >> 2 & 1],
            reach,
            underflow: UNDERFLOW * larger(reach, 1.0),
            t_min: ray.t_min(),
        })
    }
}

/// Eight boxes, or eight triangles, at once.
pub(in crate::indices) trait Lanes {
    /// Eight numbers of 16 bits.
    type Keys: Copy;

    /// For each box, where the ray enters it, at the earliest, as a key; `FAR` for one that the ray does not
    /// meet up to `last`.
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys;

    /// The lowest key, and the first lane that has it.
    fn nearest(keys: Self::Keys) -> (u16, usize);

    /// The keys with `FAR` in one lane.
    fn without(keys: Self::Keys, lane: usize) -> Self::Keys;

    /// The triangles that the ray may hit at `t_min..=last`, one bit each; of unused lanes, anything. No
    /// edge of them is longer than `edge` along an axis.
    fn meet_triangles(leaf: &Leaf, ray: &LaneRay, edge: f32, last: f32) -> u32;
}

/// The key of a box that is not met, behind all others.
pub(in crate::indices) const FAR: u16 = u16::MAX;

/// A distance, at least 0, as a number of 16 bits: rounded down, and in the same order.
#[inline(always)]
pub(in crate::indices) fn key(distance: f32) -> u16 {
    (distance.to_bits() >> 16) as u16
}

/// Lanes for every target.
pub(in crate::indices) enum Portable {}

impl Lanes for Portable {
    type Keys = [u16; LANES];

    #[inline(always)]
    fn meet_boxes(node: &Node, ray: &LaneRay, last: f32) -> Self::Keys {
        let mut entry = [0.0; LANES];
        let mut exit = [f32::INFINITY; LANES];
        for axis in 0..3 {
            let sign = ray.signs[axis] as usize & 1;
            let (near, far) = (&node[2 * axis + sign], &node[2 * axis + (1 - sign)]);
            let o = ray.origin[axis];
            let inverse = ray.inverse[axis];
            for lane in 0..LANES {
                entry[lane] = larger((f32::from_bits(near[lane]) - o) * inverse, entry[lane]);
                exit[lane] = smaller((f32::from_bits(far[lane]) - o) * inverse, exit[lane]);
            }
        }
        let mut keys = [FAR; LANES];
        for lane in 0..LANES {
            let entry = larger(entry[lane] * EARLIER, ray.t_min);
            let exit = smaller(exit[lane] * LATER, last) + UNDERFLOW;
            if entry <= exit {
                keys[lane] = key(entry);
            }
        }
        keys
    }

    #[inline(always)]
    fn nearest(keys: Self::Keys) -> (u16, usize) {
        // Key and lane in one number: the least is the first of the nearest.
        let of = |lane: usize| u32::from(keys[lane]) << 3 | lane as u32;
        let least = (0..LANES).map(of).fold(u32::MAX, u32::min);
        ((least >> 3) as u16, (least & 7) as usize)
    }

    #[inline(always)]
    fn without(mut keys: Self::Keys, lane: usize) -> Self::Keys {
        keys[lane % LANES] = FAR;
        keys
    }

    #[inline(always)]
    fn meet_triangles(leaf: &Leaf, ray: &LaneRay, edge: f32, last: f32) -> u32 {
        let sum = SUM * ray.reach * edge;
        let doubt = DISTANCE * edge * edge;
        let wider = doubt * ray.reach;
        let underflow = 4.0 * ray.underflow;
        let [ox, oy, oz] = ray.origin;
        let [dx, dy, dz] = ray.direction;
        let number = |row: usize, lane: usize| f32::from_bits(leaf[row][lane]);
        let mut mask = 0;
        for lane in 0..LANES {
            let (px, py, pz) = (number(0, lane), number(1, lane), number(2, lane));
            let (ax, ay, az) = (px - ox, py - oy, pz - oz);
            let (e1x, e1y, e1z) =
                (number(3, lane) - px, number(4, lane) - py, number(5, lane) - pz);
            let (e2x, e2y, e2z) =
                (number(6, lane) - px, number(7, lane) - py, number(8, lane) - pz);
            // n = e1 x e2, q = d x a: det u = d . (e2 x a) = -e2 . q, det v = d . (a x e1) = e1 . q.
            let (nx, ny, nz) =
                (e1y * e2z - e1z * e2y, e1z * e2x - e1x * e2z, e1x * e2y - e1y * e2x);
            let (qx, qy, qz) = (dy * az - dz * ay, dz * ax - dx * az, dx * ay - dy * ax);
            let det = dx * nx + dy * ny + dz * nz;
            let t = ax * nx + ay * ny + az * nz;
            let u = -(e2x * qx + e2y * qy + e2z * qz);
            let v = e1x * qx + e1y * qy + e1z * qz;
            let w = det - u - v;

            let a = largest([ax, ay, az]);
            let margin = sum * (edge + (a + a)) + underflow;
            let mixed = smaller(smaller(u, v), w) < -margin && larger(larger(u, v), w) > margin;

            // The quotient t / det against the interval, without dividing: both times |det|.
            let size = det.abs();
            let along = f32::from_bits(t.to_bits() ^ (det.to_bits() & SIGN));
            let slack = doubt * a + underflow;
            let late = along - slack > last * (size + wider);
            let early = along + slack < ray.t_min * (size - wider);
            // Only where the sign of det is certain is `along` what it says.
            let certain = size > wider + underflow;
            mask |= u32::from(!(mixed || certain && (late || early))) << lane;
        }
        mask
    }
}

/// The bit of the sign.
pub(in crate::indices) const SIGN: u32 = 1 << 31;
