//! The bounding volume hierarchy (BVH): a binary tree of boxes, each triangle in one leaf.
//!
//! ```text
//! words:  root: a link; then the nodes in depth-first order
//! inner:  for each of two children: box (6 words, f32 bits: lo, hi), link
//! leaf:   count | id id id ...
//! link:   offset of the node, the highest bit set for a leaf
//! ```
//! The default build is top-down by the binned surface-area heuristic (SAH): triangles are partitioned, by their
//! centroids in bins, where the sum of (surface of the part's box) * (number of triangles in it) is least. The other
//! build is by [`insertion`].
//!
//! # Source
//! T. Kay, J. Kajiya, *Ray Tracing Complex Scenes*, 1986; J. Goldsmith, J. Salmon, *Automatic Creation
//! of Object Hierarchies for Ray Tracing*, 1987; binning: I. Wald, *On Fast Construction of SAH-Based
//! Bounding Volume Hierarchies*, 2007.

mod binned;
mod insertion;

use core::ops::ControlFlow;

use glam::Vec4;

use binned::BinnedBuild;

use super::depth_first::{CheckedNode, check_depth_first, check_leaf};
use super::ordered_traversal::{near_first, walk_near_first};
use crate::Vec3;
use crate::error::BuildError;
use crate::geometry::{Aabb, RaySpan, Span};
use crate::input::{BvhBuild, Options};
use crate::memory::{Arena, Words, size_of_slice};
use crate::query::Query;
use crate::structure::{Described, Group, Local, LocalIndex, Statistics, Weights};

/// Bounding volume hierarchy with two children a node, over the whole scene or, in a hierarchy, over a cluster.
pub enum Bvh {}

/// The bit of a link that leads to a leaf.
const LEAF: u32 = 1 << 31;
/// Links have 31 bits.
const MOST_WORDS: usize = 1 << 31;
/// Words of a child in an inner node: a box and a link.
const CHILD_WORDS: u32 = 7;
const INNER_WORDS: u32 = 2 * CHILD_WORDS;
/// Depth from which on triangles are divided into equal halves, which needs at most 30 more levels.
const BALANCED_FROM: u32 = 30;
/// Depth of the deepest tree.
pub(super) const MAX_DEPTH: u32 = 62;
/// Number of bins along an axis.
///
/// # Measured
/// - 8 cost about 2% more steps.
/// - 32 were no better.
const BINS: usize = 16;

/// Appends an inner node, to be filled in later, and returns the offset of its first child.
pub(super) fn push_inner(words: &mut Words<'_>) -> usize {
    words.reserve(INNER_WORDS as usize)
}

/// Fills in a child of an inner node whose first child lies at the offset `boxes`.
pub(super) fn set_child(
    words: &mut Words<'_>,
    boxes: usize,
    child: usize,
    bounds: &Aabb,
    link: u32,
) {
    set_box(words, boxes + child * CHILD_WORDS as usize, bounds, link);
}

/// Fills in a child of an inner node at its offset.
fn set_box(words: &mut Words<'_>, offset: usize, bounds: &Aabb, link: u32) {
    let numbers = bounds.lo.to_array().into_iter().chain(bounds.hi.to_array());
    for (component, number) in numbers.enumerate() {
        words.set(offset + component, number.to_bits());
    }
    words.set(offset + CHILD_WORDS as usize - 1, link);
}

/// Appends a leaf, and returns the link to it.
pub(super) fn push_leaf(
    words: &mut Words<'_>,
    start: usize,
    ids: impl Iterator<Item = u32>,
) -> u32 {
    let offset = words.push(0);
    let mut count = 0;
    for id in ids {
        words.push(id);
        count += 1;
    }
    words.set(offset, count);
    (offset - start) as u32 | LEAF
}

/// Bounds the scratch; see [`LocalIndex::scratch_bytes`].
pub(crate) const fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
    match options.bvh_build {
        BvhBuild::Binned => size_of_slice::<u32>(triangle_count).saturating_mul(2),
        BvhBuild::Insertion => insertion::scratch_bytes(triangle_count),
    }
}

/// # Measured
/// The build counts a node for each of two boxes, with [`Described::COST`] for each; a query counts one for both, with
/// [`Weights::node`], hence 5.6 tests there. On photons' rays (figure 4(b), a mesh of 125,000 triangles, a city), the
/// instructions of a query were fewest for costs of 0.5 to 1.0, and more by 1% with 1.5, 3% with 2, 7% with 3 and 8%
/// with 3.7, while leaves tested triangles one by one. Since they are tested eight at once, times do not differ beyond
/// their noise from 1 to 6; with 2.5 the index takes a fifth less memory.
impl Described for Bvh {
    const NAME: &'static str = "bvh";
    const HIERARCHY_NAME: &'static str = "bvh-hierarchy";
    const FORMAT: u32 = 7;
    const WEIGHTS: Weights = Weights { ray: 8.0, node: 16.8, test: 2.6 }; // +-21%
    const SOFTWARE_WEIGHTS: Weights = Weights { ray: 69_210.0, node: 3_034.0, test: 1_942.0 }; // +-1%
}

