//! Triangles while they are sorted into the tree.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use crate::{Aabb, Triangle, Vec3};

/// A box, in registers of four; the last component is not used.
///
/// No coordinate is -0.0, so the least and the largest are the same on every target.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::indices) struct Box4 {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Box4 {
    pub const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    pub fn of(bounds: &Aabb) -> Self {
        Self { lo: bounds.lo.extend(0.0), hi: bounds.hi.extend(0.0) }
    }

    /// A box that is one point.
    pub fn at(point: Vec4) -> Self {
        Self { lo: point, hi: point }
    }

    /// The smallest box around some items.
    pub fn around(items: &[Item]) -> Self {
        items.iter().fold(Self::EMPTY, |all, item| all.union(item.0))
    }

    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// In three components.
    pub fn aabb(self) -> Aabb {
        Aabb::new(self.lo.truncate(), self.hi.truncate())
    }

    /// Half the surface.
    pub fn surface(&self) -> f32 {
        let [x, y, z, _] = (self.hi - self.lo).to_array();
        x * y + y * z + z * x
    }
}

/// A triangle while it is being sorted into the tree: its box, and in the fourth components its id, the
/// upper 16 bits and the lower as numbers.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
pub(in crate::indices) struct Item(Box4);

impl Item {
    pub fn new(triangle: &Triangle, id: u32) -> Self {
        let bounds = triangle.bounds();
        let (lo, hi) = (bounds.lo + Vec3::ZERO, bounds.hi + Vec3::ZERO);
        Self(Box4 { lo: lo.extend((id >> 16) as f32), hi: hi.extend((id & 0xffff) as f32) })
    }

    pub fn id(&self) -> u32 {
        (self.0.lo.w as u32) << 16 | self.0.hi.w as u32
    }

    /// Its box.
    pub fn bounds(&self) -> Box4 {
        self.0
    }

    /// The middle of its box; halves are summed, so nothing overflows.
    #[inline]
    pub fn middle(&self) -> Vec4 {
        self.0.lo * 0.5 + self.0.hi * 0.5
    }

    pub fn largest_coordinate(&self) -> f32 {
        self.0.lo.abs().max(self.0.hi.abs()).truncate().max_element()
    }
}

/// What is known of some items.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub bounds: Box4,
    /// The box around the middles of their boxes.
    pub middles: Box4,
}

impl Part {
    pub fn around(items: &[Item]) -> Self {
        let middles = items.iter().map(|item| Box4::at(item.middle()));
        Self { bounds: Box4::around(items), middles: middles.fold(Box4::EMPTY, Box4::union) }
    }
}

pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
