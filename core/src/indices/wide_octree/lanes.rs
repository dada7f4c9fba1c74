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
//! With `u = 2^-24`: `(plane - o) * inverse` has three roundings, counting that of the inverse, so it is
//! off by less than `(1 + u)^3`, and by 2^-149 where it underflows. The inverse is scaled by
//! `1 - 2^-21` for planes where the ray enters and by `1 + 2^-21` where it leaves, so a positive entry
//! is never late and a positive exit never early; 2^-120 is added to the exit for the underflows and for
//! hits that round up to 0. A negative entry counts as `from`, a negative exit means that the box lies
//! behind. A hit that rounds to `t_min` or to the last `t` lies within half an ulp of it, which the
//! factors cover too. A ray in a plane gives 0 * inf = NaN, which the comparisons ignore.
//!
//! # Triangles
//! The `f32` filter of `geometry::kernel`, with the same bounds; and, where `t` times `det` is surely
//! beyond the last `t` times `det`, or surely before `t_min`, that too. The error of `det * t` is at
//! most `56 u S E^2`; that of `last * det` is `48 u last D E^2`, and as `det` is at most `6 D E^2`, `6 u
//! last D E^2` for each of: the product, the sum with the margin, the rounding of the reported `t`. 80
//! covers either.

use super::walk::Lanes;
use super::{LANES, Row};
use crate::geometry::Ray;

/// A ray prepared for lanes.
#[derive(Clone, Copy)]
pub(super) struct LaneRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub entry_inverse: [f32; 3],
    pub exit_inverse: [f32; 3],
    /// The rows of a node where the ray enters a box, and where it leaves it.
    pub entry_row: [usize; 3],
    pub exit_row: [usize; 3],
    /// The largest component of the direction.
    pub reach: f32,
    pub t_min: f32,
}

const MOST_COORDINATE: f32 = 268_435_456.0; // 2^28
/// How much later or earlier than computed a plane may be crossed, relatively.
const WIDER: f64 = 4.768_371_582_031_25e-7; // 2^-21
const LEAST_DIRECTION: f32 = 9.094_947e-13; // 2^-40
const MOST_DIRECTION: f32 = 1.099_511_6e12; // 2^40
pub(super) const UNDERFLOW: f32 = 7.523_164e-37; // 2^-120

impl LaneRay {
    /// `None` for a ray that has to take the `f64` way, in a scene whose largest coordinate is given.
    pub fn new(ray: &Ray, largest_coordinate: f32) -> Option<Self> {
        let origin = ray.origin().to_array();
        let direction = ray.direction().to_array();
        let tame_origin = origin.iter().all(|x| x.abs() <= MOST_COORDINATE);
        let tame_direction = direction
            .iter()
            .all(|d| *d == 0.0 || (LEAST_DIRECTION..=MOST_DIRECTION).contains(&d.abs()));
        let tame_scene = largest_coordinate <= MOST_COORDINATE;
        if !(tame_origin && tame_direction && tame_scene && ray.t_min() >= 0.0) {
            return None;
        }
        let inverse = direction.map(|d| 1.0 / f64::from(d));
        let negative = |axis: usize| usize::from(direction[axis] < 0.0);
        let signs = [negative(0), negative(1), negative(2)];
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        Some(Self {
            origin,
            direction,
            entry_inverse: inverse.map(|x| (x * (1.0 - WIDER)) as f32),
            exit_inverse: inverse.map(|x| (x * (1.0 + WIDER)) as f32),
            entry_row: [3 * signs[0], 1 + 3 * signs[1], 2 + 3 * signs[2]],
            exit_row: [3 - 3 * signs[0], 4 - 3 * signs[1], 5 - 3 * signs[2]],
            reach: larger(direction[0].abs(), larger(direction[1].abs(), direction[2].abs())),
            t_min: ray.t_min(),
        })
    }
}

/// Lanes for every target.
pub(super) enum Portable {}

impl Lanes for Portable {
    #[inline(always)]
    fn meet_boxes(node: &[Row; 7], ray: &LaneRay, last: f32) -> (u32, [f32; LANES]) {
        meet_boxes(node, ray, last)
    }

    #[inline(always)]
    fn meet_triangles(leaf: &[Row; 10], ray: &LaneRay, last: f32) -> u32 {
        meet_triangles(leaf, ray, last)
    }
}

