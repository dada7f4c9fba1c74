//! Build of the cluster tree: in each round, the closest two nodes are joined.
//!
//! ```text
//! round 1   a b c d e     (b, d) are the closest, then (a, e); c is left over
//! round 2   c (bd) (ae)   ...
//! ```
//! A round pairs the closest two boxes, then the closest two of the rest, and so on. At most one box is left over; it
//! enters the next round unpaired. So the depth of the tree is `ceil(log2 clusters)`.
//!
//! Ties: of two pairs with equal gaps, the pair whose lower id is lower comes first, then the pair whose higher id is
//! lower.
//!
//! # Without comparing all pairs
//! Order all pairs by (gap, lower id, higher id).
//!
//! 1. Two boxes that are each other's first choice, among those that are left, are a pair of the greedy pairing. This
//!    holds in whatever order such pairs are taken, and taking them until none is left gives the whole pairing.
//! 2. A chain of first choices (the nearest-neighbour chain of hierarchical clustering) descends in the order of pairs.
//!    Hence it ends in two boxes that are each other's first choice.
//! 3. A [`BoxTree`] finds first choices.
//! 4. The pairs are then sorted, so that they get the ids that the greedy rounds would give them.
//!
//! # Source
//! Aguilera et al., algorithms 1 and 2. Chain: J.-P. Benzécri 1982; F. Murtagh 1983.

use super::box_tree::{BoxTree, NodeRef, Scratch};
use super::node::{ClusterNode, NodeId};
use crate::geometry::Aabb;
use crate::memory::{Arena, size_of_slice, sort_by_key};

/// The scratch bytes that joining `count` clusters needs.
pub(crate) const fn join_bytes(count: usize) -> usize {
    size_of_slice::<Aabb>(count)
        .saturating_add(size_of_slice::<u32>(count).saturating_mul(5))
        .saturating_add(Scratch::bytes(count))
}

const NONE: u32 = u32::MAX;

/// Fills `nodes[count..]` with the inner nodes over the leaves `nodes[..count]`, and sets all parents.
///
/// Cost: near-linear. `None` if the scratch is too small.
pub(crate) fn join(nodes: &mut [ClusterNode], count: usize, scratch: &mut [u8]) -> Option<()> {
    if count < 2 {
        return Some(());
    }
    let mut arena = Arena::new(scratch)?;
    let boxes = arena.take::<Aabb>(count)?;
    let mut active = arena.take::<u32>(count)?;
    let mut next_active = arena.take::<u32>(count)?;
    let members = arena.take::<u32>(count)?;
    let partner = arena.take::<u32>(count)?;
    let position_of = arena.take::<u32>(count)?;
    let mut scratch = Scratch::take(&mut arena, Scratch::bytes(count))?;

    for (id, slot) in (0..).zip(active.iter_mut()) {
        *slot = id;
    }
    let mut active_count = count;
    let mut next_id = count as u32;
    while active_count > 1 {
        // 1. Pair up. Indices into `active` ascend like the ids there, so indices decide ties as ids would.
        let ids = active.get(..active_count)?;
        let boxes = boxes.get_mut(..active_count)?;
        for (slot, &id) in boxes.iter_mut().zip(ids) {
            *slot = nodes.get(id as usize)?.bounds;
        }
        let members = members.get_mut(..active_count)?;
        let partner = partner.get_mut(..active_count)?;
        // The next round's list is still empty; it lends its memory to the chain.
        pair_up(boxes, members, partner, next_active, position_of, &mut scratch)?;

        // 2. Sort the pairs by gap. They start in the order of their lower index, and the sort is stable.
        let (gaps, mut buffer) = scratch.sorting(active_count)?;
        let mut pair_count = 0;
        for (lower, &higher) in (0..).zip(partner.iter()) {
            if higher != NONE && lower < higher {
                let gap = boxes.get(lower as usize)?.gap_squared(boxes.get(higher as usize)?);
                *gaps.get_mut(pair_count)? = gap.to_bits();
                *members.get_mut(pair_count)? = lower;
                pair_count += 1;
            }
        }
        let pairs = members.get_mut(..pair_count)?;
        sort_by_key(gaps.get_mut(..pair_count)?, pairs, &mut buffer);

        // 3. Join. The node that is left over is the first of the next round, because it has the lowest id.
        let mut filled = 0;
        if let Some(left_over) = partner.iter().position(|&p| p == NONE) {
            *next_active.get_mut(0)? = *ids.get(left_over)?;
            filled = 1;
        }
        for &lower in pairs.iter() {
            let links =
                [*ids.get(lower as usize)?, *ids.get(*partner.get(lower as usize)? as usize)?];
            let mut bounds = Aabb::EMPTY;
            for link in links {
                let child = nodes.get_mut(link as usize)?;
                child.parent = NodeId(next_id);
                bounds = bounds.union(child.bounds);
            }
            *nodes.get_mut(next_id as usize)? = ClusterNode { bounds, links, parent: NodeId::NONE };
            *next_active.get_mut(filled)? = next_id;
            filled += 1;
            next_id += 1;
        }
        core::mem::swap(&mut active, &mut next_active);
        active_count = filled;
    }
    Some(())
}

