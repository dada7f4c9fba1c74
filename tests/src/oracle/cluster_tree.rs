//! Oracle of the cluster tree: sorts all pairs in every round.
//!
//! A round joins the closest pair of boxes, then the closest pair of the rest, and so on. Ties are broken by the pair's
//! lower id, then by its higher id. A node without a partner enters the next round.

use arboleda::Aabb;

use super::clusters::gap_squared;

/// Inner node: two joined nodes and their bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Join {
    /// Ids of the two joined nodes, the lower first.
    pub links: [u32; 2],
    /// Bounding box of both.
    pub bounds: Aabb,
}

/// Computes the joins over leaves, in the order in which they are made. The first has the id `leaves.len()`.
pub fn joins(leaves: &[Aabb]) -> Vec<Join> {
    let mut boxes = leaves.to_vec();
    let mut joins = Vec::new();
    let mut active: Vec<usize> = (0..leaves.len()).collect();
    while active.len() > 1 {
        let mut pairs = Vec::new();
        for (place, &low) in active.iter().enumerate() {
            for &high in &active[place + 1..] {
                pairs.push((gap_squared(&boxes[low], &boxes[high]), low, high));
            }
        }
        pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
        let mut next = Vec::new();
        for (_, low, high) in pairs {
            if active.contains(&low) && active.contains(&high) {
                active.retain(|&id| id != low && id != high);
                next.push(boxes.len());
                let bounds = boxes[low].union(boxes[high]);
                joins.push(Join { links: [low as u32, high as u32], bounds });
                boxes.push(bounds);
            }
        }
        active.extend(next);
    }
    joins
}
