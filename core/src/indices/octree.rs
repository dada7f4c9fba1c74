//! The octree: cells halved along all three axes until few triangles are left in each.
//!
//! ```text
//! words:  root: a link; then the nodes in depth-first order
//! inner:  child mask | link to each present child, by octant     octant bit 0 = upper half in x, ...
//! leaf:   count      | id id id ...
//! link:   place of the node, the highest bit set for a leaf
//! ```
//! The root cell is a cube at the lower corner of the group's box: cells stay cubes, and what is flat
//! lies on one face of the cube rather than in the middle. Planes are `f64` midpoints; building and
//! walking compute them alike, so a cell is the same closed box for both.
//!
//! # Invariants
//! Every point of a triangle lies in a leaf cell in which the triangle is filed. By induction from the
//! root: let a point lie in a cell where its triangle is filed. On each axis choose a half that holds
//! it; on the plane itself, the upper half if the triangle reaches above, else the lower. In that half
//! the triangle is filed by extent, and the overlap test never rejects a box that shares a point.
//! The walk visits every non-empty cell the ray may touch, so it meets that leaf.
//!
//! # Source
//! J. Revelles, C. Ureña, M. Lastra, *An Efficient Parametric Algorithm for Octree Traversal*, 2000.
//! Deviations: (1) instead of reflecting a ray that runs downwards about the centre, which rounds, near
//! and far planes are exchanged and the octant's bits flipped, which does not; (2) each plane's
//! parameter is computed from its coordinate, not by averaging its neighbours', so that errors do not
//! grow with the level; (3) where crossings of several planes are too close to tell their order, all
//! cells that may come next are visited, not one. Cells are visited in the order of their octant with
//! flipped bits, which is front to back.

use core::ops::ControlFlow;

use super::{Group, Local, LocalIndex, Statistics};
use crate::geometry::{Aabb, RaySpan, Span, may_overlap};
use crate::memory::{Arena, Words, size_of_slice};
use crate::query::Query;
use crate::scene::MAX_LEVEL;
use crate::{BuildError, Level, Options};

/// The octree, alone or as the local index of the octree hierarchy.
pub enum Octree {}

const LEAF: u32 = 1 << 31;
/// Links have 31 bits.
const MOST_WORDS: usize = 1 << 31;
const LEVELS: usize = MAX_LEVEL as usize + 1;

/// A closed cell.
#[derive(Clone, Copy)]
struct Cell {
    lo: [f64; 3],
    hi: [f64; 3],
}

impl Cell {
    /// The cube at the lower corner of a box that holds it.
    fn root(bounds: &Aabb) -> Self {
        let side = bounds.extent().into_iter().fold(0.0, |a, b| if b > a { b } else { a });
        let lo = bounds.lo.to_array().map(f64::from);
        let hi = bounds.hi.to_array().map(f64::from);
        // `lo + side` may round to less than `hi`.
        let upper = |axis: usize| {
            let (sum, hi) = (lo[axis] + side, hi[axis]);
            if sum > hi { sum } else { hi }
        };
        Self { lo, hi: [upper(0), upper(1), upper(2)] }
    }

    fn middle(&self) -> [f64; 3] {
        let middle = |axis: usize| (self.lo[axis] + self.hi[axis]) * 0.5;
        [middle(0), middle(1), middle(2)]
    }

    /// Tells whether all three middles lie strictly inside.
    fn is_divisible(&self) -> bool {
        let m = self.middle();
        (0..3).all(|axis| self.lo[axis] < m[axis] && m[axis] < self.hi[axis])
    }

    fn child(&self, octant: u32) -> Self {
        let middle = self.middle();
        let mut child = *self;
        for (axis, &m) in middle.iter().enumerate() {
            if octant >> axis & 1 == 0 {
                child.hi[axis] = m;
            } else {
                child.lo[axis] = m;
            }
        }
        child
    }
}

/// The highest level for so many triangles: surfaces fill about `4^level` cells of level `level`,
/// so this is where leaves reach their capacity, and one more for uneven scenes.
fn most_level(triangle_count: usize, options: &Options) -> u32 {
    match options.level {
        Level::AtMost(level) => level.min(MAX_LEVEL),
        Level::Automatic => {
            let leaves = triangle_count as u64 / u64::from(options.leaf_capacity.max(1));
            ((64 - leaves.leading_zeros()).div_ceil(2) + 1).min(MAX_LEVEL)
        }
    }
}

