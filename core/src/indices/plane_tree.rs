//! Binary trees of cells divided by planes across the axes: what kd-tree and BSP tree share.
//!
//! ```text
//! words:  root: a link; then the nodes in depth-first order
//! inner:  axis | plane (f32 bits) | link to the lower half | link to the upper half
//! leaf:   count | id id id ...
//! link:   place of the node, the highest bit set for a leaf; 0 for a half without triangles
//! ```
//! The root cell is the group's box. Filing and its invariant are those of `octants`, on one axis at a
//! time: a triangle that only touches the plane is filed on its own side, one that lies in the plane in
//! the lower half.
//!
//! # Source
//! M. Kaplan, *Space-Tracing: A Constant Time Ray-Tracer*, 1985; traversal as in Sung and Arvo 1992,
//! with conservative crossings instead of comparisons with an epsilon.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use super::octants::Cell;
use super::{Group, Local, Statistics};
use crate::auto::{CostModel, Estimate, best_level};
use crate::geometry::{RaySpan, Span, may_overlap};
use crate::memory::{Arena, Words, size_of_slice};
use crate::query::Query;
use crate::scene::MAX_LEVEL;
use crate::{BuildError, Level, Options};

const LEAF: u32 = 1 << 31;
const EMPTY: u32 = 0;
const MOST_WORDS: usize = 1 << 31;
const INNER_WORDS: u32 = 4;
/// Three divisions, one an axis, are one level of an octree.
const DIVISIONS_PER_LEVEL: u32 = 3;
const MAX_DEPTH: usize = (MAX_LEVEL * DIVISIONS_PER_LEVEL) as usize;

/// A plane across an axis.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub axis: usize,
    pub at: f32,
}

/// Where cells are divided.
pub(super) trait Division {
    /// Whether a division is only made if it pays by itself. Else, where the level is found
    /// automatically, it is found for the whole tree.
    const PAYS_BY_ITSELF: bool;

    /// The plane for a cell that holds some triangles, strictly inside it; `None` for a leaf.
    fn choose(
        group: &Group<'_>,
        ids: &[u32],
        cell: &Cell,
        depth: u32,
        model: &CostModel,
    ) -> Option<Plane>;
}

/// A tree of cells divided as `D` says.
pub(super) struct PlaneTree<D>(PhantomData<D>);

/// Balanced, a tree of `n` leaves is `log2 n` deep; 8 + 1.3 log2 n is the customary limit
/// (Pharr, Jakob, Humphreys, *Physically Based Rendering*).
fn customary_depth(triangle_count: usize) -> u32 {
    let log2 = usize::BITS - triangle_count.leading_zeros();
    (8 + log2 * 13 / 10).min(MAX_DEPTH as u32)
}

fn depth_at_most(triangle_count: usize, options: &Options) -> u32 {
    match options.level {
        Level::AtMost(level) => level.min(MAX_LEVEL) * DIVISIONS_PER_LEVEL,
        Level::Automatic => customary_depth(triangle_count),
    }
}

