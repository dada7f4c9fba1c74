//! Trees of cells with up to eight children: shared by the octree and the octree-R.
//!
//! ```text
//! words:  root: a link; then the nodes in depth-first order
//! inner:  child mask | the planes, if stored | link to each present child, by octant
//! leaf:   count      | id id id ...
//! link:   offset of the node, the highest bit set for a leaf
//! ```
//! - Octant bit 0 is set for the upper half in x, bit 1 in y, bit 2 in z.
//! - An axis may be left undivided; its bit is then 0 in all children.
//! - The root cell is a cube at the lower corner of the group's box. So cells stay cubes where they are halved, and a
//!   flat group lies on one face of the cube rather than in the middle.
//! - Build and traversal compute or store the same planes, so a cell is the same closed box for both.
//!
//! # Invariants
//! Every point of a triangle lies in a leaf cell in which the triangle is filed. By induction from the root, let a
//! point lie in a cell in which its triangle is filed:
//! 1. On each axis choose a half that holds the point; for a point on the plane, the upper half if the triangle reaches
//!    above the plane, else the lower.
//! 2. By its extent, the triangle is filed in that half.
//! 3. The overlap test never rejects a box that shares a point with the triangle.
//!
//! The traversal visits every non-empty cell that the ray may touch, so it meets that leaf.
//!
//! # Source
//! J. Revelles, C. Ureña, M. Lastra, *An Efficient Parametric Algorithm for Octree Traversal*, 2000.
//! Deviations:
//! 1. A ray that runs downwards is not reflected about the centre, because that rounds. Instead, near and far planes
//!    are exchanged and the octant's bits flipped, which does not round.
//! 2. Each plane's parameter is computed from its coordinate, not by averaging its neighbours', so that errors do not
//!    grow with the level.
//! 3. Where crossings of several planes are too close to tell their order, all cells that may come next are visited,
//!    not one.
//!
//! Cells are visited in the order of their octants with flipped bits, which is front to back.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use arrayvec::ArrayVec;

use super::cell_lists::{Filing, LEAF, List, Lists, Placement, most_references};
use super::tree_cell::Cell;
use crate::cost::{best_level, search_steps};
use crate::error::BuildError;
use crate::geometry::{AxisCrossing, RaySpan, Span, Triangle, may_overlap};
use crate::indices::depth_first::{CheckedNode, check_depth_first, check_leaf};
use crate::input::{CostModel, Level, MAX_LEVEL, Options};
use crate::memory::Words;
use crate::query::Query;
use crate::structure::{Described, Group, Local, LocalIndex, Statistics};

/// Levels of the deepest tree, the root's included.
const LEVELS: usize = MAX_LEVEL as usize + 1;
/// Highest level that the automatic level tries. A surface fills 4^12 = 16 million cells of it; scratch grows with it.
const MAX_AUTOMATIC_LEVEL: u32 = 12;

const fn levels_at_most(options: &Options) -> usize {
    let level = match options.level {
        Level::AtMost(level) => level,
        Level::Automatic => MAX_AUTOMATIC_LEVEL,
    };
    (if level < MAX_LEVEL { level } else { MAX_LEVEL }) as usize
}

/// Bounds the scratch; see [`LocalIndex::scratch_bytes`].
pub(crate) const fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
    Lists::scratch_bytes(triangle_count, levels_at_most(options))
}

/// Plane across each axis; `None` for an undivided axis.
pub type Planes = [Option<f64>; 3];

