//! Binary trees of cells that are divided by planes across the axes: shared by kd-tree and BSP tree.
//!
//! ```text
//! words:  root: a link; then the nodes in depth-first order
//! inner:  axis | plane (f32 bits) | link to the lower half | link to the upper half
//! leaf:   count | id id id ...
//! link:   offset of the node, the highest bit set for a leaf; 0 for a half without triangles
//! ```
//! The root cell is the group's box. Triangles are filed as in `octant_tree`, on one axis at a time, with the same
//! invariant: a triangle that only touches the plane is filed on its own side, one that lies in the plane in the lower
//! half.
//!
//! # Source
//! M. Kaplan, *Space-Tracing: A Constant Time Ray-Tracer*, 1985; traversal as in Sung and Arvo 1992,
//! with conservative crossings instead of comparisons with an epsilon.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use super::filing::{
    Cell, Division, Filing, LEAF, LevelSearch, List, Lists, Planes, most_references,
};
use crate::error::BuildError;
use crate::geometry::{RaySpan, Span};
use crate::indices::depth_first::{CheckedNode, check_depth_first, check_leaf};
use crate::indices::ordered_traversal::walk_near_first;
use crate::input::{CostModel, Level, MAX_LEVEL, Options};
use crate::memory::Words;
use crate::query::Query;
use crate::structure::{Described, Group, Local, LocalIndex, Statistics};

/// The link of a half without triangles.
const EMPTY: u32 = 0;
const INNER_WORDS: u32 = 4;
/// Divisions a level: three, one for each axis, are as much as a level of an octree.
const DIVISIONS_PER_LEVEL: u32 = 3;
const MAX_DEPTH: usize = (MAX_LEVEL * DIVISIONS_PER_LEVEL) as usize;

/// Plane across an axis.
#[derive(Clone, Copy)]
pub struct Plane {
    pub axis: usize,
    pub at: f32,
}

impl Plane {
    /// The planes that divide a cell at this one alone, or not at all.
    fn planes(plane: Option<Self>) -> Planes {
        let mut planes = [None; 3];
        if let Some(Self { axis, at }) = plane
            && let Some(slot) = planes.get_mut(axis)
        {
            *slot = Some(f64::from(at));
        }
        planes
    }

    /// The octant that is the upper half. The lower half is octant 0.
    fn upper_half(self) -> u32 {
        1 << self.axis
    }
}

/// Policy that chooses where cells are divided.
pub trait PlanePolicy: 'static {
    /// True if a cell is divided only if that pays by itself. If false, the automatic level is found for the whole
    /// tree.
    const PAYS_BY_ITSELF: bool;
    /// The number of looks at each triangle that choosing a plane takes.
    const LOOKS: u64;

    /// Chooses the plane for a cell that holds some triangles, strictly inside it; `None` for a leaf.
    fn choose(
        group: &Group<'_>,
        ids: &[u32],
        cell: &Cell,
        depth: u32,
        model: &CostModel,
    ) -> Option<Plane>;
}

/// Tree of cells that the policy `P` divides.
pub struct PlaneTree<P>(PhantomData<P>);

/// Computes the customary limit of a kd-tree's depth for `n` triangles, 8 + 1.3 log2 n; a balanced tree of `n` leaves
/// is `log2 n` deep.
///
/// # Source
/// M. Pharr, W. Jakob, G. Humphreys, *Physically Based Rendering*.
const fn customary_depth(triangle_count: usize) -> u32 {
    let depth = 8 + (usize::BITS - triangle_count.leading_zeros()) * 13 / 10;
    if depth < MAX_DEPTH as u32 { depth } else { MAX_DEPTH as u32 }
}

const fn depth_at_most(triangle_count: usize, options: &Options) -> u32 {
    match options.level {
        Level::AtMost(level) if level < MAX_LEVEL => level * DIVISIONS_PER_LEVEL,
        Level::AtMost(_) => MAX_LEVEL * DIVISIONS_PER_LEVEL,
        Level::Automatic => customary_depth(triangle_count),
    }
}

/// Bounds the scratch; see [`LocalIndex::scratch_bytes`].
pub(crate) const fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
    Lists::scratch_bytes(triangle_count, depth_at_most(triangle_count, options) as usize)
}

