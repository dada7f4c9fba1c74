//! Ear clipping: ears are cut off one after the other.
//!
//! ```text
//!     v        An ear is a convex corner v whose triangle with its neighbours p and q holds no other
//!    / \       corner. Cutting it off shortens the polygon by one corner, and changes only p and q.
//!   p - q
//! ```
//! # How it is done
//! 1. Corners wait in a queue. If the first corner is an ear, it is cut off and its neighbours join the queue again.
//!    Otherwise it leaves the queue until a neighbour is cut off.
//! 2. A polygon that does not touch itself always has an ear (Meisters). A polygon that touches itself, such as an
//!    outline joined to a hole by an edge there and back, may have none. Then the conditions are relaxed step by step
//!    (`Strictness`).
//! 3. A corner that coincides with a neighbour, or at the tip of two edges that lie on each other, adds nothing to the
//!    outline and is cut off at once.
//!
//! # Invariants
//! No triangle is clockwise, so the areas of the triangles sum to the polygon's area.

use std::collections::VecDeque;

use super::blockers::{Blockers, Search};
use super::{Point, turn};

/// Most steps for each corner; a step visits one corner or box. Only polygons that cross themselves many times reach
/// this limit.
///
/// # Measured
/// - A comb and a spiral of 60,000 corners take up to 70 steps a corner.
pub(super) const WORK: u64 = 4096;

/// Condition under which corners may be cut off.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Strictness {
    /// An ear without another corner inside or on its sides.
    Closed,
    /// An ear of `Closed`, or a corner on the line between its neighbours.
    Straight,
    /// An ear without another corner inside; corners may lie on its sides.
    Open,
}

/// Remaining outline while ears are cut off. Its memory is reused from polygon to polygon.
#[derive(Default)]
pub(super) struct Ears {
    before: Vec<u32>,
    after: Vec<u32>,
    state: Vec<State>,
    queue: VecDeque<u32>,
    blockers: Blockers,
    /// Number of steps for the last polygon.
    pub work: u64,
}

/// State of a corner.
#[derive(Clone, Copy, Default)]
struct State {
    cut: bool,
    waiting: bool,
    /// True if the corner is not convex, so that it may block ears.
    blocks: bool,
}

impl Ears {
    /// Appends the triangles of a counter-clockwise polygon. Returns false if the polygon has no division into ears;
    /// the appended triangles are then meaningless.
    pub fn cut(&mut self, points: &[Point], triangles: &mut Vec<[usize; 3]>) -> bool {
        self.begin(points);
        let most_work = WORK * points.len() as u64;
        let mut strictness = Strictness::Closed;
        let mut progress = false;
        loop {
            // 1. Cut ears off until the queue is empty.
            while let Some(corner) = self.queue.pop_front() {
                self.state[corner as usize].waiting = false;
                if self.state[corner as usize].cut || !self.is_ear(points, corner, strictness) {
                    continue;
                }
                triangles.push(self.triangle(corner).map(|corner| corner as usize));
                if triangles.len() == points.len() - 2 {
                    return true;
                }
                self.remove(points, corner);
                progress = true;
                if strictness == Strictness::Open {
                    break;
                }
            }
            // 2. Put all corners into the queue again. If no ear was cut off since the last time, relax the condition.
            if self.work > most_work {
                return false;
            }
            strictness = match strictness {
                _ if progress => Strictness::Closed,
                Strictness::Closed => Strictness::Straight,
                Strictness::Straight => Strictness::Open,
                Strictness::Open => return false,
            };
            progress = false;
            self.requeue();
        }
    }

    fn begin(&mut self, points: &[Point]) {
        let count = points.len() as u32;
        self.work = 0;
        self.before.clear();
        self.before.extend((0..count).map(|corner| (corner + count - 1) % count));
        self.after.clear();
        self.after.extend((0..count).map(|corner| (corner + 1) % count));
        self.state.clear();
        self.state.resize(points.len(), State::default());
        for corner in 0..count {
            self.state[corner as usize].blocks = self.area(points, corner) <= 0.0;
        }
        let state = &self.state;
        self.blockers.fill(points, (0..count).filter(|&corner| state[corner as usize].blocks));
        self.queue.clear();
        self.requeue();
    }

    /// Puts all remaining corners into the queue, in their order.
    fn requeue(&mut self) {
        for (corner, state) in (0..).zip(&mut self.state) {
            if !state.cut && !state.waiting {
                state.waiting = true;
                self.queue.push_back(corner);
            }
        }
    }

    fn triangle(&self, corner: u32) -> [u32; 3] {
        [self.before[corner as usize], corner, self.after[corner as usize]]
    }

    fn area(&self, points: &[Point], corner: u32) -> f64 {
        let [p, v, q] = self.triangle(corner).map(|corner| points[corner as usize]);
        turn(p, v, q)
    }

    fn remove(&mut self, points: &[Point], corner: u32) {
        let [p, _, q] = self.triangle(corner);
        self.state[corner as usize].cut = true;
        self.after[p as usize] = q;
        self.before[q as usize] = p;
        for neighbour in [p, q] {
            let blocks = self.area(points, neighbour) <= 0.0;
            let state = &mut self.state[neighbour as usize];
            if blocks && !state.blocks {
                self.blockers.add(neighbour);
            }
            state.blocks = blocks;
            if !state.waiting {
                state.waiting = true;
                self.queue.push_back(neighbour);
            }
        }
    }

    fn is_ear(&mut self, points: &[Point], corner: u32, strictness: Strictness) -> bool {
        self.work += 1;
        let ids = self.triangle(corner);
        let [p, v, q] = ids.map(|id| points[id as usize]);
        let area = turn(p, v, q);
        if area < 0.0 {
            return false;
        }
        if area == 0.0 {
            // v coincides with a neighbour or is a tip, which are ears; or v lies between its neighbours.
            return !is_between(p, v, q) || strictness == Strictness::Straight;
        }
        let Self { before, after, state, blockers, work, .. } = self;
        let point = |id: u32| points[id as usize];
        let blocks = |id: u32| {
            let w = point(id);
            if ids.contains(&id) || w == p || w == q {
                return false;
            }
            if w == v {
                // Another part of the outline passes through v. It blocks the ear if it goes inside.
                let goes_inside = |x| turn(v, q, x) > 0.0 && turn(v, x, p) > 0.0;
                return goes_inside(point(before[id as usize]))
                    || goes_inside(point(after[id as usize]));
            }
            is_in_box(w, p, v, q) && {
                let sides = [turn(p, v, w), turn(v, q, w), turn(q, p, w)];
                match strictness {
                    Strictness::Open => sides.iter().all(|&side| side > 0.0),
                    _ => sides.iter().all(|&side| side >= 0.0),
                }
            }
        };
        let is_present = |id: u32| !state[id as usize].cut && state[id as usize].blocks;
        !blockers.any(&mut Search { triangle: [p, v, q], is_present, blocks, work })
    }
}

/// Tells whether `v`, which is collinear with `p` and `q`, lies strictly between them.
fn is_between(p: Point, v: Point, q: Point) -> bool {
    // Compares coordinates along an axis in which p and q differ, which is exact.
    let [p, v, q] = if p.x == q.x { [p.y, v.y, q.y] } else { [p.x, v.x, q.x] };
    (p < v && v < q) || (q < v && v < p)
}

fn is_in_box(w: Point, a: Point, b: Point, c: Point) -> bool {
    w.x >= a.x.min(b.x).min(c.x)
        && w.x <= a.x.max(b.x).max(c.x)
        && w.y >= a.y.min(b.y).min(c.y)
        && w.y <= a.y.max(b.y).max(c.y)
}