/// Policy that chooses where cells are divided.
pub trait OctantPolicy: 'static {
    /// The bits of an inner node's first word that say which axes are divided; 0 if all always are.
    const AXES: u32;
    /// The number of looks at each triangle that choosing planes takes.
    const LOOKS: u64;

    /// Chooses the planes for a cell that holds some triangles, strictly inside it; all `None` for a leaf.
    fn choose(group: &Group<'_>, ids: &[u32], cell: &Cell, model: &CostModel) -> Planes;

    /// Computes or reads the planes of an inner node, as `choose` gave them.
    fn planes(local: &Local<'_>, offset: u32, head: u32, cell: &Cell) -> Planes;

    /// The number of words that the planes take in a node with this first word.
    fn stored(head: u32) -> u32 {
        (head & Self::AXES).count_ones()
    }
}

/// Tree of cells that the policy `P` divides.
pub struct OctantTree<P>(PhantomData<P>);

impl<P: OctantPolicy> LocalIndex for OctantTree<P>
where
    Self: Described,
{
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        scratch_bytes(triangle_count, options)
    }

    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let mut lists = Lists::new(group, levels_at_most(options), scratch)?;
        let (root, model) = (Cell::root(&group.bounds), options.cost_model());
        let most_references = most_references(group.ids.len(), options);
        let mut attempt = |most_level: u32, words: &mut Words<'_>| {
            Filing::write(group, &model, &mut lists, words, &root, |filing, list| {
                let division = PhantomData;
                OctantBuilder::<P> { filing, options, most_level, division }.node(
                    list,
                    root,
                    0,
                    most_references,
                )
            })
        };
        let level = match options.level {
            Level::AtMost(level) => level,
            Level::Automatic => {
                let budget = search_steps(group.ids.len(), P::LOOKS);
                best_level(MAX_AUTOMATIC_LEVEL, budget, words, &mut attempt)?
            }
        };
        attempt(level, words)?;
        Ok(())
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let mut stack = ArrayVec::<Frame, LEVELS>::new();
        let root = Cell::root(&local.bounds);
        Self::enter(local, ray, span, query, local.word(0), root, &mut stack)?;
        loop {
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
            let cell = frame.cell.child(&frame.planes, octant);
            Self::enter(local, ray, span, query, link, cell, &mut stack)?;
        }
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let offset_of = |link| link & !LEAF;
        let root = local.word(0);
        let checked =
            check_depth_first::<{ 8 * LEVELS }>(root, 1, offset_of, |link, level, links| {
                let offset = offset_of(link);
                if link & LEAF != 0 {
                    return check_leaf(local, offset);
                }
                let head = local.word(offset);
                let (mask, axes) = (head & 0xff, head & !0xff);
                let first_link = offset.checked_add(1 + P::stored(head))?;
                let end = first_link.checked_add(mask.count_ones())?;
                let divided = axes & !P::AXES == 0 && (axes != 0 || P::AXES == 0);
                let finite =
                    (offset + 1..first_link).all(|at| f32::from_bits(local.word(at)).is_finite());
                if mask == 0 || !divided || !finite || level as usize >= LEVELS {
                    return None;
                }
                links.follow((first_link..end).map(|at| local.word(at)))?;
                Some(CheckedNode::Inner { words: end - offset })
            });
        let (statistics, end) = checked?;
        (end as usize == local.words.len()).then_some(statistics)
    }
}

impl<P: OctantPolicy> OctantTree<P> {
    /// Enters a node: tests the triangles of a leaf, or pushes the frame of an inner node.
    #[inline]
    fn enter<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
        link: u32,
        cell: Cell,
        stack: &mut ArrayVec<Frame, LEVELS>,
    ) -> ControlFlow<()> {
        query.enter();
        let offset = link & !LEAF;
        let head = local.word(offset);
        if link & LEAF != 0 {
            return local.test(offset + 1, head, query);
        }
        let planes = P::planes(local, offset, head, &cell);
        let crossing = |axis: usize| match planes[axis] {
            Some(plane) => ray.crossing(axis, plane),
            // Without a plane, both halves are the whole.
            None => AxisCrossing { earliest: f64::NEG_INFINITY, latest: f64::INFINITY },
        };
        let crossings = [crossing(0), crossing(1), crossing(2)];
        let frame = Frame {
            cell,
            planes,
            links: offset + 1 + P::stored(head),
            mask: head & 0xff,
            pending: flipped(head & 0xff, ray.sign_mask()) & reachable(&crossings, span),
            span,
            near_end: crossings.map(|c| c.latest),
            far_start: crossings.map(|c| c.earliest),
        };
        let pushed = stack.try_push(frame).is_ok();
        debug_assert!(pushed, "validation bounds the depth");
        ControlFlow::Continue(())
    }
}

/// Inner node on the way down.
struct Frame {
    cell: Cell,
    planes: Planes,
    /// The offset of the first link.
    links: u32,
    mask: u32,
    /// Children not yet visited, as octants with flipped bits.
    pending: u32,
    span: Span,
    /// The latest end of the half that is entered first, on each axis.
    near_end: [f64; 3],
    /// The earliest begin of the other half, on each axis.
    far_start: [f64; 3],
}

impl Frame {
    /// Finds the next child that the ray may touch, front to back: its octant, and the part of the ray.
    #[inline]
    fn next(&mut self, sign_mask: u32) -> Option<(u32, Span)> {
        while self.pending != 0 {
            let flipped = self.pending.trailing_zeros();
            self.pending &= self.pending - 1;
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
                return Some((flipped ^ sign_mask, span));
            }
        }
        None
    }

    /// The offset of the link to a child.
    #[inline]
    fn link_of(&self, octant: u32) -> u32 {
        self.links + (self.mask & ((1 << octant) - 1)).count_ones()
    }
}

struct OctantBuilder<'f, 'b, 'g, 's, 'w, P> {
    filing: &'f mut Filing<'b, 'g, 's, 'w>,
    options: &'f Options,
    most_level: u32,
    division: PhantomData<P>,
}