impl<P: PlanePolicy> LocalIndex for PlaneTree<P>
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
        let most_depth = depth_at_most(group.ids.len(), options);
        let mut lists = Lists::new(group.ids.len(), most_depth as usize, scratch)?;
        let (root, model) = (Cell::of(&group.bounds), options.cost_model());
        let automatic = options.level == Level::Automatic;
        let most_references = most_references(group.ids.len(), options);
        // If each division has to pay for itself, a leaf capacity would only stop divisions that pay.
        let leaf_capacity = if automatic && P::PAYS_BY_ITSELF { 1 } else { options.leaf_capacity };
        let most_depth = if automatic && !P::PAYS_BY_ITSELF {
            let search = LevelSearch {
                group,
                model,
                leaf_capacity,
                most_references,
                most_depth: most_depth / DIVISIONS_PER_LEVEL * DIVISIONS_PER_LEVEL,
                depths_per_level: DIVISIONS_PER_LEVEL,
                looks: P::LOOKS,
            };
            let level = search.run(&mut lists, &root, words, |ids, cell, depth| {
                Plane::planes(P::choose(group, ids, cell, depth, &model))
            })?;
            level * DIVISIONS_PER_LEVEL
        } else {
            most_depth
        };
        Filing::write(group, &mut lists, words, |filing, list| {
            let model = &model;
            let division = PhantomData;
            PlaneBuilder::<P> { filing, model, leaf_capacity, most_depth, division }.node(
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
        const DEPTH: usize = MAX_DEPTH + 1;
        let root = local.word(0);
        if root == EMPTY {
            return ControlFlow::Continue(());
        }
        walk_near_first::<DEPTH, _, _>((root, span), ray, query, |link, span, query| {
            let offset = link & !LEAF;
            if link & LEAF != 0 {
                local.test(offset + 1, local.word(offset), ray, query)?;
                return ControlFlow::Continue((None, None));
            }
            let [axis, plane, lower, upper] = local.words_at(offset);
            let (axis, plane) = (axis as usize, f32::from_bits(plane));
            let downwards = ray.sign_mask() >> axis & 1 == 1;
            let (near, far) = if downwards { (upper, lower) } else { (lower, upper) };
            let crossing = ray.crossing(axis, plane);
            let child =
                |link: u32, span: Span| (link != EMPTY && !span.is_empty()).then_some((link, span));
            ControlFlow::Continue((
                child(near, span.until(crossing.latest)),
                child(far, span.after(crossing.earliest)),
            ))
        })
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        let offset_of = |link| link & !LEAF;
        let root = local.word(0);
        if root == EMPTY {
            return (local.words.len() == 1).then_some(Statistics::default());
        }
        let checked =
            check_depth_first::<{ MAX_DEPTH + 2 }>(root, 1, offset_of, |link, depth, links| {
                let offset = offset_of(link);
                if link & LEAF != 0 {
                    return check_leaf(local, offset);
                }
                let plane = f32::from_bits(local.word(offset + 1));
                if local.word(offset) > 2 || !plane.is_finite() || depth as usize >= MAX_DEPTH {
                    return None;
                }
                let children = [local.word(offset + 2), local.word(offset + 3)];
                links.follow(children.into_iter().filter(|&link| link != EMPTY))?;
                Some(CheckedNode::Inner { words: INNER_WORDS })
            });
        let (statistics, end) = checked?;
        let deepest_level = statistics.deepest_level.div_ceil(DIVISIONS_PER_LEVEL);
        (end as usize == local.words.len()).then_some(Statistics { deepest_level, ..statistics })
    }
}

struct PlaneBuilder<'f, 'b, 'g, 's, 'w, P> {
    filing: &'f mut Filing<'b, 'g, 's, 'w>,
    model: &'f CostModel,
    leaf_capacity: u32,
    most_depth: u32,
    division: PhantomData<P>,
}

impl<P: PlanePolicy> PlaneBuilder<'_, '_, '_, '_, '_, P> {
    /// Appends the node of a list, and returns the link to it. The recursion is as deep as the tree, at most 60.
    fn node(
        &mut self,
        list: List,
        cell: Cell,
        depth: u32,
        most_references: u64,
    ) -> Result<u32, BuildError> {
        if list.is_empty() {
            return Ok(EMPTY);
        }
        // 1. Choose a plane, unless a leaf is small enough or no level is left.
        let offset = self.filing.begin(list)?;
        let few = list.len() <= self.leaf_capacity as usize;
        let plane = if few || depth >= self.most_depth {
            None
        } else {
            self.filing.words.spend(P::LOOKS * list.len() as u64)?;
            let ids = self.filing.ids(list);
            P::choose(self.filing.group, ids, &cell, depth, self.model)
        };
        let Some(plane) = plane else {
            return Ok(self.filing.leaf(list, offset));
        };

        // 2. Find the sides of each triangle, unless there would be too many references.
        let planes = Plane::planes(Some(plane));
        let division = Division::new(&cell, &planes);
        let Some(parts) = self.filing.mark(list, most_references, &division)? else {
            return Ok(self.filing.leaf(list, offset));
        };
        // 3. Append the node, with links to be set later; then each half.
        self.filing.words.push(plane.axis as u32);
        self.filing.words.push(plane.at.to_bits());
        let links = self.filing.words.reserve(2);
        for (link_offset, side) in (links..).zip([0, plane.upper_half()]) {
            let part = self.filing.gather(list, side);
            let half = cell.child(&planes, side);
            let link = self.node(part, half, depth + 1, parts.share(part.len()))?;
            self.filing.words.set(link_offset, link);
        }
        Ok(offset)
    }
}