impl LocalIndex for Octree {
    const NAME: &'static str = "octree";
    const HIERARCHY_NAME: &'static str = "octree-hierarchy";
    const KIND: u32 = 2;

    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        // One list per level, none longer than the one above.
        let entries =
            triangle_count.saturating_mul(most_level(triangle_count, options) as usize + 1);
        size_of_slice::<u32>(entries).saturating_add(size_of_slice::<u8>(entries))
    }

    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let most_level = most_level(group.ids.len(), options);
        let entries = group.ids.len().saturating_mul(most_level as usize + 1);
        let given = scratch.len();
        let full =
            BuildError::ScratchFull { needed: Self::scratch_bytes(group.ids.len(), options), given };
        let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        let ids = arena.take::<u32>(entries).ok_or(full)?;
        let octants = arena.take::<u8>(entries).ok_or(full)?;
        for (slot, &id) in ids.iter_mut().zip(group.ids) {
            *slot = id;
        }
        let start = words.len();
        let root = words.push(0);
        let mut builder = Builder { group, options, most_level, words, start, ids, octants };
        let link = builder.node(0, group.ids.len(), Cell::root(&group.bounds), 0)?;
        words.set(root, link);
        Ok(())
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let mut stack = heapless::Vec::<Frame, LEVELS>::new();
        let root = Cell::root(&local.bounds);
        let mut entered = enter(local, ray, span, query, local.word(0), root)?;
        loop {
            if let Some(frame) = entered.take() {
                let pushed = stack.push(frame).is_ok();
                debug_assert!(pushed, "validation bounds the depth");
            }
            let Some(frame) = stack.last_mut() else {
                return ControlFlow::Continue(());
            };
            let Some((octant, span)) = frame.next(ray.sign_mask() as u32) else {
                stack.pop();
                continue;
            };
            if span.from > query.last() {
                continue;
            }
            let link = local.word(frame.link_of(octant));
            let cell = frame.cell.child(octant);
            entered = enter(local, ray, span, query, link, cell)?;
        }
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let mut statistics = Statistics::default();
        let mut next = 1;
        // The links still to follow, by level.
        let mut stack = heapless::Vec::<(u32, u32), LEVELS>::new();
        let mut link = local.word(0);
        loop {
            // Depth-first order: each node begins where the one before ended.
            if link & !LEAF != next {
                return None;
            }
            let head = local.word(next);
            if link & LEAF != 0 {
                if head == 0 || !local.are_ids(next + 1, head) {
                    return None;
                }
                statistics.add_leaf(head, stack.len() as u32);
                next = next.checked_add(1 + head)?;
            } else {
                if head == 0 || head > 0xff || stack.push((next + 1, head.count_ones())).is_err() {
                    return None;
                }
                statistics.inner_nodes += 1;
                next += 1 + head.count_ones();
            }
            // To the next child of the deepest node that has one left.
            loop {
                let Some((place, left)) = stack.last_mut() else {
                    return (next as usize == local.words.len()).then_some(statistics);
                };
                if *left > 0 {
                    link = local.word(*place);
                    *place += 1;
                    *left -= 1;
                    break;
                }
                stack.pop();
            }
        }
    }
}

/// An inner node on the way down.
struct Frame {
    cell: Cell,
    place: u32,
    mask: u32,
    /// Cells not yet looked at, by octant with flipped bits.
    pending: u32,
    span: Span,
    /// Where each half begins and ends along the ray: `[axis][0]` is the half entered first.
    near_end: [f64; 3],
    far_start: [f64; 3],
}

impl Frame {
    /// The next cell that the ray may touch, front to back.
    #[inline]
    fn next(&mut self, sign_mask: u32) -> Option<(u32, Span)> {
        while self.pending != 0 {
            let flipped = self.pending.trailing_zeros();
            self.pending &= self.pending - 1;
            let octant = flipped ^ sign_mask;
            if self.mask >> octant & 1 == 0 {
                continue;
            }
            let mut span = self.span;
            for axis in 0..3 {
                if flipped >> axis & 1 == 0 {
                    let end = self.near_end[axis];
                    span.to = if end < span.to { end } else { span.to };
                } else {
                    let start = self.far_start[axis];
                    span.from = if start > span.from { start } else { span.from };
                }
            }
            if !span.is_empty() {
                return Some((octant, span));
            }
        }
        None
    }

    /// Where the link to a present child lies.
    #[inline]
    fn link_of(&self, octant: u32) -> u32 {
        self.place + 1 + (self.mask & ((1 << octant) - 1)).count_ones()
    }
}

