//! Build of a BVH by inserting one triangle after the other.
//!
//! 1. From the root, a triangle goes down to the child whose surface grows least, as long as that costs less than
//!    making the triangle the sibling of the node reached.
//! 2. There, the node and the triangle become the children of a new node.
//! 3. Boxes and heights are renewed on the way back.
//!
//! Sorted triangles would give poor trees. So triangles are inserted in a scattered order, which depends on their
//! number only.
//!
//! # Source
//! J. Goldsmith, J. Salmon, *Automatic Creation of Object Hierarchies for Ray Tracing*, 1987. Deviation:
//! nodes have two children.

use arrayvec::ArrayVec;
use bytemuck::{Pod, Zeroable};

use super::{MAX_DEPTH, push_inner, push_leaf, set_child};
use crate::error::BuildError;
use crate::geometry::Aabb;
use crate::indices::cost::half_area;
use crate::input::Options;
use crate::memory::{Arena, Words, size_of_slice};
use crate::structure::Group;

/// Node of a tree under construction. The links of an inner node are its children; those of a leaf are the first and
/// the last triangle of a linked list.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct BuildNode {
    bounds: Aabb,
    links: [u32; 2],
    /// The number of levels below; 0 for a leaf.
    height: u32,
}

const NONE: u32 = u32::MAX;

const fn node_count(triangle_count: usize) -> usize {
    triangle_count.saturating_mul(2)
}

pub(super) const fn scratch_bytes(triangle_count: usize) -> usize {
    size_of_slice::<BuildNode>(node_count(triangle_count))
        .saturating_add(size_of_slice::<u32>(triangle_count))
}

/// Inserts the triangles of a group, and writes the tree. `full` is the error if the scratch is too small.
///
/// # Errors
/// `full`, and [`BuildError::TooMuchWork`].
pub(super) fn build(
    group: &Group<'_>,
    options: &Options,
    words: &mut Words<'_>,
    mut arena: Arena<'_>,
    full: BuildError,
) -> Result<(), BuildError> {
    let count = group.ids.len();
    let nodes = arena.take::<BuildNode>(node_count(count)).ok_or(full)?;
    // For each triangle of the group, the next one in the list of its leaf. A list has several triangles only where no
    // level is left.
    let next = arena.take::<u32>(count).ok_or(full)?;
    next.fill(NONE);
    let mut tree = InsertionTree { nodes, next, used: 0 };
    // A step that is coprime to the count, near its golden section, visits every triangle once, in a scattered order.
    let mut step = (count as u64 * 618 / 1000).max(1);
    while greatest_common_divisor(step, count as u64) != 1 {
        step += 1;
    }
    let mut index = 0;
    for _ in 0..count {
        let id = group.ids.get(index as usize).copied().unwrap_or(0);
        let bounds = group.triangles.get(id).unwrap_or_default().bounds();
        let levels = tree.insert(index as u32, bounds, options).ok_or(full)?;
        // A step for each box that was compared on the way down, and for each that was renewed on the way back.
        words.spend(2 * levels as u64)?;
        index = (index + step) % count.max(1) as u64;
    }
    let start = words.len();
    let root = words.push(0);
    let link = write(&tree, 0, group, words, start).ok_or(full)?;
    words.set(root, link);
    Ok(())
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a.checked_rem(b).unwrap_or(0));
    }
    a
}

struct InsertionTree<'a> {
    nodes: &'a mut [BuildNode],
    next: &'a mut [u32],
    used: usize,
}

