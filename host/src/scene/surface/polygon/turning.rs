//! Turning number: the number of full turns of an outline's direction.
//!
//! The number is 1 for every polygon that does not cross itself (Hopf's Umlaufsatz). A polygon that winds twice around
//! a part of the plane may have ears, but their triangles would overlap.

use super::{Point, turn};

/// Counts the full turns of a counter-clockwise outline. Returns `None` if the outline turns back on itself at a
/// corner, because half a turn has no side.
pub(super) fn number(points: &[Point]) -> Option<i64> {
    // 1. Remove corners that coincide with the next one.
    let mut corners: Vec<Point> = points.to_vec();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    let count = corners.len();
    let corner = |at: usize| corners[at % count];
    // 2. Count how often the direction crosses that of the x axis: plus 1 counter-clockwise, minus 1 clockwise.
    let mut turns = 0;
    for at in 0..count {
        let [a, b, c] = [corner(at), corner(at + 1), corner(at + 2)];
        let side = turn(a, b, c);
        match (is_upper(a, b), is_upper(b, c)) {
            (false, true) if side > 0.0 => turns += 1,
            (true, false) if side < 0.0 => turns -= 1,
            (true, false) | (false, true) if side == 0.0 => return None,
            _ => {}
        }
    }
    Some(turns)
}

/// Tells whether a direction's angle from the x axis is in `0..pi`.
fn is_upper(from: Point, to: Point) -> bool {
    to.y > from.y || (to.y == from.y && to.x > from.x)
}
