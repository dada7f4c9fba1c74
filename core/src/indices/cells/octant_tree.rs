//! Trees of cells with up to eight children: shared by the octree and the octree-R.
//!
//! ```text
//! words:  root: a link; then the nodes in depth-first order
//! inner:  child mask, and a bit for each axis that is divided | the planes, if stored | link to each present child
//! leaf:   count      | id id id ...
//! link:   offset of the node, the highest bit set for a leaf
//! ```
//! - Octant bit 0 is set for the upper half in x, bit 1 in y, bit 2 in z.
//! - An axis may be left undivided; its bit is then 0 in all children.
//! - The root cell is the group's box.
//! - Build and traversal compute or store the same planes in `f32`, so a cell is the same closed box for both.
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
//! 4. The part of the ray in each of the eight octants is computed at once, in lanes, instead of the next octant again
//!    and again.
//!
//! Cells are visited in the order of their octants with flipped bits, which is front to back.
//!
//! # What lost
//! - Going on with the first child at once, so that only the others wait in a frame: 1 to 6% slower.
//! - Testing a leaf where its parent's frame is, so that only inner nodes are entered: up to 3% slower.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use arrayvec::ArrayVec;
use glam::{Vec4, Vec4Swizzles};

use super::filing::{
    Cell, Division, Filing, LEAF, LevelSearch, List, Lists, Planes, most_references,
};
use crate::error::BuildError;
use crate::geometry::{Numbers, RaySpan, Span};
use crate::indices::depth_first::{CheckedNode, check_depth_first, check_leaf};
use crate::input::{Level, MAX_LEVEL, Options};
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

/// The bits of an inner node's first word that say which axes are divided.
pub(super) const AXES: u32 = 0b111 << AXES_SHIFT;
pub(super) const AXES_SHIFT: u32 = 8;

