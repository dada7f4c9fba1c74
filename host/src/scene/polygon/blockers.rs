//! Corners that may lie in an ear, found by place.
//!
//! If any corner of a polygon lies in a triangle of three neighbours, a corner that is not convex does. So
//! only corners that are not convex are kept, in a balanced tree of boxes: ears may be long slivers, whose
//! own boxes hold half of the polygon.
//!
//! # What lost
//! - A grid of cells: 11,255 steps a corner on a comb's back, where this tree takes 60.

use super::{Point, turn};

/// A leaf has at most this many corners.
const LEAF: usize = 8;

/// The corners of a polygon that are not convex.
#[derive(Default)]
pub(super) struct Blockers {
    /// Node `n` has the children `2n + 1` and `2n + 2`, which halve its corners.
    nodes: Vec<Node>,
    corners: Vec<u32>,
    /// Corners that ceased to be convex, which happens only where the polygon overlaps itself.
    late: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Node {
    lo: Point,
    hi: Point,
    /// Corners that still block; in a leaf they come first.
    count: u32,
}

/// A node, and which of the corners are below it.
#[derive(Clone, Copy)]
struct Subtree {
    node: usize,
    first: usize,
    len: usize,
}

impl Subtree {
    /// Returns the two halves; none of a leaf.
    fn halves(self) -> Option<[Self; 2]> {
        let half = self.len / 2;
        (self.len > LEAF).then_some([
            Self { node: 2 * self.node + 1, first: self.first, len: half },
            Self { node: 2 * self.node + 2, first: self.first + half, len: self.len - half },
        ])
    }
}

/// A search for a corner that blocks a triangle.
pub(super) struct Search<'s, P, B> {
    /// The triangle, counterclockwise.
    pub triangle: [Point; 3],
    /// Tells whether a corner is still part of the polygon, and not convex.
    pub is_present: P,
    /// Tells whether a corner keeps the triangle from being an ear.
    pub blocks: B,
    /// Nodes and corners looked at.
    pub work: &'s mut u64,
}

impl Blockers {
    /// Files corners by their points.
    pub fn fill(&mut self, points: &[Point], corners: impl Iterator<Item = u32>) {
        self.late.clear();
        self.nodes.clear();
        self.corners.clear();
        self.corners.extend(corners);
        let root = self.root();
        self.build(points, root);
    }

    /// Adds a corner afterwards.
    pub fn add(&mut self, corner: u32) {
        self.late.push(corner);
    }

    /// Tells whether a corner blocks the triangle. Corners that are not present are dropped on the way.
    pub fn any<P: Fn(u32) -> bool, B: Fn(u32) -> bool>(
        &mut self,
        search: &mut Search<'_, P, B>,
    ) -> bool {
        *search.work += self.late.len() as u64;
        let is_blocking = |&corner: &u32| (search.is_present)(corner) && (search.blocks)(corner);
        self.late.iter().any(is_blocking) || self.any_below(self.root(), search)
    }

    fn root(&self) -> Subtree {
        Subtree { node: 0, first: 0, len: self.corners.len() }
    }

    fn build(&mut self, points: &[Point], subtree: Subtree) {
        let Subtree { node, first, len } = subtree;
        let part = &mut self.corners[first..first + len];
        let (mut lo, mut hi) = (
            Point { x: f64::INFINITY, y: f64::INFINITY },
            Point { x: -f64::INFINITY, y: -f64::INFINITY },
        );
        for &corner in &*part {
            let Point { x, y } = points[corner as usize];
            lo = Point { x: lo.x.min(x), y: lo.y.min(y) };
            hi = Point { x: hi.x.max(x), y: hi.y.max(y) };
        }
        if self.nodes.len() <= node {
            self.nodes.resize(node + 1, Node { lo, hi, count: 0 });
        }
        self.nodes[node] = Node { lo, hi, count: len as u32 };
        if let Some(halves) = subtree.halves() {
            let along_x = hi.x - lo.x > hi.y - lo.y;
            let key = |corner: u32| {
                let point = points[corner as usize];
                if along_x { point.x } else { point.y }
            };
            // Corners at equal places go by number, so that the tree depends on the polygon only.
            part.select_nth_unstable_by(len / 2, |&a, &b| {
                key(a).total_cmp(&key(b)).then(a.cmp(&b))
            });
            for half in halves {
                self.build(points, half);
            }
        }
    }

    /// Searches a subtree. Recurses as deep as the tree: the logarithm of the number of corners.
    fn any_below<P: Fn(u32) -> bool, B: Fn(u32) -> bool>(
        &mut self,
        subtree: Subtree,
        search: &mut Search<'_, P, B>,
    ) -> bool {
        *search.work += 1;
        let node = self.nodes[subtree.node];
        if node.count == 0 || node.is_outside(search.triangle) {
            return false;
        }
        if let Some(halves) = subtree.halves() {
            let found = halves.iter().any(|&half| self.any_below(half, search));
            self.nodes[subtree.node].count =
                halves.map(|half| self.nodes[half.node].count).iter().sum();
            return found;
        }
        let mut at = 0;
        let mut count = node.count as usize;
        let corners = &mut self.corners[subtree.first..];
        let mut found = false;
        while at < count && !found {
            *search.work += 1;
            if (search.is_present)(corners[at]) {
                found = (search.blocks)(corners[at]);
                at += 1;
            } else {
                count -= 1;
                corners.swap(at, count);
            }
        }
        self.nodes[subtree.node].count = count as u32;
        found
    }
}

impl Node {
    /// Tells whether a counterclockwise triangle and the box have no point in common; exact, though some
    /// boxes beside a triangle's corner are not recognised.
    fn is_outside(&self, triangle: [Point; 3]) -> bool {
        let Self { lo, hi, .. } = *self;
        let [a, b, c] = triangle;
        if a.x.max(b.x).max(c.x) < lo.x
            || a.x.min(b.x).min(c.x) > hi.x
            || a.y.max(b.y).max(c.y) < lo.y
            || a.y.min(b.y).min(c.y) > hi.y
        {
            return true;
        }
        [(a, b), (b, c), (c, a)].iter().any(|&(from, to)| {
            // The corner of the box that is farthest to the left of the edge.
            let x = if to.y > from.y { lo.x } else { hi.x };
            let y = if to.x > from.x { hi.y } else { lo.y };
            turn(from, to, Point { x, y }) < 0.0
        })
    }
}
