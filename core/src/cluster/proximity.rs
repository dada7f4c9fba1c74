//! Connected components of "boxes at most delta apart", by joining a tree of boxes with itself.
//!
//! 1. A union-find keeps the components. Primitives that share corners are one already; see `corners`.
//! 2. Neighbours on the Morton curve are joined next. Components so far are *fragments*. The boxes are ordered along
//!    the curve, or by fragment, so that the boxes below most nodes are of one fragment. The order whose runs have less
//!    volume is taken.
//! 3. The tree of boxes is joined with itself; see `dual_join`.
//!
//! # What lost
//! - Boxes along the curve alone: three times as many pairs of nodes in a district of 65,000 triangles, 40 times in
//!   figure 2.
//! - Boxes by fragment alone: twice as many pairs of nodes in a city; all pairs where boxes lie inside each other.

use core::mem::replace;

use super::box_tree::{BoxTree, Scratch};
use super::dual_join::{Join, JoinAll, JoinNode, Part, fill, group_count, node_count};
use super::near::{BoxGroup, GROUP, Nearness};
use super::union_find::{flatten, unite};
use crate::geometry::{Aabb, Box4};
use crate::memory::size_of_slice;

/// Index that stands for "no box yet".
const NONE: u32 = u32::MAX;

/// The scratch bytes that [`connect`] needs for `count` boxes in all.
pub(super) const fn scratch_bytes(count: usize) -> usize {
    // The tree takes more than the sorts.
    let nodes = node_count(count);
    size_of_slice::<BoxGroup>(group_count(count))
        .saturating_add(size_of_slice::<u8>(group_count(count)))
        .saturating_add(size_of_slice::<Box4>(nodes))
        .saturating_add(size_of_slice::<u32>(count).saturating_mul(2))
        .saturating_add(size_of_slice::<u32>(nodes))
}