impl<D: Division> PlaneTree<D> {
    pub fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        // One list per depth, none longer than the one above.
        let depth = depth_at_most(triangle_count, options) as usize;
        let entries = triangle_count.saturating_mul(depth + 1);
        size_of_slice::<u32>(entries).saturating_add(size_of_slice::<u8>(entries))
    }

    pub fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let count = group.ids.len();
        let most_depth = depth_at_most(count, options);
        let entries = count.saturating_mul(most_depth as usize + 1);
        let needed = Self::scratch_bytes(count, options);
        let full = BuildError::ScratchFull { needed, given: scratch.len() };
        let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        let ids = arena.take::<u32>(entries).ok_or(full)?;
        let sides = arena.take::<u8>(entries).ok_or(full)?;
        for (slot, &id) in ids.iter_mut().zip(group.ids) {
            *slot = id;
        }
        let root = Cell::of(&group.bounds);
        let automatic = options.level == Level::Automatic;
        let mut attempt = |most_depth: u32, words: &mut Words<'_>| {
            let start = words.len();
            let link_place = words.push(0);
            let mut builder = Builder::<D> {
                group,
                options,
                // Where each division has to pay for itself, the capacity has nothing to add.
                leaf_capacity: if automatic && D::PAYS_BY_ITSELF {
                    1
                } else {
                    options.leaf_capacity
                },
                most_depth,
                root_surface: root.surface_within(&group.bounds),
                estimate: Estimate::new(&options.cost_model()),
                words,
                start,
                ids: &mut *ids,
                sides: &mut *sides,
                division: PhantomData,
            };
            let link = builder.node(0, count, root, 0)?;
            let cost = builder.estimate.total();
            words.set(link_place, link);
            Ok(cost)
        };
        let depth = if automatic && !D::PAYS_BY_ITSELF {
            let most_level = most_depth / DIVISIONS_PER_LEVEL;
            let cost_at = |level| attempt(level * DIVISIONS_PER_LEVEL, &mut Words::new(&mut []));
            best_level(most_level, cost_at)? * DIVISIONS_PER_LEVEL
        } else {
            most_depth
        };
        attempt(depth, words)?;
        Ok(())
    }

    pub fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        // One postponed half for each depth.
        let mut stack = heapless::Vec::<(u32, Span), { MAX_DEPTH + 1 }>::new();
        let mut next = Some((local.word(0), span));
        while let Some((link, span)) = next.or_else(|| stack.pop()) {
            next = None;
            if link == EMPTY || span.from > query.last() {
                continue;
            }
            query.enter();
            let place = link & !LEAF;
            if link & LEAF != 0 {
                local.test(place + 1, local.word(place), query)?;
                continue;
            }
            let axis = local.word(place) as usize;
            let plane = f64::from(f32::from_bits(local.word(place + 1)));
            let (lower, upper) = (local.word(place + 2), local.word(place + 3));
            let downwards = ray.sign_mask() >> axis & 1 == 1;
            let (near, far) = if downwards { (upper, lower) } else { (lower, upper) };
            let crossing = ray.crossing(axis, plane);
            let near_to = if crossing.latest < span.to { crossing.latest } else { span.to };
            let far_from =
                if crossing.earliest > span.from { crossing.earliest } else { span.from };
            if far_from <= span.to && far != EMPTY {
                let pushed = stack.push((far, Span { from: far_from, to: span.to })).is_ok();
                debug_assert!(pushed, "validation bounds the depth");
            }
            if span.from <= near_to {
                next = Some((near, Span { from: span.from, to: near_to }));
            }
        }
        ControlFlow::Continue(())
    }

    pub fn check(local: &Local<'_>) -> Option<Statistics> {
        let mut statistics = Statistics::default();
        // The halves still to follow, with their depth.
        let mut stack = heapless::Vec::<(u32, u32), { MAX_DEPTH + 2 }>::new();
        let mut end = 1;
        stack.push((local.word(0), 0)).ok()?;
        while let Some((link, depth)) = stack.pop() {
            if link == EMPTY {
                continue;
            }
            // Depth-first order: each node begins where the one before ended.
            if link & !LEAF != end {
                return None;
            }
            let head = local.word(end);
            if link & LEAF != 0 {
                if head == 0 || !local.are_ids(end + 1, head) {
                    return None;
                }
                statistics.add_leaf(head, depth.div_ceil(DIVISIONS_PER_LEVEL));
                end = end.checked_add(1 + head)?;
            } else {
                let plane = f32::from_bits(local.word(end + 1));
                if head > 2 || !plane.is_finite() || depth as usize >= MAX_DEPTH {
                    return None;
                }
                statistics.inner_nodes += 1;
                stack.push((local.word(end + 3), depth + 1)).ok()?;
                stack.push((local.word(end + 2), depth + 1)).ok()?;
                end = end.checked_add(INNER_WORDS)?;
            }
        }
        (end as usize == local.words.len()).then_some(statistics)
    }
}