/// The boxes that the ray may meet up to `last`, one bit each, and where it enters them at the earliest.
#[inline(always)]
fn meet_boxes(node: &[Row; 7], ray: &LaneRay, last: f32) -> (u32, [f32; LANES]) {
    let mut entry = [ray.t_min; LANES];
    let mut exit = [last; LANES];
    for axis in 0..3 {
        let (near, far) = match axis {
            0 => (&node[ray.entry_row[0] % 6], &node[ray.exit_row[0] % 6]),
            1 => (&node[ray.entry_row[1] % 6], &node[ray.exit_row[1] % 6]),
            _ => (&node[ray.entry_row[2] % 6], &node[ray.exit_row[2] % 6]),
        };
        let o = ray.origin[axis];
        let (entry_inverse, exit_inverse) = (ray.entry_inverse[axis], ray.exit_inverse[axis]);
        for lane in 0..LANES {
            let t = (f32::from_bits(near[lane]) - o) * entry_inverse;
            entry[lane] = if t > entry[lane] { t } else { entry[lane] };
            let t = (f32::from_bits(far[lane]) - o) * exit_inverse;
            exit[lane] = if t < exit[lane] { t } else { exit[lane] };
        }
    }
    let mut mask = 0;
    for lane in 0..LANES {
        mask |= u32::from(entry[lane] <= exit[lane] + UNDERFLOW) << lane;
    }
    (mask, entry)
}

/// The triangles that the ray may hit at `t_min..=last`, one bit each; of unused lanes, anything.
#[inline(always)]
fn meet_triangles(leaf: &[Row; 10], ray: &LaneRay, last: f32) -> u32 {
    const R: f32 = f32::EPSILON / 2.0;
    let [ox, oy, oz] = ray.origin;
    let [dx, dy, dz] = ray.direction;
    let number = |row: usize, lane: usize| f32::from_bits(leaf[row][lane]);
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let underflow = UNDERFLOW * larger(ray.reach, 1.0);
    let mut mask = 0;
    for lane in 0..LANES {
        let (px, py, pz) = (number(0, lane), number(1, lane), number(2, lane));
        let (ax, ay, az) = (px - ox, py - oy, pz - oz);
        let (e1x, e1y, e1z) = (number(3, lane) - px, number(4, lane) - py, number(5, lane) - pz);
        let (e2x, e2y, e2z) = (number(6, lane) - px, number(7, lane) - py, number(8, lane) - pz);
        // n = e1 x e2, q = d x a: det u = d . (e2 x a) = -e2 . q, det v = d . (a x e1) = e1 . q.
        let (nx, ny, nz) = (e1y * e2z - e1z * e2y, e1z * e2x - e1x * e2z, e1x * e2y - e1y * e2x);
        let (qx, qy, qz) = (dy * az - dz * ay, dz * ax - dx * az, dx * ay - dy * ax);
        let det = dx * nx + dy * ny + dz * nz;
        let t = ax * nx + ay * ny + az * nz;
        let u = -(e2x * qx + e2y * qy + e2z * qz);
        let v = e1x * qx + e1y * qy + e1z * qz;
        let w = det - u - v;

        let a_max = larger(ax.abs(), larger(ay.abs(), az.abs()));
        let e_max = larger(
            larger(e1x.abs(), larger(e1y.abs(), e1z.abs())),
            larger(e2x.abs(), larger(e2y.abs(), e2z.abs())),
        );
        let de = ray.reach * e_max;
        let margin = 48.0 * R * de * a_max + underflow;
        let w_margin = 64.0 * R * de * (e_max + 2.0 * a_max) + 4.0 * underflow;
        let negative = u < -margin || v < -margin || w < -w_margin;
        let positive = u > margin || v > margin || w > w_margin;

        // The quotient t / det against the interval, without dividing: both times |det|.
        let along = if det < 0.0 { -t } else { t };
        let size = det.abs();
        let doubt = 80.0 * R * e_max * e_max;
        let late = along > last * size + doubt * (a_max + ray.reach * last) + 4.0 * underflow;
        let early =
            along < ray.t_min * size - doubt * (a_max + ray.reach * ray.t_min) - 4.0 * underflow;
        // Only where the sign of det is certain is `along` what it says.
        let certain = size > 48.0 * R * de * e_max + underflow;
        let missed = (negative && positive) || (certain && (late || early));
        mask |= u32::from(!missed) << lane;
    }
    mask
}