/// Masks of the octants in the half of each axis that is entered first: bit `i` stands for octant `i`, with flipped
/// bits.
const FIRST_HALF: [u32; 3] = [0b0101_0101, 0b0011_0011, 0b0000_1111];

/// Finds the octants that the ray may reach within the span, as a mask by flipped bits: on each axis, the ray has to
/// reach the octant's half.
#[inline]
fn reachable(crossings: &[AxisCrossing; 3], span: Span) -> u32 {
    let mut octants = 0xff;
    for axis in 0..3 {
        octants &= if crossings[axis].latest < span.from { !FIRST_HALF[axis] } else { 0xff };
        octants &= if crossings[axis].earliest > span.to { FIRST_HALF[axis] } else { 0xff };
    }
    octants
}

/// Renumbers a mask of octants: the bits of `sign_mask` are flipped in their numbers.
#[inline]
fn flipped(mask: u32, sign_mask: usize) -> u32 {
    let mut mask = mask;
    for (axis, first) in FIRST_HALF.into_iter().enumerate() {
        if sign_mask >> axis & 1 == 1 {
            let shift = 1 << axis;
            mask = (mask & first) << shift | (mask >> shift) & first;
        }
    }
    mask
}

impl<P: OctantPolicy> OctantBuilder<'_, '_, '_, '_, '_, P> {
    /// Appends the node of a list, and returns the link to it. The recursion is as deep as the levels, at most 21.
    fn node(
        &mut self,
        list: List,
        cell: Cell,
        level: u32,
        most_references: u64,
    ) -> Result<u32, BuildError> {
        // 1. Choose planes, unless a leaf is small enough or no level is left.
        let node = self.filing.begin(list, &cell)?;
        let few = list.len() <= self.options.leaf_capacity as usize;
        let planes = if few || level >= self.most_level {
            [None; 3]
        } else {
            self.filing.words.spend(P::LOOKS * list.len() as u64)?;
            let ids = self.filing.ids(list);
            P::choose(self.filing.group, ids, &cell, &self.options.cost_model())
        };
        if planes == [None; 3] {
            return Ok(self.filing.leaf(node));
        }
        // 2. Find the octants of each triangle, unless there would be too many references.
        let octants = |triangle: &Triangle| octants_of(triangle, &cell, &planes);
        let Some(parts) = self.filing.mark(list, most_references, octants)? else {
            return Ok(self.filing.leaf(node));
        };
        let mask = parts.mask;

        // 3. Append the node, with links to be set later; then each child.
        let mut axes = 0;
        for (axis, plane) in planes.iter().enumerate() {
            axes |= u32::from(plane.is_some()) << (axis + 8);
        }
        self.filing.words.push(u32::from(mask) | axes & P::AXES);
        if P::AXES != 0 {
            for plane in planes.iter().flatten() {
                self.filing.words.push((*plane as f32).to_bits());
            }
        }
        let links = self.filing.words.len();
        for _ in 0..mask.count_ones() {
            self.filing.words.push(0);
        }
        let present = (0..8).filter(|octant| mask >> octant & 1 == 1);
        for (link_offset, octant) in (links..).zip(present) {
            let part = self.filing.gather(list, octant);
            let child = cell.child(&planes, octant);
            let link = self.node(part, child, level + 1, parts.share(part))?;
            self.filing.words.set(link_offset, link);
        }
        Ok(node.offset)
    }
}

/// Finds the octants in which a triangle is filed.
fn octants_of(triangle: &Triangle, cell: &Cell, planes: &Planes) -> Placement {
    let bounds = triangle.bounds();
    let (lo, hi) = (bounds.lo.to_array(), bounds.hi.to_array());
    // A triangle that only touches a plane is filed on its own side; one that lies in the plane, in the lower half. On
    // an axis without a plane, everything is in the lower half.
    let mut octants = 0xff_u8;
    for axis in 0..3 {
        const UPPER: [u8; 3] = [0b1010_1010, 0b1100_1100, 0b1111_0000];
        let upper = planes[axis].is_some_and(|plane| f64::from(hi[axis]) > plane);
        let lower = !upper || planes[axis].is_some_and(|plane| f64::from(lo[axis]) < plane);
        octants &= if upper { 0xff } else { !UPPER[axis] };
        octants &= if lower { 0xff } else { UPPER[axis] };
    }
    if octants.is_power_of_two() {
        return Placement { mask: octants, steps: 1 };
    }
    let steps = 1 + octants.count_ones();
    for octant in 0..8 {
        if octants >> octant & 1 == 1 {
            let child = cell.child(planes, octant);
            if !may_overlap(triangle, child.lo, child.hi) {
                octants &= !(1 << octant);
            }
        }
    }
    Placement { mask: octants, steps }
}
