//! Quantised boxes, 16 bits a side: never smaller than the given ones, and the same where a plane can be represented
//! exactly.
//!
//! - A plane is the `f32` nearest to `anchor + q * step`.
//! - The anchor is the node's own lower side, and the step a power of two. So `q * step` is exact, and for planes on a
//!   lattice the sum is, too. Boxes there that touch or are flat still do and are.
//! - Any other plane is that of the next `q` further outside. This is up to a 32,768th of the node's extent.
//! - The encoder compares the very planes that traversals decode. So no error bound is needed: to a traversal they are
//!   ordinary planes.
//! - Lanes add in `f32`. The encoder and all else add in `f64`, where a product cannot overflow, and round then. Both
//!   give the `f32` nearest to the sum, because a sum of two `f32` that is rounded to 53 bits first rounds the same way
//!   (S. Figueroa, *When Is Double Rounding Innocuous?*, 1995).
//!
//! # What lost
//! - 8 bits, and steps that are no powers of two: 1.4 to 2.3 bytes a triangle less, but rays entered 2 to 36% more
//!   nodes, most where boxes touch.
//! - 16 bits, and such steps: up to 28% more nodes.

use super::{EMPTY, NODE_WORDS, QuantisedNode};
use crate::Vec3;
use crate::geometry::Aabb;
use crate::indices::wide::rows::LANES;

impl Default for QuantisedNode {
    /// The node without boxes.
    fn default() -> Self {
        Self { anchor: [0.0; 3], step: [0.0; 3], planes: [[[0; 4]; 2]; 3], links: [EMPTY; LANES] }
    }
}

impl QuantisedNode {
    /// Encodes a node of up to eight boxes; links are to be set.
    pub fn of(boxes: &[Aabb]) -> Self {
        let mut node = Self::default();
        let all = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds));
        for axis in 0..3 {
            let (anchor, step) = scale(all.lo.to_array()[axis], all.hi.to_array()[axis]);
            node.anchor[axis] = anchor;
            node.step[axis] = step;
            for (lane, bounds) in boxes.iter().enumerate().take(LANES) {
                let lo = last_below(bounds.lo.to_array()[axis], anchor, step);
                let hi = first_above(bounds.hi.to_array()[axis], anchor, step);
                node.set_quantum(axis, 0, lane, lo);
                node.set_quantum(axis, 1, lane, hi);
            }
        }
        node
    }

    pub fn words(&self) -> &[u32; NODE_WORDS] {
        bytemuck::must_cast_ref(self)
    }

    /// Reads a plane of an axis, the lower (side 0) or the upper (side 1), in steps from the anchor.
    #[inline(always)]
    pub fn quantum(&self, axis: usize, side: usize, lane: usize) -> u16 {
        let words = self.planes[axis % 3][side % 2];
        (words[lane / 2 % 4] >> (16 * (lane % 2))) as u16
    }

    /// Sets a plane that was 0; see [`Self::quantum`].
    pub fn set_quantum(&mut self, axis: usize, side: usize, lane: usize, quantum: u16) {
        let words = &mut self.planes[axis % 3][side % 2];
        words[lane / 2 % 4] |= u32::from(quantum) << (16 * (lane % 2));
    }

    /// Decodes the box of a lane.
    pub fn bounds(&self, lane: usize) -> Aabb {
        let side = |side: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis: usize| {
                let quantum = self.quantum(axis, side, lane);
                plane(quantum, self.anchor[axis % 3], self.step[axis % 3])
            });
            Vec3::new(x, y, z)
        };
        Aabb::new(side(0), side(1))
    }
}

/// Decodes a plane.
pub(super) fn plane(quantum: u16, anchor: f32, step: f32) -> f32 {
    (f64::from(anchor) + f64::from(quantum) * f64::from(step)) as f32
}

/// Chooses the anchor and the step with which planes reach from `lo` to `hi`.
fn scale(lo: f32, hi: f32) -> (f32, f32) {
    const MANTISSA: u64 = (1 << 52) - 1;
    let least = (f64::from(hi) - f64::from(lo)) / f64::from(u16::MAX);
    let power = f64::from_bits(least.to_bits().saturating_add(MANTISSA) & !MANTISSA);
    // Not subnormal, because a product of such a step might be rounded.
    let mut step =
        if power > f64::from(f32::MIN_POSITIVE) { power as f32 } else { f32::MIN_POSITIVE };
    // This loop runs at most once: if the difference was rounded down.
    while plane(u16::MAX, lo, step) < hi && step < f32::MAX / 2.0 {
        step *= 2.0;
    }
    (lo, step)
}