impl LocalIndex for Bvh {
    fn scratch_bytes(triangle_count: usize, options: &Options) -> usize {
        scratch_bytes(triangle_count, options)
    }

    fn build(
        group: &Group<'_>,
        options: &Options,
        words: &mut Words<'_>,
        scratch: &mut [u8],
    ) -> Result<(), BuildError> {
        let count = group.ids.len();
        let needed = Self::scratch_bytes(count, options);
        let full = BuildError::ScratchFull { needed, given: scratch.len() };
        check_size(words.len(), count)?;
        let mut arena = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        if options.bvh_build == BvhBuild::Insertion {
            return insertion::build(group, options, words, arena, full);
        }
        let ids = arena.take::<u32>(count).ok_or(full)?;
        let other = arena.take::<u32>(count).ok_or(full)?;
        ids.copy_from_slice(group.ids.get(..ids.len()).unwrap_or_default());
        BinnedBuild { triangles: group.triangles, options }.write(words, ids, other)
    }

    fn traverse<Q: Query>(
        local: &Local<'_>,
        ray: &RaySpan,
        span: Span,
        query: &mut Q,
    ) -> ControlFlow<()> {
        const DEPTH: usize = MAX_DEPTH as usize + 2;
        let root = (local.word(0), span);
        walk_near_first::<DEPTH, _, _>(root, ray, query, |link, span, query| {
            let offset = link & !LEAF;
            if link & LEAF != 0 {
                local.test(offset + 1, local.word(offset), ray, query)?;
                return ControlFlow::Continue((None, None));
            }
            let node: [u32; INNER_WORDS as usize] = local.words_at(offset);
            let child = |first: usize| {
                let number = |at: usize| f32::from_bits(node[first + at]);
                let lo = Vec4::new(number(0), number(1), number(2), number(3));
                let hi = Vec4::new(number(3), number(4), number(5), number(6));
                let span = ray.clip_sides(lo, hi, span);
                (!span.is_empty()).then_some((node[first + 6], span))
            };
            ControlFlow::Continue(near_first(child(0), child(CHILD_WORDS as usize)))
        })
    }

    fn check(local: &Local<'_>) -> Option<Statistics> {
        const MOST: usize = MAX_DEPTH as usize + 2;
        let offset_of = |link| link & !LEAF;
        let checked =
            check_depth_first::<MOST>(local.word(0), 1, offset_of, |link, depth, links| {
                let offset = offset_of(link);
                if link & LEAF != 0 {
                    return check_leaf(local, offset);
                }
                let boxes = [offset, offset + CHILD_WORDS];
                let sound = boxes.iter().all(|&offset| {
                    let bounds = bounds_at(local, offset);
                    bounds.lo.is_finite() && bounds.hi.is_finite() && !bounds.is_empty()
                });
                if depth >= MAX_DEPTH || !sound {
                    return None;
                }
                links
                    .follow(boxes.into_iter().map(|offset| local.word(offset + CHILD_WORDS - 1)))?;
                Some(CheckedNode::Inner { words: INNER_WORDS })
            });
        let (statistics, end) = checked?;
        (end as usize == local.words.len()).then_some(statistics)
    }
}

#[inline]
fn bounds_at(local: &Local<'_>, offset: u32) -> Aabb {
    let number = |component: u32| f32::from_bits(local.word(offset.wrapping_add(component)));
    Aabb::new(
        Vec3::new(number(0), number(1), number(2)),
        Vec3::new(number(3), number(4), number(5)),
    )
}

/// Refuses a group of `count` triangles if its links might not reach all of its words, behind `words` others.
fn check_size(words: usize, count: usize) -> Result<(), BuildError> {
    // For each triangle at most an inner node, and a leaf of two words.
    let most = words.saturating_add(count.saturating_mul(INNER_WORDS as usize + 3));
    if most >= MOST_WORDS { Err(BuildError::TooLarge) } else { Ok(()) }
}

/// Finds the bin of a triangle's centroid on an axis.
fn bin_of(centroids: &Aabb, axis: usize, triangle: &Aabb) -> usize {
    let centre = f64::from(triangle.centre().to_array()[axis % 3]);
    let [lo, hi] = centroids.along(axis).map(f64::from);
    // The cast saturates, and maps a NaN (0 / 0) to 0.
    (((centre - lo) / (hi - lo) * BINS as f64) as usize).min(BINS - 1)
}
