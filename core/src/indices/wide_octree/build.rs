//! Building from above.
//!
//! A node's triangles are divided in two, then the costliest part again, until there are eight parts
//! or none is left to divide; each division is the best of all axes by estimated tests. A test of up to
//! eight triangles costs the same, so counts are rounded up to full leaves: this fills them.

use bytemuck::{Pod, Zeroable};

use super::{
    BALANCED_FROM, EMPTY, LANES, LEAF_ROWS, LINKS_ROW, NO_ID, NODE_ROWS, ROW_MASK, leaf_link,
};
use crate::auto::surface;
use crate::geometry::Aabb;
use crate::indices::Group;
use crate::memory::{Arena, Words, size_of_slice};
use crate::{BuildError, Vec3};

/// Bins an axis. 8 cost about 2% more steps, 32 were no better.
const BINS: usize = 16;

/// A triangle while it is being sorted into the tree.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Item {
    bounds: Aabb,
    id: u32,
}

impl Item {
    /// The middle; halves are summed, so nothing overflows.
    fn middle(&self) -> Vec3 {
        self.bounds.lo * 0.5 + self.bounds.hi * 0.5
    }
}

pub(super) const fn scratch_bytes(triangle_count: usize) -> usize {
    size_of_slice::<Item>(triangle_count)
}

pub(super) fn build(
    group: &Group<'_>,
    words: &mut Words<'_>,
    scratch: &mut [u8],
) -> Result<(), BuildError> {
    let count = group.ids.len();
    let full = BuildError::ScratchFull { needed: scratch_bytes(count), given: scratch.len() };
    // Every triangle a leaf, and a node for every two children.
    if count.saturating_mul((LEAF_ROWS + NODE_ROWS) as usize) >= ROW_MASK as usize {
        return Err(BuildError::TooLarge);
    }
    let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
    let items = arena.take::<Item>(count).ok_or(full)?;
    for (item, &id) in items.iter_mut().zip(group.ids) {
        let triangle = group.triangles.get(id as usize).copied().unwrap_or_default();
        *item = Item { bounds: triangle.bounds(), id };
    }
    let start = words.len();
    words.extend(&[EMPTY; LANES]);
    let link = Builder { group, words, start }.subtree(items, 0);
    words.set(start, link);
    Ok(())
}

/// A run of items, and where to divide it, if that is known.
#[derive(Clone, Copy)]
struct Part {
    from: usize,
    to: usize,
    bounds: Aabb,
}

impl Part {
    fn of(items: &[Item], from: usize, to: usize) -> Self {
        let part = items.get(from..to).unwrap_or(&[]);
        let bounds = part.iter().fold(Aabb::EMPTY, |all, item| all.union(item.bounds));
        Self { from, to, bounds }
    }

    fn count(&self) -> usize {
        self.to - self.from
    }
}

/// Tests of so many triangles.
fn tests(count: usize) -> f64 {
    count.div_ceil(LANES) as f64
}

struct Builder<'b, 'w> {
    group: &'b Group<'b>,
    words: &'b mut Words<'w>,
    /// The word from which rows count.
    start: usize,
}

impl Builder<'_, '_> {
    fn row(&self) -> u32 {
        ((self.words.len() - self.start) / LANES) as u32
    }

    /// Appends the subtree of some triangles and returns the link to it. As deep a recursion as the
    /// tree, at most 32.
    fn subtree(&mut self, items: &mut [Item], depth: u32) -> u32 {
        if items.len() <= LANES {
            return self.leaf(items);
        }
        let parts = Self::divide(items, depth);
        let row = self.row();
        let node = self.words.reserve(NODE_ROWS as usize * LANES);
        for lane in 0..LANES {
            let part = parts.get(lane);
            let bounds = part.map_or(Aabb::EMPTY, |part| part.bounds);
            let link = match part.and_then(|part| items.get_mut(part.from..part.to)) {
                Some(items) => self.subtree(items, depth + 1),
                None => EMPTY,
            };
            let numbers = bounds.lo.to_array().into_iter().chain(bounds.hi.to_array());
            for (row, number) in numbers.enumerate() {
                self.words.set(node + row * LANES + lane, number.to_bits());
            }
            self.words.set(node + LINKS_ROW * LANES + lane, link);
        }
        row
    }