/// Policy that chooses where cells are divided.
pub trait OctantPolicy: 'static {
    /// True if nodes store their planes; if false, planes follow from the cell.
    const STORES_PLANES: bool;
    /// The number of looks at each triangle that choosing planes takes.
    const LOOKS: u64;

    /// Chooses the planes for a cell that holds some triangles, strictly inside it; all `None` for a leaf.
    fn choose(group: &Group<'_>, ids: &[u32], cell: &Cell, options: &Options) -> Planes;

    /// Computes or reads the planes of an inner node, as `choose` gave them; NaN for an undivided axis. The cell is
    /// given by its corners.
    fn planes(local: &Local<'_>, offset: u32, head: u32, cell: (Vec4, Vec4)) -> Vec4;

    /// The number of words that the planes take in a node with this first word.
    fn stored(head: u32) -> u32 {
        if Self::STORES_PLANES { (head & AXES).count_ones() } else { 0 }
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
        let mut lists = Lists::new(group.ids.len(), levels_at_most(options), scratch)?;
        let root = Cell::of(&group.bounds);
        let most_references = most_references(group.ids.len(), options);
        let most_level = match options.level {
            Level::AtMost(level) => level,
            Level::Automatic => {
                let search = LevelSearch {
                    group,
                    model: options.cost_model(),
                    leaf_capacity: options.leaf_capacity,
                    most_references,
                    most_depth: MAX_AUTOMATIC_LEVEL,
                    depths_per_level: 1,
                    looks: P::LOOKS,
                };
                search.run(&mut lists, &root, words, |ids, cell, _| {
                    P::choose(group, ids, cell, options)
                })?
            }
        };
        Filing::write(group, &mut lists, words, |filing, list| {
            let division = PhantomData;
            OctantBuilder::<P> { filing, options, most_level, division }.node(
                list,
                root,
                0,
                most_references,
            )
        })
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        let mut stack = ArrayVec::<Frame, LEVELS>::new();
        let sign_mask = ray.sign_mask() as u32;
        let root = local.bounds;
        let mut cell = (root.lo.extend(0.0), root.hi.extend(0.0));
        let (mut link, mut span) = (local.word(0), span);
        loop {
            // 1. Enter a node: test the triangles of a leaf, or find the children of an inner node that the ray may
            // touch.
            query.enter();
            let offset = link & !LEAF;
            let head = local.word(offset);
            if link & LEAF != 0 {
                local.test(offset + 1, head, ray, query)?;
            } else {
                let planes = P::planes(local, offset, head, cell);
                let octants = Octants::new(ray.crossings(planes), span);
                let links = offset + 1 + P::stored(head);
                let mask = head & 0xff;
                let pending = octants.met & flipped(mask, sign_mask);
                if pending != 0 {
                    let frame = Frame { cell, planes, octants, links, mask, pending };
                    let pushed = stack.try_push(frame).is_ok();
                    debug_assert!(pushed, "validation bounds the depth");
                }
            }
            // 2. Go on with the next child, of the lowest node that has one.
            (link, cell, span) = loop {
                let Some(frame) = stack.last_mut() else {
                    return ControlFlow::Continue(());
                };
                let at = frame.pending.trailing_zeros();
                frame.pending &= frame.pending.wrapping_sub(1);
                let octant = at ^ sign_mask;
                let span = frame.octants.span(at);
                let next = (span.from <= ray.last(query.last_t()))
                    .then(|| (local.word(frame.link_of(octant)), frame.cell_of(octant), span));
                if frame.pending == 0 {
                    stack.pop();
                }
                if let Some(next) = next {
                    break next;
                }
            };
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
                let divided = axes & !AXES == 0 && axes != 0;
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

/// Parts of a ray in the eight octants of a node, by flipped octant.
struct Octants {
    from: [Vec4; 2],
    to: [Vec4; 2],
    /// The octants that the ray may touch, one bit each.
    met: u32,
}

impl Octants {
    /// Divides a part of a ray by its crossings of the planes, the earliest and the latest. In the half of an axis that
    /// is entered first, the ray is up to the latest crossing; in the other half, from the earliest on.
    #[inline]
    fn new([earliest, latest]: [Vec4; 2], span: Span) -> Self {
        // The fourth lane is NaN, as are those of planes that bound nothing: there, the span itself.
        let from = earliest.larger(Vec4::splat(span.from));
        let to = latest.smaller(Vec4::splat(span.to));
        // Four octants by their halves in x and y: those of the near half in z, then those of the far half.
        let (from_near, to_far) = (from.wxwx().larger(from.wwyy()), to.xwxw().smaller(to.yyww()));
        let (from_far, to_near) = (from_near.larger(from.zzzz()), to_far.smaller(to.zzzz()));
        let missed = from_near.above(to_near) | from_far.above(to_far) << 4;
        Self { from: [from_near, from_far], to: [to_near, to_far], met: !missed & 0xff }
    }

    /// The part of the ray in an octant.
    #[inline]
    fn span(&self, flipped: u32) -> Span {
        let of = |halves: &[Vec4; 2]| {
            let numbers: &[f32; 8] = bytemuck::must_cast_ref(halves);
            numbers[flipped as usize % 8]
        };
        Span { from: of(&self.from), to: of(&self.to) }
    }
}

/// Inner node on the way down, with children still to be visited.
struct Frame {
    /// The lower and the upper corner.
    cell: (Vec4, Vec4),
    planes: Vec4,
    octants: Octants,
    /// The offset of the first link.
    links: u32,
    /// The children that exist, by octant.
    mask: u32,
    /// Children that the ray may touch and that were not visited, by flipped octant.
    pending: u32,
}

impl Frame {
    /// The offset of the link to a child.
    #[inline]
    fn link_of(&self, octant: u32) -> u32 {
        let before = self.mask & ((1 << octant) - 1);
        self.links + u32::from(ONES[before as usize % ONES.len()])
    }

    /// The cell of a child.
    #[inline]
    fn cell_of(&self, octant: u32) -> (Vec4, Vec4) {
        let upper = UPPER_HALF[octant as usize % 8].cmpgt(Vec4::ZERO);
        let (lo, hi) = self.cell;
        // An undivided axis has no upper half, and its plane is NaN.
        (Vec4::select(upper, self.planes, lo), Vec4::select(upper, hi, self.planes.smaller(hi)))
    }
}

/// A mask of octants by flipped octant: bit `octant ^ sign_mask` is bit `octant` of `mask`.
#[inline]
fn flipped(mask: u32, sign_mask: u32) -> u32 {
    // Bit `axis` of the sign mask exchanges neighbouring groups of 2^axis bits.
    let exchanged = |mask: u32, axis: u32, lower: u32| {
        let difference =
            (mask >> (1 << axis) ^ mask) & lower & (sign_mask >> axis & 1).wrapping_neg();
        mask ^ difference ^ difference << (1 << axis)
    };
    exchanged(exchanged(exchanged(mask, 0, 0x55), 1, 0x33), 2, 0x0f)
}

/// The number of bits that are set in each byte. A table, because many processors have no instruction that counts bits;
/// there, reading is faster.
const ONES: [u8; 256] = {
    let mut ones = [0; 256];
    let mut byte = 1;
    while byte < 256 {
        ones[byte] = (byte as u32).count_ones() as u8;
        byte += 1;
    }
    ones
};

/// For each octant, 1 on the axes on which it is the upper half.
const UPPER_HALF: [Vec4; 8] = {
    let mut octants = [Vec4::ZERO; 8];
    let mut octant = 0;
    while octant < 8 {
        let [x, y, z] = [octant & 1, octant >> 1 & 1, octant >> 2];
        octants[octant] = Vec4::new(x as f32, y as f32, z as f32, 0.0);
        octant += 1;
    }
    octants
};

struct OctantBuilder<'f, 'b, 'g, 's, 'w, P> {
    filing: &'f mut Filing<'b, 'g, 's, 'w>,
    options: &'f Options,
    most_level: u32,
    division: PhantomData<P>,
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
        let offset = self.filing.begin(list)?;
        let few = list.len() <= self.options.leaf_capacity as usize;
        let planes = if few || level >= self.most_level {
            [None; 3]
        } else {
            self.filing.words.spend(P::LOOKS * list.len() as u64)?;
            let ids = self.filing.ids(list);
            P::choose(self.filing.group, ids, &cell, self.options)
        };
        if planes == [None; 3] {
            return Ok(self.filing.leaf(list, offset));
        }
        // 2. Find the octants of each triangle, unless there would be too many references.
        let division = Division::new(&cell, &planes);
        let Some(parts) = self.filing.mark(list, most_references, &division)? else {
            return Ok(self.filing.leaf(list, offset));
        };
        let mask = parts.mask;

        // 3. Append the node, with links to be set later; then each child.
        let mut axes = 0;
        for (axis, plane) in planes.iter().enumerate() {
            axes |= u32::from(plane.is_some()) << (axis as u32 + AXES_SHIFT);
        }
        self.filing.words.push(u32::from(mask) | axes);
        if P::STORES_PLANES {
            for plane in planes.iter().flatten() {
                self.filing.words.push((*plane as f32).to_bits());
            }
        }
        let links = self.filing.words.reserve(mask.count_ones() as usize);
        let present = (0..8).filter(|octant| mask >> octant & 1 == 1);
        for (link_offset, octant) in (links..).zip(present) {
            let part = self.filing.gather(list, octant);
            let child = cell.child(&planes, octant);
            let link = self.node(part, child, level + 1, parts.share(part.len()))?;
            self.filing.words.set(link_offset, link);
        }
        Ok(offset)
    }
}
