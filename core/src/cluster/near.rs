//! "At most delta apart", for boxes in lanes.

use glam::Vec4;

use crate::geometry::Box4;

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
/// Least square of delta for which `f32` decides anything.
const LEAST: f64 = 1e-30;

impl Nearness {
    pub fn new(delta_squared: f64) -> Self {
        let square = delta_squared as f32;
        let (surely, surely_not) = if delta_squared > LEAST {
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
        square < self.surely || a.aabb().gap_squared(&b.aabb()) <= self.delta_squared
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
        for delta in [0.0, 1e-20, 1e-3, 0.5, 1.0, 1e20, 1e30_f64] {
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
                }
            }
            assert!(!near.holds(&Box4::EMPTY, &Box4::of(&unit)));
            assert!(!near.holds(&Box4::EMPTY, &Box4::EMPTY));
        }
    }
}
