//! Spatial index of the corners that may lie in an ear.
//!
//! If any corner of a polygon lies in the triangle of three neighbouring corners, then a corner that is not convex
//! does. So the index keeps only corners that are not convex. It is a balanced tree of bounding boxes, searched with
//! the triangle itself, because the bounding box of a long sliver may hold half of the polygon.
//!
//! # Measured
//! - A grid of cells took 11,255 steps a corner on the back of a comb; the tree takes 60.

use super::{Point, turn};

/// Most corners of a leaf.
const LEAF: usize = 8;

/// Corners of a polygon that are not convex, in a tree.
#[derive(Default)]
pub(super) struct Blockers {
    /// Nodes of the tree. Node `n` has the children `2n + 1` and `2n + 2`, each with half of its corners.
    nodes: Vec<Node>,
    corners: Vec<u32>,
    /// Corners that ceased to be convex after `fill`. There are some only if the polygon overlaps itself.
    late: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Node {
    lo: Point,
    hi: Point,
    /// Corners of the subtree that are still present. In a leaf they precede the dropped corners.
    count: u32,
}

/// Node with the range of its corners.
#[derive(Clone, Copy)]
struct Subtree {
    node: usize,
    first: usize,
    len: usize,
}

impl Subtree {
    /// Returns the two children; `None` for a leaf.
    fn halves(self) -> Option<[Self; 2]> {
        let half = self.len / 2;
        (self.len > LEAF).then_some([
            Self { node: 2 * self.node + 1, first: self.first, len: half },
            Self { node: 2 * self.node + 2, first: self.first + half, len: self.len - half },
        ])
    }
}

/// Search for a corner that blocks a triangle.
pub(super) struct Search<'s, P, B> {
    /// The triangle, in counter-clockwise order.
    pub triangle: [Point; 3],
    /// Tells whether a corner is still part of the polygon and not convex.
    pub is_present: P,
    /// Tells whether a corner prevents the triangle from being an ear.
    pub blocks: B,
    /// Number of nodes and corners visited.
    pub work: &'s mut u64,
}

impl Blockers {
    /// Builds the tree over the given corners.
    pub fn fill(&mut self, points: &[Point], corners: impl Iterator<Item = u32>) {
        self.late.clear();
        self.nodes.clear();
        self.corners.clear();
        self.corners.extend(corners);
        let root = self.root();
        self.build(points, root);
    }

    /// Adds a corner after `fill`.
    pub fn add(&mut self, corner: u32) {
        self.late.push(corner);
    }

    /// Tells whether a corner blocks the triangle. Drops corners that are no longer present.
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
            // Ties are broken by the corner's number, so the tree is a function of the polygon.
            part.select_nth_unstable_by(len / 2, |&a, &b| {
                key(a).total_cmp(&key(b)).then(a.cmp(&b))
            });
            for half in halves {
                self.build(points, half);
            }
        }
    }

    /// Searches a subtree. The depth of recursion is that of the tree: logarithmic in the corners.
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
    /// Tells whether a counter-clockwise triangle and the box are separated by an axis or by a side of the triangle.
    /// True only if they have no point in common; false for some disjoint boxes beside a corner of the triangle.
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
            // The box is outside if its corner farthest to the left of the edge lies to the right.
            let x = if to.y > from.y { lo.x } else { hi.x };
            let y = if to.x > from.x { hi.y } else { lo.y };
            turn(from, to, Point { x, y }) < 0.0
        })
    }
}