const LOWER: u8 = 1;
const UPPER: u8 = 2;

struct Builder<'b, 'g, 'w, D> {
    group: &'b Group<'g>,
    options: &'b Options,
    leaf_capacity: u32,
    most_depth: u32,
    root_surface: f64,
    estimate: Estimate,
    words: &'b mut Words<'w>,
    /// The word from which links count.
    start: usize,
    /// The lists of the cells on the way down, one after the other, and the sides of each entry.
    ids: &'b mut [u32],
    sides: &'b mut [u8],
    division: PhantomData<D>,
}

impl<D: Division> Builder<'_, '_, '_, D> {
    /// Appends the node of the list `from..to` and returns the link to it. As deep a recursion as the
    /// tree, at most 60.
    fn node(&mut self, from: usize, to: usize, cell: Cell, depth: u32) -> Result<u32, BuildError> {
        if from == to {
            return Ok(EMPTY);
        }
        let place = self.words.len() - self.start;
        if place.saturating_add(to - from) >= MOST_WORDS {
            return Err(BuildError::TooLarge);
        }
        let surface = cell.surface_within(&self.group.bounds);
        // A group on a line has no surface; every ray that meets it meets all of it.
        let probability = if self.root_surface > 0.0 { surface / self.root_surface } else { 1.0 };
        self.estimate.add_node(probability);
        let list = self.ids.get(from..to).unwrap_or(&[]);
        let few = list.len() <= self.leaf_capacity as usize;
        let plane = if few || depth >= self.most_depth {
            None
        } else {
            D::choose(self.group, list, &cell, depth, &self.options.cost_model())
        };
        let Some(plane) = plane else {
            self.estimate.add_tests(probability, list.len());
            self.words.push(list.len() as u32);
            self.words.extend(list);
            return Ok(place as u32 | LEAF);
        };

        let halves = cell.halves(plane.axis, f64::from(plane.at));
        for at in from..to {
            let sides = self.sides_of(at, plane, &halves);
            if let Some(slot) = self.sides.get_mut(at) {
                *slot = sides;
            }
        }
        self.words.push(plane.axis as u32);
        self.words.push(plane.at.to_bits());
        let links = self.words.push(EMPTY);
        self.words.push(EMPTY);
        for (side, half, link_place) in [(LOWER, halves[0], links), (UPPER, halves[1], links + 1)] {
            let mut end = to;
            for at in from..to {
                let inside = self.sides.get(at).is_some_and(|sides| sides & side != 0);
                if inside && let Some(&id) = self.ids.get(at) {
                    if let Some(slot) = self.ids.get_mut(end) {
                        *slot = id;
                    }
                    end += 1;
                }
            }
            let link = self.node(to, end, half, depth + 1)?;
            self.words.set(link_place, link);
        }
        Ok(place as u32)
    }

    /// On which sides of a plane a triangle is to be filed.
    fn sides_of(&self, at: usize, plane: Plane, halves: &[Cell; 2]) -> u8 {
        let id = self.ids.get(at).copied().unwrap_or(0) as usize;
        let Some(triangle) = self.group.triangles.get(id) else {
            return 0;
        };
        let bounds = triangle.bounds();
        let (lo, hi) = match plane.axis {
            0 => (bounds.lo.x, bounds.hi.x),
            1 => (bounds.lo.y, bounds.hi.y),
            _ => (bounds.lo.z, bounds.hi.z),
        };
        let upper = hi > plane.at;
        let lower = !upper || lo < plane.at;
        if !(upper && lower) {
            return if upper { UPPER } else { LOWER };
        }
        let reaches = |half: &Cell| may_overlap(triangle, half.lo, half.hi);
        let [below, above] = halves;
        (if reaches(below) { LOWER } else { 0 }) | (if reaches(above) { UPPER } else { 0 })
    }
}
