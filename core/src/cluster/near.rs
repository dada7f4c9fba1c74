//! "At most delta apart", for boxes in lanes: of two boxes, or of one box and a group of eight. See [`find`](super::find)
//! for delta.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use crate::geometry::Box4;

/// Number of boxes in a group.
pub(super) const GROUP: usize = 8;

/// Up to [`GROUP`] boxes, a lane each. Lanes without a box have the empty box.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BoxGroup {
    /// The lower sides of the boxes on each axis.
    lo: [[Vec4; 2]; 3],
    /// The upper sides.
    hi: [[Vec4; 2]; 3],
}

impl BoxGroup {
    /// A group without boxes.
    pub const EMPTY: Self = Self { lo: [[Vec4::INFINITY; 2]; 3], hi: [[Vec4::NEG_INFINITY; 2]; 3] };

    /// Gathers the first [`GROUP`] boxes, or fewer.
    pub fn gather(boxes: impl Iterator<Item = Box4>) -> Self {
        let mut lanes = [Box4::EMPTY; GROUP];
        for (lane, bounds) in lanes.iter_mut().zip(boxes) {
            *lane = bounds;
        }
        let [a, b, c, d, e, f, g, h] = lanes;
        let lo = [transpose([a.lo, b.lo, c.lo, d.lo]), transpose([e.lo, f.lo, g.lo, h.lo])];
        let hi = [transpose([a.hi, b.hi, c.hi, d.hi]), transpose([e.hi, f.hi, g.hi, h.hi])];
        let axes = |[low, high]: [[Vec4; 3]; 2]| {
            let ([x0, y0, z0], [x1, y1, z1]) = (low, high);
            [[x0, x1], [y0, y1], [z0, z1]]
        };
        Self { lo: axes(lo), hi: axes(hi) }
    }

    /// The box around all.
    pub fn bounds(&self) -> Box4 {
        let [x, y, z] = self.lo.map(|[a, b]| a.min(b).min_element());
        let lo = Vec4::new(x, y, z, 0.0);
        let [x, y, z] = self.hi.map(|[a, b]| a.max(b).max_element());
        Box4 { lo, hi: Vec4::new(x, y, z, 0.0) }
    }

    /// The box in a lane.
    pub fn get(&self, lane: usize) -> Box4 {
        let corner = |sides: &[[Vec4; 2]; 3]| {
            let side = |axis: &[Vec4; 2]| {
                let lanes: &[f32; GROUP] = bytemuck::must_cast_ref(axis);
                lanes.get(lane).copied().unwrap_or(0.0)
            };
            let [x, y, z] = sides;
            Vec4::new(side(x), side(y), side(z), 0.0)
        };
        Box4 { lo: corner(&self.lo), hi: corner(&self.hi) }
    }
}

/// The first three components of four vectors, each in one vector.
fn transpose([a, b, c, d]: [Vec4; 4]) -> [Vec4; 3] {
    [Vec4::new(a.x, b.x, c.x, d.x), Vec4::new(a.y, b.y, c.y, d.y), Vec4::new(a.z, b.z, c.z, d.z)]
}

/// The numbers of the bits that are set, ascending.
pub(super) fn bits(mut set: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lowest = (set != 0).then(|| set.trailing_zeros() as usize)?;
        set &= set - 1;
        Some(lowest)
    })
}

/// Test whether two boxes are at most a given distance apart. It says exactly what `Aabb::gap_squared` says.
///
/// The square of the gap is computed in `f32` first. Its relative error is below `8 * 2^-24`: one rounding of each
/// difference, one of each square, two of the sum and one of delta. Where it is within 2^-20 of the square of delta, or
/// where that may under- or overflow, `f64` decides.
#[derive(Clone, Copy)]
pub(super) struct Nearness {
    delta_squared: f64,
    /// Squares below are surely near.
    surely: f32,
    /// Squares above are surely not near.
    surely_not: f32,
}

/// Relative margin of squares in `f32`: 2^-20.
const MARGIN: f32 = 9.536_743e-7;
/// Least and largest square of delta for which `f32` decides anything.
const LEAST: f64 = 1e-30;
const LARGEST: f64 = 1e38;

impl Nearness {
    pub fn new(delta_squared: f64) -> Self {
        let square = delta_squared as f32;
        let (surely, surely_not) = if delta_squared > LEAST && delta_squared < LARGEST {
            (square * (1.0 - MARGIN), square * (1.0 + MARGIN))
        } else {
            (0.0, f32::INFINITY)
        };
        Self { delta_squared, surely, surely_not }
    }