/// Enters a node: tests a leaf's triangles, or returns the frame of an inner node.
#[inline]
fn enter<Q: Query>(
    local: &Local<'_>,
    ray: &RaySpan,
    span: Span,
    query: &mut Q,
    link: u32,
    cell: Cell,
) -> ControlFlow<(), Option<Frame>> {
    query.enter();
    let place = link & !LEAF;
    let head = local.word(place);
    if link & LEAF != 0 {
        local.test(place + 1, head, query)?;
        return ControlFlow::Continue(None);
    }
    let middle = cell.middle();
    let crossings = [
        ray.crossing(0, middle[0]),
        ray.crossing(1, middle[1]),
        ray.crossing(2, middle[2]),
    ];
    ControlFlow::Continue(Some(Frame {
        cell,
        place,
        mask: head,
        pending: 0xff,
        span,
        near_end: crossings.map(|c| c.latest),
        far_start: crossings.map(|c| c.earliest),
    }))
}

struct Builder<'b, 'g, 'w> {
    group: &'b Group<'g>,
    options: &'b Options,
    most_level: u32,
    words: &'b mut Words<'w>,
    /// The word from which links count.
    start: usize,
    /// The lists of the cells on the way down, one after the other, and the octants of each entry.
    ids: &'b mut [u32],
    octants: &'b mut [u8],
}

impl Builder<'_, '_, '_> {
    /// Appends the node of the list `from..to` and returns the link to it. As deep a recursion as
    /// levels, at most 21.
    fn node(&mut self, from: usize, to: usize, cell: Cell, level: u32) -> Result<u32, BuildError> {
        let place = self.words.len() - self.start;
        if place.saturating_add(to - from) >= MOST_WORDS {
            return Err(BuildError::TooLarge);
        }
        let few = to - from <= self.options.leaf_capacity as usize;
        if few || level >= self.most_level || !cell.is_divisible() {
            self.words.push((to - from) as u32);
            self.words.extend(self.ids.get(from..to).unwrap_or(&[]));
            return Ok(place as u32 | LEAF);
        }

        // 1. In which octants does each triangle lie?
        let mut mask = 0;
        for at in from..to {
            let octants = self.octants_of(at, &cell);
            mask |= octants;
            if let Some(slot) = self.octants.get_mut(at) {
                *slot = octants;
            }
        }

        // 2. The node, with links to be filled in; then each child, with its list behind ours.
        self.words.push(u32::from(mask));
        let links = self.words.len();
        for _ in 0..mask.count_ones() {
            self.words.push(0);
        }
        let mut link_place = links;
        for octant in (0..8).filter(|octant| mask >> octant & 1 == 1) {
            let mut end = to;
            for at in from..to {
                let inside = self.octants.get(at).is_some_and(|o| o >> octant & 1 == 1);
                if inside && let Some(&id) = self.ids.get(at) {
                    if let Some(slot) = self.ids.get_mut(end) {
                        *slot = id;
                    }
                    end += 1;
                }
            }
            let link = self.node(to, end, cell.child(octant), level + 1)?;
            self.words.set(link_place, link);
            link_place += 1;
        }
        Ok(place as u32)
    }

    /// One bit for each octant in which a triangle is to be filed.
    fn octants_of(&self, at: usize, cell: &Cell) -> u8 {
        let id = self.ids.get(at).copied().unwrap_or(0) as usize;
        let Some(triangle) = self.group.triangles.get(id) else {
            return 0;
        };
        let bounds = triangle.bounds();
        let (lo, hi) = (bounds.lo.to_array(), bounds.hi.to_array());
        let middle = cell.middle();
        // Bit 0: the lower half holds some of it, bit 1: the upper half. What only touches the
        // plane from one side is filed on that side, what lies in the plane in the lower half.
        let mut octants = 0xff_u8;
        for axis in 0..3 {
            const UPPER: [u8; 3] = [0b1010_1010, 0b1100_1100, 0b1111_0000];
            let upper = f64::from(hi[axis]) > middle[axis];
            let lower = f64::from(lo[axis]) < middle[axis] || !upper;
            octants &= if upper { 0xff } else { !UPPER[axis] };
            octants &= if lower { 0xff } else { UPPER[axis] };
        }
        if octants.count_ones() == 1 {
            return octants;
        }
        for octant in 0..8 {
            if octants >> octant & 1 == 1 {
                let child = cell.child(octant);
                if !may_overlap(triangle, child.lo, child.hi) {
                    octants &= !(1 << octant);
                }
            }
        }
        octants
    }
}