/// Finds the partner of each box in the greedy pairing, by nearest-neighbour chains; `NONE` for the box that is left
/// over.
fn pair_up(
    boxes: &[Aabb],
    members: &mut [u32],
    partner: &mut [u32],
    chain: &mut [u32],
    position_of: &mut [u32],
    scratch: &mut Scratch<'_>,
) -> Option<()> {
    for (at, slot) in (0..).zip(members.iter_mut()) {
        *slot = at;
    }
    partner.fill(NONE);
    BoxTree::sort(boxes, members, scratch)?;
    let mut tree = BoxTree::build(boxes, members, scratch)?;
    for (position, &member) in (0..).zip(tree.members()) {
        *position_of.get_mut(member as usize)? = position;
    }
    for start in 0..boxes.len() as u32 {
        if *partner.get(start as usize)? != NONE {
            continue;
        }
        *chain.get_mut(0)? = start;
        let mut length = 1;
        while length > 0 {
            let top = *chain.get(length - 1)?;
            let Some(choice) = first_choice(&tree, partner, top) else {
                break; // all others have partners
            };
            if length < 2 || *chain.get(length - 2)? != choice {
                *chain.get_mut(length)? = choice;
                length += 1;
                continue;
            }
            length -= 2;
            *partner.get_mut(top as usize)? = choice;
            *partner.get_mut(choice as usize)? = top;
            for taken in [top, choice] {
                let single = |member: u32| partner.get(member as usize) == Some(&NONE);
                let position = *position_of.get(taken as usize)? as usize;
                tree.refresh_above(position, single);
            }
        }
    }
    Some(())
}

/// The first choice of `asker`: the nearest other box without a partner; of several, the lowest.
///
/// (Of the pairs of one box that have the same gap, the pair with the lowest other id is also the first by lower, then
/// higher id.)
fn first_choice(tree: &BoxTree<'_>, partner: &[u32], asker: u32) -> Option<u32> {
    let bounds = tree.box_of(asker);
    let mut search = NearestSearch { tree, partner, asker, bounds, best: (f64::INFINITY, NONE) };
    search.visit(NodeRef::ROOT);
    let choice = search.best.1;
    (choice != NONE).then_some(choice)
}

struct NearestSearch<'t> {
    tree: &'t BoxTree<'t>,
    partner: &'t [u32],
    asker: u32,
    bounds: &'t Aabb,
    /// The squared gap to the best candidate so far, and its member.
    best: (f64, u32),
}

impl NearestSearch<'_> {
    /// Searches below a node, the nearer child first. The recursion is as deep as the tree, at most 30 levels.
    fn visit(&mut self, node: NodeRef) {
        let Some((left, right)) = self.tree.children(node) else {
            for &member in self.tree.group(node) {
                let candidate = (self.tree.box_of(member).gap_squared(self.bounds), member);
                let single = self.partner.get(member as usize) == Some(&NONE);
                if single && member != self.asker && candidate < self.best {
                    self.best = candidate;
                }
            }
            return;
        };
        // A bound for all boxes below a child that have no partner: none is nearer than the child's box, none has a
        // lower id than the child's lowest.
        let bound = |child| {
            let found = self.tree.node(child)?;
            Some(((found.bounds.gap_squared(self.bounds), found.lowest), child))
        };
        let (Some(left), Some(right)) = (bound(left), bound(right)) else {
            return;
        };
        let (first, second) = if right.0 < left.0 { (right, left) } else { (left, right) };
        for (bound, child) in [first, second] {
            if bound.1 != NONE && bound < self.best {
                self.visit(child);
            }
        }
    }
}
