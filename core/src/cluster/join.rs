//! The cluster tree: in rounds, the closest two are joined.
//!
//! ```text
//! round 1   a b c d e     (b, d) are the closest, then (a, e); c is left over
//! round 2   c (bd) (ae)   ...
//! ```
//! Each round pairs the closest two boxes, then the closest two of the rest, until at most one is
//! left over, which enters the next round unpaired. So the depth is `ceil(log2 clusters)`. Of two
//! equally distant pairs, the one with the lower lower id comes first, then the lower higher id.
//!
//! # Without comparing all pairs
//! Order all pairs by (gap, lower id, higher id). The greedy pairing of a round contains every pair
//! that is each other's first choice among those left, in whatever order such pairs are taken, and
//! taking them all is the whole of it. A chain of first choices descends in that order, hence ends in
//! such a pair (the nearest-neighbour chain of hierarchical clustering); a tree of boxes gives the
//! first choices. The pairs found are then sorted, so that ids are handed out as the greedy rounds
//! would.
//!
//! # Source
//! Aguilera et al., algorithms 1 and 2. Chain: J.-P. Benzécri 1982; F. Murtagh 1983.

use super::box_tree::{BoxTree, NodeRef, Scratch};
use super::node::{ClusterNode, NodeId};
use crate::geometry::Aabb;
use crate::memory::{Arena, size_of_slice, sort_by_key};

/// The scratch that joining `count` clusters needs.
pub(crate) const fn join_bytes(count: usize) -> usize {
    size_of_slice::<Aabb>(count)
        .saturating_add(size_of_slice::<u32>(count).saturating_mul(5))
        .saturating_add(Scratch::bytes(count))
}

const NONE: u32 = u32::MAX;

/// Fills `nodes[count..]` with the inner nodes over the leaves `nodes[..count]`, and the parents.
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
    let mut scratch = Scratch::take(&mut arena, count)?;

    for (id, slot) in (0..).zip(active.iter_mut()) {
        *slot = id;
    }
    let mut active_count = count;
    let mut next_id = count as u32;
    while active_count > 1 {
        // 1. Pair up. Places in `active` ascend like the ids there, so they serve for ties.
        let ids = active.get(..active_count)?;
        let boxes = boxes.get_mut(..active_count)?;
        for (slot, &id) in boxes.iter_mut().zip(ids) {
            *slot = nodes.get(id as usize)?.bounds;
        }
        let members = members.get_mut(..active_count)?;
        let partner = partner.get_mut(..active_count)?;
        // The next round's list is still empty, and serves for the chain.
        pair_up(boxes, members, partner, next_active, position_of, &mut scratch)?;

        // 2. Sort the pairs by gap; they start out by lower position, and the sort is stable.
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

        // 3. Join; what is left over has the lowest id of the next round.
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

/// Gives each box its partner in the greedy pairing, or `NONE` to the one left over.
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
    let mut tree = BoxTree::build(boxes, members, scratch)?;
    for (position, &member) in (0..).zip(tree.members()) {
        *position_of.get_mut(member as usize)? = position;
    }
    tree.mark_all(|tree, node| lowest_single(tree, node, partner));

    for start in 0..boxes.len() as u32 {
        if *partner.get(start as usize)? != NONE {
            continue;
        }
        *chain.get_mut(0)? = start;
        let mut length = 1;
        while length > 0 {
            let top = *chain.get(length - 1)?;
            let Some(choice) = first_choice(&tree, partner, top) else {
                break; // nobody else is single
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
                tree.refresh_above(position, single, |tree, node| {
                    lowest_single(tree, node, partner)
                });
            }
        }
    }
    Some(())
}

/// The lowest member below a node without a partner.
fn lowest_single(tree: &BoxTree<'_>, node: NodeRef, partner: &[u32]) -> u32 {
    if let Some((left, right)) = tree.children(node) {
        let mark = |child| tree.node(child).map_or(NONE, |n| n.mark);
        mark(left).min(mark(right))
    } else {
        let single = |member: &&u32| partner.get(**member as usize) == Some(&NONE);
        tree.group(node).iter().filter(single).copied().min().unwrap_or(NONE)
    }
}

/// The nearest other box without a partner; of several, the lowest. (Of the pairs with a given box,
/// at one gap, the one with the lowest other id is also the first by lower, then higher id.)
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
    /// Gap squared and member.
    best: (f64, u32),
}

impl NearestSearch<'_> {
    /// As deep a recursion as the tree, at most 30 levels.
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
        // No box below is nearer than the node's, and none has a lower number than its mark.
        let bound = |child| {
            let found = self.tree.node(child)?;
            Some(((found.bounds.gap_squared(self.bounds), found.mark), child))
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