    /// Tells whether two boxes are near. The fourth components do not matter. The empty box is near to none.
    #[inline]
    pub fn holds(&self, a: &Box4, b: &Box4) -> bool {
        let gap = (a.lo - b.hi).max(b.lo - a.hi).max(Vec4::ZERO);
        let [x, y, z, _] = (gap * gap).to_array();
        let square = x + y + z;
        if square > self.surely_not {
            return false;
        }
        square < self.surely || self.holds_exactly(a, b)
    }

    /// The lanes of a group, as bits, whose boxes are near to `one`.
    #[inline]
    pub fn lanes(&self, one: &Box4, group: &BoxGroup) -> u32 {
        let ([x, y, z], [x_hi, y_hi, z_hi]) = (&group.lo, &group.hi);
        // Of the gaps along one axis, the squares.
        let squares = |lo: f32, hi: f32, sides: &[Vec4; 2], sides_hi: &[Vec4; 2]| {
            let (lo, hi) = (Vec4::splat(lo), Vec4::splat(hi));
            let ([low, high], [low_hi, high_hi]) = (sides, sides_hi);
            let gaps = [(lo - *low_hi).max(*low - hi), (lo - *high_hi).max(*high - hi)];
            gaps.map(|gap| gap.max(Vec4::ZERO)).map(|gap| gap * gap)
        };
        let [x, x_high] = squares(one.lo.x, one.hi.x, x, x_hi);
        let [y, y_high] = squares(one.lo.y, one.hi.y, y, y_hi);
        let [z, z_high] = squares(one.lo.z, one.hi.z, z, z_hi);
        let [(low, sure_low), (high, sure_high)] =
            [x + y + z, x_high + y_high + z_high].map(|square| {
                let possible = square.cmple(Vec4::splat(self.surely_not)).bitmask();
                (possible, square.cmplt(Vec4::splat(self.surely)).bitmask())
            });
        let (possible, sure) = (low | high << 4, sure_low | sure_high << 4);
        let undecided = bits(possible & !sure);
        undecided.fold(sure, |near, lane| {
            near | u32::from(self.holds_exactly(one, &group.get(lane))) << lane
        })
    }

    #[cold]
    fn holds_exactly(&self, a: &Box4, b: &Box4) -> bool {
        a.aabb().gap_squared(&b.aabb()) <= self.delta_squared
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;
    use glam::Vec3;

    #[test]
    fn it_says_what_the_exact_gap_says() {
        let unit = Aabb::new(Vec3::ZERO, Vec3::ONE);
        for delta in [0.0, 1e-20, 1e-3, 0.5, 1.0, 1.8446e19, 1e20, 1e30_f64] {
            let near = Nearness::new(delta * delta);
            for ulps in -40..=40 {
                let gap = f32::from_bits((delta as f32).to_bits().saturating_add_signed(ulps));
                for at in
                    [Vec3::new(1.0 + gap, 0.2, 0.3), Vec3::new(0.5, -gap, -gap), Vec3::splat(gap)]
                {
                    let other = Aabb::new(at, at);
                    let expected = unit.gap_squared(&other) <= delta * delta;
                    let boxes = [Box4::of(&unit), Box4::of(&other)];
                    assert_eq!(near.holds(&boxes[0], &boxes[1]), expected, "{at} {delta}");
                    assert_eq!(near.holds(&boxes[1], &boxes[0]), expected, "{at} {delta}");
                    for lane in 0..GROUP {
                        let lanes = (0..GROUP).map(|at| boxes[usize::from(at != lane)]);
                        let group = BoxGroup::gather(lanes.take(lane + 1));
                        let near = near.lanes(&boxes[1], &group);
                        let others = (1 << lane) - 1;
                        assert_eq!(near, others | u32::from(expected) << lane, "{at} {delta}");
                    }
                }
            }
            assert!(!near.holds(&Box4::EMPTY, &Box4::of(&unit)));
            assert!(!near.holds(&Box4::EMPTY, &Box4::EMPTY));
            let nothing = BoxGroup::gather(core::iter::empty());
            assert_eq!(near.lanes(&Box4::of(&unit), &nothing), 0);
            assert_eq!(near.lanes(&Box4::EMPTY, &nothing), 0);
        }
    }
}