    fn leaf(&mut self, items: &mut [Item]) -> u32 {
        let row = self.row();
        let leaf = self.words.reserve(LEAF_ROWS as usize * LANES);
        for lane in 0..LANES {
            let item = items.get(lane);
            let triangle = item
                .and_then(|item| self.group.triangles.get(item.id as usize))
                .copied()
                .unwrap_or_default();
            let corners = [triangle.a, triangle.b, triangle.c]
                .into_iter()
                .flat_map(|corner| corner.to_array());
            for (row, number) in corners.enumerate() {
                self.words.set(leaf + row * LANES + lane, number.to_bits());
            }
            let id = item.map_or(NO_ID, |item| item.id);
            self.words.set(leaf + (LEAF_ROWS as usize - 1) * LANES + lane, id);
        }
        leaf_link(row, items.len() as u32)
    }

    /// Sorts the items into two to eight parts.
    fn divide(items: &mut [Item], depth: u32) -> heapless::Vec<Part, LANES> {
        let mut parts = heapless::Vec::new();
        let count = items.len();
        if parts.push(Part::of(items, 0, count)).is_err() {
            return parts;
        }
        while parts.len() < LANES {
            // The part whose triangles cost most.
            let mut costliest: Option<(f64, usize)> = None;
            for (at, part) in parts.iter().enumerate() {
                let cost = surface(part.bounds.extent()) * tests(part.count());
                if part.count() > LANES && costliest.is_none_or(|(most, _)| cost > most) {
                    costliest = Some((cost, at));
                }
            }
            let Some(part) = costliest.and_then(|(_, at)| parts.get_mut(at)) else {
                break;
            };
            let Some(run) = items.get_mut(part.from..part.to) else { break };
            let middle = if depth >= BALANCED_FROM { run.len() / 2 } else { Self::halve(run) };
            let (from, middle, to) = (part.from, part.from + middle, part.to);
            *part = Part::of(items, from, middle);
            if parts.push(Part::of(items, middle, to)).is_err() {
                break;
            }
        }
        parts
    }

    /// Divides more than eight items in two by the least estimated cost, and returns the length of the
    /// first part; in equal parts where no plane tells them apart.
    fn halve(items: &mut [Item]) -> usize {
        let middles = items.iter().fold(Aabb::EMPTY, |all, item| all.with_point(item.middle()));
        let (lo, extent) = (middles.lo.to_array(), middles.extent());
        let bin_of = |item: &Item, axis: usize| {
            let middle = item.middle().to_array();
            let (Some(&m), Some(&lo), Some(&width)) =
                (middle.get(axis), lo.get(axis), extent.get(axis))
            else {
                return 0;
            };
            // The cast saturates, and takes a NaN (0 / 0) to 0.
            (((f64::from(m) - f64::from(lo)) / width * BINS as f64) as usize).min(BINS - 1)
        };

        let mut best: Option<(f64, usize, usize)> = None;
        for axis in 0..3 {
            let mut counts = [0_usize; BINS];
            let mut boxes = [Aabb::EMPTY; BINS];
            for item in items.iter() {
                let bin = bin_of(item, axis);
                if let (Some(count), Some(bounds)) = (counts.get_mut(bin), boxes.get_mut(bin)) {
                    *count += 1;
                    *bounds = bounds.union(item.bounds);
                }
            }
            let mut below = [0.0; BINS];
            let (mut sum, mut part) = (0, Aabb::EMPTY);
            for ((cost, &count), bounds) in below.iter_mut().zip(&counts).zip(&boxes) {
                sum += count;
                part = part.union(*bounds);
                *cost = surface(part.extent()) * tests(sum);
            }
            let (mut sum, mut part) = (0, Aabb::EMPTY);
            for (bin, ((&count, bounds), below)) in
                (1..BINS).zip(counts.iter().zip(&boxes).skip(1).zip(&below)).rev()
            {
                sum += count;
                part = part.union(*bounds);
                let cost = below + surface(part.extent()) * tests(sum);
                let divides = sum > 0 && sum < items.len();
                if divides && best.is_none_or(|(least, _, _)| cost < least) {
                    best = Some((cost, axis, bin));
                }
            }
        }
        let Some((_, axis, bin)) = best else {
            return items.len() / 2;
        };
        // Those below to the front, those above to the back.
        let (mut front, mut back) = (0, items.len());
        while front < back {
            if items.get(front).is_some_and(|item| bin_of(item, axis) < bin) {
                front += 1;
            } else {
                back -= 1;
                if let (Some(&a), Some(&b)) = (items.get(front), items.get(back)) {
                    if let Some(slot) = items.get_mut(front) {
                        *slot = b;
                    }
                    if let Some(slot) = items.get_mut(back) {
                        *slot = a;
                    }
                }
            }
        }
        front
    }
}