impl InsertionTree<'_> {
    fn push(&mut self, node: BuildNode) -> Option<u32> {
        let id = self.used;
        *self.nodes.get_mut(id)? = node;
        self.used += 1;
        Some(id as u32)
    }

    /// Inserts a triangle (by its index in the group), and returns the number of nodes on the way to its leaf.
    fn insert(&mut self, index: u32, bounds: Aabb, options: &Options) -> Option<usize> {
        let leaf = BuildNode { bounds, links: [index, index], height: 0 };
        if self.used == 0 {
            self.push(leaf)?;
            return Some(1);
        }
        // 1. Go down to where the new triangle costs least: in a new node around it and a node, or further down.
        let mut path = ArrayVec::<u32, { MAX_DEPTH as usize + 1 }>::new();
        let mut at = 0;
        let node = loop {
            path.try_push(at).ok()?;
            let node = *self.nodes.get(at as usize)?;
            let fits = path.len() as u32 + node.height <= MAX_DEPTH;
            let Some(child) = self.cheaper_child(&node, &bounds, options, fits)? else {
                break node;
            };
            at = child;
        };

        // 2. Make a new node of the node and the triangle, in the node's slot. If no level is left, add the triangle to
        // the leaf instead.
        if path.len() as u32 + node.height <= MAX_DEPTH {
            let links = [self.push(node)?, self.push(leaf)?];
            *self.nodes.get_mut(at as usize)? =
                BuildNode { bounds: node.bounds, links, height: node.height + 1 };
        } else {
            *self.next.get_mut(node.links[1] as usize)? = index;
            self.nodes.get_mut(at as usize)?.links[1] = index;
        }

        // 3. Renew boxes and heights on the way back.
        for &at in path.iter().rev() {
            let [left, right] = self.nodes.get(at as usize)?.links;
            let is_leaf = self.nodes.get(at as usize)?.height == 0;
            let height_of =
                |child: u32| self.nodes.get(child as usize).map_or(0, |node| node.height);
            let height = if is_leaf { 0 } else { 1 + height_of(left).max(height_of(right)) };
            let node = self.nodes.get_mut(at as usize)?;
            node.bounds = node.bounds.union(bounds);
            node.height = height;
        }
        Some(path.len())
    }

    /// Chooses the child to go down to. The inner value is `None` if the triangle belongs beside the node itself, which
    /// is possible only if it `fits`: if a level is left for the new node.
    #[expect(clippy::option_option, reason = "the outer one is for `?`")]
    fn cheaper_child(
        &self,
        node: &BuildNode,
        bounds: &Aabb,
        options: &Options,
        fits: bool,
    ) -> Option<Option<u32>> {
        if node.height == 0 {
            return Some(None);
        }
        let growth = |bounds_before: &Aabb| {
            half_area(bounds_before.union(*bounds).extent()) - half_area(bounds_before.extent())
        };
        let [left, right] = node.links;
        let (l, r) = (self.nodes.get(left as usize)?, self.nodes.get(right as usize)?);
        let (l_growth, r_growth) = (growth(&l.bounds), growth(&r.bounds));
        // Of two whose growth is the same, the lower tree, so that coincident triangles make a balanced tree.
        let go_right = r_growth < l_growth || (r_growth == l_growth && r.height < l.height);
        let (child, least) = if go_right { (right, r_growth) } else { (left, l_growth) };
        let model = &options.cost_model();
        let descended = model.traversal * 2.0 * growth(&node.bounds) + model.intersection * least;
        let paired = model.traversal * 2.0 * half_area(node.bounds.union(*bounds).extent());
        Some((!fits || descended <= paired).then_some(child))
    }
}

/// Writes a subtree in depth-first order, and returns the link to it. The recursion is as deep as the tree.
fn write(
    tree: &InsertionTree<'_>,
    at: u32,
    group: &Group<'_>,
    words: &mut Words<'_>,
    start: usize,
) -> Option<u32> {
    let node = tree.nodes.get(at as usize)?;
    if node.height == 0 {
        let mut index = node.links[0];
        let ids = core::iter::from_fn(|| {
            let id = group.ids.get(index as usize).copied()?;
            index = tree.next.get(index as usize).copied().unwrap_or(NONE);
            Some(id)
        });
        return Some(push_leaf(words, start, ids));
    }
    let boxes = push_inner(words);
    for (child, link) in node.links.into_iter().enumerate() {
        let bounds = tree.nodes.get(link as usize)?.bounds;
        let link = write(tree, link, group, words, start)?;
        set_child(words, boxes, child, &bounds, link);
    }
    Some((boxes - start) as u32)
}