/// Unites, in the union-find `component`, all members whose boxes are at most `delta` apart; its square is given.
///
/// Reorders `members`. Tells whether the join was cut short: then some members are not united that should be. `None` if
/// the scratch is too small.
pub(super) fn connect(
    boxes: &[Aabb],
    members: &mut [u32],
    delta_squared: f64,
    component: &mut [u32],
    scratch: &mut Scratch<'_>,
    join_all: &JoinAll<'_>,
) -> Option<bool> {
    let near = Nearness::new(delta_squared);
    // 1. Join neighbours on the curve, unless all members are one fragment already.
    let Some(&first) = members.first() else { return Some(false) };
    flatten(component);
    let root_of =
        |component: &[u32], member: u32| component.get(member as usize).copied().unwrap_or(member);
    let lowest = root_of(component, first);
    if members.iter().all(|&member| root_of(component, member) == lowest) {
        return Some(false);
    }
    BoxTree::sort(boxes, members, scratch)?;
    let box_of = |member: u32| boxes.get(member as usize).map_or(Box4::EMPTY, Box4::of);
    let (mut one, mut bounds) = (lowest, Box4::EMPTY);
    for &member in members.iter() {
        let (before, box_before) =
            (replace(&mut one, member), replace(&mut bounds, box_of(member)));
        // Most neighbours share corners.
        let are_one = component.get(before as usize) == component.get(member as usize);
        if !are_one && near.holds(&box_before, &bounds) {
            unite(component, before, member);
        }
    }
    flatten(component);

    // 2. Build the tree in the order of the curve or by fragment, whichever has less volume.
    let mut arena = scratch.arena()?;
    let groups = arena.take::<BoxGroup>(group_count(members.len()))?;
    let continues = arena.take::<u8>(groups.len())?;
    let nodes = arena.take::<Box4>(node_count(members.len()))?;
    let marks = arena.take::<u32>(nodes.len())?;
    let order = arena.take::<u32>(members.len())?;
    let starts = arena.take::<u32>(component.len())?;
    gather_fragments(component, members, order, starts)?;
    let delta = libm::sqrt(delta_squared);
    let whole = JoinNode::root(members.len());
    // Roughly, how often nodes are near to others.
    let volume = |members: &[u32]| {
        let runs = members.chunks(RUN).step_by(SAMPLING);
        let volumes = runs.map(|run| {
            let bounds = run.iter().fold(Box4::EMPTY, |all, &member| all.union(box_of(member)));
            let [x, y, z] = bounds.aabb().extent().map(|side| side + delta);
            x * y * z
        });
        volumes.sum::<f64>()
    };
    // Where the fragments are runs of the curve already, both orders are one, and subtrees may be joined in parallel.
    let is_by_fragment = *order == *members || volume(order) < volume(members);
    if is_by_fragment {
        for (to, from) in members.iter_mut().zip(order.iter()) {
            *to = *from;
        }
    }
    for (at, group) in groups.iter_mut().enumerate() {
        let members = members.get(at * GROUP..).unwrap_or_default();
        *group = BoxGroup::gather(members.iter().map(|&member| box_of(member)));
    }
    fill(nodes, groups, whole);

    // 3. Begin with the fragments. By fragment, each box but the first says that it continues the one before; along the
    // curve, each refers to the first box of its fragment.
    let (parents, first_of) = (order, starts);
    first_of.fill(NONE);
    continues.fill(0);
    for (at, (&member, parent)) in (0..).zip(members.iter().zip(parents.iter_mut())) {
        let first = first_of.get_mut(root_of(component, member) as usize)?;
        let is_first = *first == NONE;
        if is_first {
            *first = at;
        } else {
            *continues.get_mut(at as usize / GROUP)? |= 1 << (at as usize % GROUP);
        }
        *parent = if is_by_fragment { at } else { *first };
    }

    // 4. Join, and bring the components back to the primitives.
    let continues = is_by_fragment.then_some(&*continues);
    let join = Join { count: members.len(), groups, nodes, near, continues };
    let mut part = Part::whole(marks, parents);
    join_all(&join, &mut part);
    for (at, &member) in (0..).zip(members.iter()) {
        let lowest = *members.get(part.root(at) as usize)?;
        // Those of a fragment are joined already.
        if component.get(member as usize) != component.get(lowest as usize) {
            unite(component, member, lowest);
        }
    }
    Some(part.is_cut_short)
}

/// Lists the members by component, in the order of the first member of each, and otherwise as they are. `starts` has a
/// word for each component.
fn gather_fragments(
    component: &[u32],
    members: &[u32],
    order: &mut [u32],
    starts: &mut [u32],
) -> Option<()> {
    // 1. Count the members of each component, at its root.
    starts.fill(0);
    for &member in members {
        *starts.get_mut(*component.get(member as usize)? as usize)? += 1;
    }
    // 2. The first member of a component that is met reserves the run; the highest bit says that it did.
    let mut end = 0;
    for &member in members {
        let start = starts.get_mut(*component.get(member as usize)? as usize)?;
        if *start & STARTED == 0 {
            let from = end;
            end += *start;
            *start = from | STARTED;
        }
        *order.get_mut((*start & !STARTED) as usize)? = member;
        *start += 1;
    }
    Some(())
}

/// Number of boxes in a run: two orders are compared by the boxes around their runs.
const RUN: usize = 64;
/// Number of runs for each one whose volume is measured.
///
/// # Measured
/// - Trees over both orders, of which one was kept, chose alike, and took a seventh of the time of finding clusters.
const SAMPLING: usize = 4;

/// Bit of a start that replaces a count. There are at most 2^30 members.
const STARTED: u32 = 1 << 31;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_takes_more_than_the_sorts() {
        let powers = (0..usize::BITS).map(|bit| 1 << bit);
        let around_powers = powers.flat_map(|power: usize| power - 1..=power.saturating_add(1));
        for count in (0..10_000).chain(around_powers) {
            assert!(scratch_bytes(count) >= Scratch::bytes(count), "{count}");
        }
    }
}