/// Computes the distance of `x` from the anchor in steps, rounded down.
fn quotient(x: f32, anchor: f32, step: f32) -> u16 {
    // The cast saturates.
    ((f64::from(x) - f64::from(anchor)) / f64::from(step)) as u16
}

/// Finds the last plane that is not above `x`, else the anchor.
fn last_below(x: f32, anchor: f32, step: f32) -> u16 {
    let mut quantum = quotient(x, anchor, step).saturating_add(1);
    while quantum > 0 && plane(quantum, anchor, step) > x {
        quantum -= 1;
    }
    quantum
}

/// Finds the first plane that is not below `x`, else the last plane of all.
fn first_above(x: f32, anchor: f32, step: f32) -> u16 {
    let mut quantum = quotient(x, anchor, step).saturating_sub(1);
    while quantum < u16::MAX && plane(quantum, anchor, step) < x {
        quantum += 1;
    }
    quantum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes nodes of one to eight boxes of all sizes and positions, flat ones among them.
    fn each_node(mut check: impl FnMut(&[Aabb], &QuantisedNode)) {
        const SIZES: [f32; 10] = [0.0, 1e-45, 1e-38, 3e-9, 0.1, 1.0, 777.7, 1e6, 2.6e8, 1e38];
        let number = |i: usize| SIZES[i % SIZES.len()] * ((i * i % 7) as f32 - 3.0) / 1.7;
        for first in 0..4_000 {
            let corner = |i: usize| Vec3::new(number(i), number(i * 3 + 1), number(i / 7 + 2));
            let boxes: [Aabb; LANES] = core::array::from_fn(|i| {
                let at = corner(first + i * (first % 11));
                Aabb::EMPTY.with_point(at).with_point(corner(first / 3 + i)).with_point(at)
            });
            let boxes = &boxes[..=first % LANES];
            check(boxes, &QuantisedNode::of(boxes));
        }
    }

    #[test]
    fn decoded_boxes_hold_the_originals() {
        each_node(|boxes, node| {
            for (lane, bounds) in boxes.iter().enumerate() {
                let decoded = node.bounds(lane);
                assert!(decoded.contains(bounds), "{bounds:?} became {decoded:?}");
            }
        });
    }

    #[test]
    fn decoded_boxes_are_little_larger() {
        each_node(|boxes, node| {
            let all = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds));
            for (lane, bounds) in boxes.iter().enumerate() {
                let decoded = node.bounds(lane);
                for axis in 0..3 {
                    let side = |corner: Vec3| f64::from(corner.to_array()[axis]);
                    let extent = side(all.hi) - side(all.lo);
                    let ulp = side(all.hi).abs().max(side(all.lo).abs()) * 6e-8 + 2e-38;
                    let most = extent / 32_767.0 + ulp;
                    assert!(side(bounds.lo) - side(decoded.lo) <= most, "{bounds:?} {decoded:?}");
                    assert!(side(decoded.hi) - side(bounds.hi) <= most, "{bounds:?} {decoded:?}");
                }
            }
        });
    }

    /// The planes that lanes compute are those that the encoder has compared.
    #[test]
    fn planes_are_the_same_in_f32() {
        each_node(|boxes, node| {
            for lane in 0..boxes.len() {
                let decoded = node.bounds(lane);
                for (side, corner) in [decoded.lo, decoded.hi].into_iter().enumerate() {
                    for axis in 0..3 {
                        let product = f32::from(node.quantum(axis, side, lane)) * node.step[axis];
                        if product.is_finite() {
                            assert_eq!(product + node.anchor[axis], corner.to_array()[axis]);
                        }
                    }
                }
            }
        });
    }

    #[test]
    fn planes_on_a_lattice_stay() {
        let boxes: [Aabb; LANES] = core::array::from_fn(|i| {
            let lo = Vec3::new(i as f32 - 100.0, 0.25, (i / 2) as f32);
            Aabb::new(lo, lo + Vec3::new(1.0, 0.0, 2.5))
        });
        let node = QuantisedNode::of(&boxes);
        for (lane, bounds) in boxes.iter().enumerate() {
            assert_eq!(node.bounds(lane), *bounds);
        }
    }
}
